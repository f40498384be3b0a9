"""A folder of masks, one PNG each, as segment-anything and many others write it for an image."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...errors import FormatError, InputError
from ..files import read_file
from ..headers import image_header
from ..images import read_image
from .stacking import Candidate, LoadedBlocks, Part, cropped, stacked

METADATA = "metadata.csv"
"""segment-anything's list of its masks, by which other pictures in the folder are told from them."""


def blocks_of_mask_folder(folder: Path, shape: tuple[int, int]) -> LoadedBlocks:
    """The blocks of a folder: one per mask, named as the file unless that is a number; what is not 0 belongs to it.

    Raises
    ------
    InputError
        If there are no masks, or one is missing, has another size than `shape` (H, W), or is no mask.
    """
    pictures = (file for file in folder.iterdir() if file.suffix.lower() == ".png")
    files = _listed(folder) or sorted(pictures, key=_natural)
    if not files:
        raise InputError(f"{folder} holds no masks, a PNG each. If it holds a file of them (JSON), name that.")
    candidates = [Candidate("" if file.stem.isdecimal() else file.stem, None, _part(file, shape)) for file in files]
    return stacked(folder, shape, candidates, ())


def _listed(folder: Path) -> list[Path]:
    """The masks that the list names; none without one."""
    if not (folder / METADATA).is_file():
        return []
    try:
        text = read_file(folder / METADATA).data.tobytes().decode("utf-8-sig")
        ids = [row["id"].strip() for row in csv.DictReader(text.splitlines())]
    except (UnicodeDecodeError, csv.Error, KeyError, AttributeError):
        raise FormatError(
            f"{folder / METADATA} has no column 'id' that names the masks. Correct or remove it."
        ) from None
    # the names stay in the folder, whatever the list says
    return [folder / f"{Path(one).name}.png" for one in ids]


def _part(file: Path, shape: tuple[int, int]) -> Iterator[Part]:
    content = read_file(file)
    header = image_header(content, content.data.tobytes())
    if (header.height, header.width) != shape:
        raise InputError(
            f"{file}: the mask is {header.width} x {header.height}, the frame {shape[1]} x {shape[0]}. "
            "Use the masks of this frame."
        )
    image = read_image(content)
    if image.ndim == 3:
        grey = image[..., 0]
        if np.any(image[..., :3] != grey[..., None]):
            raise InputError(f"{file} is a coloured picture, no mask. Move pictures out of the folder.")
        image = grey
    part = cropped(image > 0)
    if part is not None:
        yield part


def _natural(file: Path) -> list[tuple[str, int]]:
    """2 before 10, and both before words."""
    return [(text, int(digits or 0)) for digits, text in re.findall(r"(\d{1,18})|(\D+)", file.name)]
