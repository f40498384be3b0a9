"""Which frames a folder holds, by the names of its files: no image is read."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import FormatError, InputError
from ..number_words import counted
from .camera_files import IntrinsicsSpec
from .encodings import EncodingSpec, one_encoding
from .frame_source import FrameSource
from .frames import META_NAME
from .pairing import Pairs, natural, paired, told_apart
from .time_lists import MOST_APART_S, UNITS, associated, read_time_list

_COLOUR_FOLDERS = ("rgb", "color", "colour", "image", "images")
_DEPTH_FOLDERS = ("depth", "depths")

WHAT_A_FOLDER_HOLDS = (
    f"A folder of frames holds one of these: a folder for each frame, with {META_NAME} and its images, or with rgb.png "
    "and depth.png; a folder rgb (or color, colour, image) and a folder depth, with files of the same names or "
    "numbers; colour and depth files side by side, as 0001_rgb.png and 0001_depth.png; or rgb.txt and depth.txt, which "
    "list files by time."
)


@dataclass(frozen=True)
class Listing:
    """Frames of a folder.

    Attributes
    ----------
    sources : tuple of FrameSource
        Absolute paths; in the natural order of their names, or of time where that is known.
    notes : tuple of str
        What the user should know, a sentence each.
    """

    sources: tuple[FrameSource, ...]
    notes: tuple[str, ...] = ()


def list_frames(
    folder: str | os.PathLike[str],
    *,
    depth_units: float | None = None,
    encoding: EncodingSpec | None = None,
    invalid: float | None = None,
    intrinsics: IntrinsicsSpec | None = None,
) -> Listing:
    """Find the frames of a folder.

    It may hold a folder for each frame; a folder of colour and one of depth, matched by names or numbers; colour and
    depth files side by side; or lists of both by time, whose depth has 5000 units per metre unless others are given. A
    frame folder gives just itself.

    Parameters
    ----------
    folder : path-like
    depth_units, encoding, invalid : optional
        How the depth of all frames is read, as for `ilf.load_frame`. None takes what is known of each.
    intrinsics : optional
        Of all frames; anything that `ilf.io.intrinsics_from` takes.

    Raises
    ------
    InputError
        If there is no such folder, it cannot be read, it holds no frames, or its depth is stored in a way that would be
        misread.
    FormatError
        If it has lists by time that are damaged.

    Examples
    --------
    >>> from ilf.assets import asset_path
    >>> [Path(source.rgb).name for source in list_frames(asset_path("samples")).sources]
    ['room']
    """
    root = Path(folder).absolute()
    one_encoding(encoding, depth_units)
    how = FrameSource("", None, depth_units, intrinsics, encoding=encoding, invalid=invalid)
    content = _content(root)
    if META_NAME in content.files:
        return Listing((replace(how, rgb=str(root)),))
    _refuse_misread(root, content)
    if {"rgb.txt", "depth.txt"} <= content.files:
        return _by_time(root, how)
    pairs, notes = _side_by_side(root, content)
    found = [replace(how, rgb=rgb, depth=depth) for rgb, depth in pairs]
    if not found:
        folders = [_frame_in(os.path.join(root, name)) for name in sorted(content.folders, key=natural)]
        found = [replace(how, rgb=rgb, depth=depth) for frame in folders for rgb, depth in frame]
        if empty := sum(not frame for frame in folders):
            notes.append(
                f"{counted(empty, 'folder')} left out, with no colour and depth file that belong together, or several."
            )
    if not found:
        raise InputError(f"{root} holds no frames. {WHAT_A_FOLDER_HOLDS}")
    return Listing(tuple(found), tuple(notes))


@dataclass(frozen=True)
class _Content:
    files: frozenset[str]
    folders: tuple[str, ...]

    def folder(self, names: Iterable[str]) -> str | None:
        """The first of these folders that is there, in whatever case."""
        there = {name.lower(): name for name in self.folders}
        return next((there[name] for name in names if name in there), None)


def _content(folder: str | Path) -> _Content:
    """Names in a folder, without hidden ones."""
    try:
        with os.scandir(folder) as entries:
            shown = [(entry.name, _is_folder(entry)) for entry in entries if not entry.name.startswith(".")]
    except NotADirectoryError:
        raise InputError(f"{folder} is a file. Name the folder that holds the frames.") from None
    except FileNotFoundError:
        raise InputError(f"{folder}: there is no such folder. Check the name.") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{folder!s:.200}: cannot be read ({error}). Check the name and its permissions.") from error
    return _Content(
        frozenset(name for name, is_folder in shown if not is_folder),
        tuple(name for name, is_folder in shown if is_folder),
    )


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link that leads nowhere is no reason to list none of the others
        return False


def _refuse_misread(root: Path, content: _Content) -> None:
    """Raise for what looks like frames, and would give wrong depth."""
    why = ""
    if "scene_camera.json" in content.files:
        why = "scene_camera.json gives each frame a depth scale of its own, as in BOP"
    elif "intrinsics.txt" in content.files and {"image", "depth"} <= set(content.folders):
        why = "it looks like a frame of SUN RGB-D, whose depth is stored with its bits rotated"
    elif any(re.match(r"d-.*\.pgm$", name) for name in content.files):
        why = "it looks like raw files of NYU Depth, whose .pgm hold disparities"
    if why:
        raise InputError(
            f"{root} would be read wrongly: {why}. Convert depth to 16-bit PNG in millimetres, registered to colour."
        )


def _by_time(root: Path, how: FrameSource) -> Listing:
    colours, depths = read_time_list(root / "rgb.txt"), read_time_list(root / "depth.txt")
    pairs = associated(colours, depths)
    if not pairs:
        raise FormatError(
            f"{root}: no file of rgb.txt lies within {MOST_APART_S:g} s of one of depth.txt. Are they of one recording?"
        )
    notes = _told_lonely(Pairs(pairs, len(colours) - len(pairs), len(depths) - len(pairs)), f" {MOST_APART_S:g} s near")
    if how.depth_units is None and how.encoding is None:
        how = replace(how, depth_units=UNITS)
    sources = (replace(how, rgb=os.path.join(root, rgb), depth=os.path.join(root, depth)) for rgb, depth in pairs)
    said = f"{how.depth_units:g} units per metre" if how.encoding is None else f"the encoding {how.encoding}"
    return Listing(tuple(sources), (f"Depth is read with {said}.", *notes))


def _side_by_side(root: Path, content: _Content) -> tuple[list[tuple[str, str]], list[str]]:
    """Pairs of paths in two folders or in one, and what there is to say of them."""
    rgb, depth = content.folder(_COLOUR_FOLDERS), content.folder(_DEPTH_FOLDERS)
    if rgb is not None and depth is not None:
        at = os.path.join(root, rgb), os.path.join(root, depth)
        pairs = paired(*(_content(folder).files for folder in at))
    else:
        at = str(root), str(root)
        pairs = paired(*told_apart(content.files))._replace(lonely_colours=0)  # they may be anything
    paths = [(os.path.join(at[0], one), os.path.join(at[1], other)) for one, other in pairs.pairs]
    if not paths:
        return [], []
    notes = _told_lonely(pairs, " that name")
    if any(name.endswith(".pose.txt") for name in content.files):
        notes.append(
            "If these are frames of 7-Scenes: their depth is not registered to colour, and 65535 stands for missing "
            "there, but is read as 65.5 m."
        )
    return paths, notes


def _frame_in(folder: str) -> list[tuple[str, str | None]]:
    """The frame of a folder: itself if it has a meta.json, or the one pair in it; nothing if there is none, or more."""
    if os.path.isfile(os.path.join(folder, META_NAME)):
        return [(folder, None)]
    try:
        content = _content(folder)
    except InputError:
        return []
    pairs = paired(*told_apart(content.files)).pairs
    return [(os.path.join(folder, rgb), os.path.join(folder, depth)) for rgb, depth in pairs] if len(pairs) == 1 else []


def _told_lonely(pairs: Pairs, near: str) -> list[str]:
    counts = (("colour", "depth", pairs.lonely_colours), ("depth", "colour", pairs.lonely_depths))
    return [
        f"{count} {what} file{'s' * (count != 1)} left out: there is no {other} file of{near}."
        for what, other, count in counts
        if count
    ]
