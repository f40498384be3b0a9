"""Names of the files of frames, and names of frames from them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..errors import InputError
from ..io.depth import DEPTH_READERS

META_NAME = "meta.json"
"""File beside the images of a frame that states how they are read."""

CALIBRATION_NAME = "calibration.json"
"""File beside the images of a raw pair that states their two cameras."""

COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
USUAL_DEPTH_SUFFIXES = (".png", ".tif", ".tiff", ".pgm", ".npy")
DEPTH_FILE_SUFFIXES = tuple(dict.fromkeys((*USUAL_DEPTH_SUFFIXES, *DEPTH_READERS)))
"""Suffixes of colour files, of depth files that are likely nothing else, and of all depth files."""

_PLAIN_NAMES = frozenset({"rgb", "color", "colour", "image"})
"""File names that do not identify the frame."""


def name_from_path(rgb: Path) -> str:
    """The name of a frame by the absolute path of its colour file: the file's, or the folder's if that is generic.

    Examples
    --------
    >>> name_from_path(Path("/data/desk/rgb.png")), name_from_path(Path("/data/0001_rgb.png"))
    ('desk', '0001_rgb')
    """
    return rgb.parent.name if rgb.stem.lower() in _PLAIN_NAMES and rgb.parent.name else rgb.stem


def recorded_frame_name(path: Path, key: str) -> str:
    """The name of a frame of a recording.

    Examples
    --------
    >>> recorded_frame_name(Path("/data/desk.bag"), "12.033000000"), recorded_frame_name(Path("/shards"), "f0/rgb")
    ('desk 12.033000000', 'shards f0 rgb')
    """
    return " ".join([path.stem, *filter(None, key.split("/"))])


def no_frame_folder(place: object) -> InputError:
    """The error for a folder or an address that is asked for as a frame folder, and is none."""
    told = f"{place} has neither {META_NAME} nor rgb.* and depth.*"
    return InputError(f"{told}. Give the colour and the depth file, or the key of one of its frames (--frame).")


def by_stem(files: Iterable[Path]) -> dict[str, Path]:
    """Files by their names without extension, sorted; raises InputError if two have the same."""
    found: dict[str, Path] = {}
    for file in sorted(files):
        if (other := found.setdefault(file.stem, file)) is not file:
            raise InputError(f"{other} and {file.name} have the same name: leave one of them out.")
    return found
