"""Shapes of other programs, which may overlap, as label maps: the smallest is on top; and folders of masks."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from .._runtime.formatting import counted, natural
from ..data.arrays import check_shape
from ..data.blocks import BlockInfo, Blocks, Box, Region, block_colour, cropped, labels_in, union
from ..errors import InputError
from .images import image_header, read_indices

LARGEST_LABEL = 65535
"""Label maps are written with 16 bits."""

UNNAMED = "block"
"""Name of a block without a name in formats that require one."""

_LONGEST_NAME = 80


Candidate = tuple[str, int | None, Iterable[Region]]
"""A candidate for a block: its name, "" for none; the label given in the file, if any; and its parts, which may overlap
and are iterated once, so that they can be computed on demand."""


def stacked(path: object, shape: tuple[int, int], candidates: Sequence[Candidate], notes: Iterable[str]) -> Blocks:
    """Stack candidates, smaller ones above larger ones, later ones above earlier ones of equal size.

    Raises
    ------
    InputError
        If there are more than 65535, or raised by their parts.
    """
    if len(candidates) > LARGEST_LABEL:
        raise InputError(f"{path} contains {len(candidates)} shapes, more than {LARGEST_LABEL}. Merge some.")
    numbers = _numbers([number for _, number, _ in candidates])
    numbered = ((number, parts) for number, (*_, parts) in zip(numbers, candidates, strict=True))
    labels, in_several, empty = _laid(shape, numbered)
    left = labels_in(labels)
    hidden = len(candidates) - empty - len(left)
    overlap = int(np.count_nonzero(in_several))
    found = [*notes]
    if overlap:
        found.append(f"In several shapes: {counted(overlap, 'pixel')}, of which the smallest shape is used.")
    if hidden:
        found.append(f"{counted(hidden, 'shape')} left out: smaller shapes cover all pixels.")
    if empty:
        found.append(f"{counted(empty, 'shape')} left out: no pixel centre lies inside.")
    if not left:
        found.append(f"{path} contains no blocks.")
    infos = {
        number: BlockInfo(name, block_colour(number))
        for number, (given, *_) in zip(numbers, candidates, strict=True)
        if number in left and (name := " ".join(given.split())[:_LONGEST_NAME]) not in {"", UNNAMED}
    }
    return Blocks(labels, infos, notes=tuple(found))


def _laid(
    shape: tuple[int, int], numbered: Iterable[tuple[int, Iterable[Region]]]
) -> tuple[NDArray[np.int32], NDArray[np.bool_], int]:
    """A label map of numbered blocks, whose masks are laid one at a time and not stored; the pixels of several; and how
    many blocks have no pixel."""
    labels, areas = np.zeros(shape, np.int32), np.full(shape, np.iinfo(np.int32).max, np.int32)
    overlap, scratch = np.zeros((2, *shape), bool)
    empty = 0
    for label, parts in numbered:
        box: Box | None = None
        for part in parts:
            scratch[part.box] |= part.mask
            box = part.box if box is None else union(box, part.box)
        if box is None or not (area := np.count_nonzero(scratch[box])):
            empty += 1
            continue
        mask = scratch[box].copy()
        scratch[box] = False
        overlap[box] |= mask & (labels[box] > 0)
        wins = mask & (area <= areas[box])
        labels[box][wins], areas[box][wins] = label, area
    return labels, overlap, empty


def _numbers(wanted: Sequence[int | None]) -> list[int]:
    """Return the requested labels, and free ones for the others; 1, 2, ... if the requested ones conflict."""
    given = [number for number in wanted if number is not None]
    if len(set(given)) < len(given) or not all(0 < number <= LARGEST_LABEL for number in given):
        return [*range(1, len(wanted) + 1)]
    free = itertools.filterfalse(set(given).__contains__, itertools.count(1))
    return [next(free) if number is None else number for number in wanted]


# A folder of masks, one PNG each, as written for an image by segment-anything and many other programs.


def blocks_of_mask_folder(folder: Path, shape: tuple[int, int]) -> Blocks:
    """Read the blocks of a folder: one per mask, named after the file unless its name is a number; non-zero pixels
    belong to the block.

    Raises
    ------
    InputError
        If there are no masks, or the size of one differs from `shape` (H, W), or it is not a mask.
    """
    pictures = (file for file in folder.iterdir() if file.suffix.lower() == ".png")
    files = sorted(pictures, key=lambda file: natural(file.name))
    if not files:
        raise InputError(f"{folder} contains no masks (one PNG each). If it has a JSON file of masks, give that.")
    candidates = [("" if file.stem.isdecimal() else file.stem, None, _part(file, shape)) for file in files]
    return stacked(folder, shape, candidates, ())


def _part(file: Path, shape: tuple[int, int]) -> Iterator[Region]:
    content = read_file(file)
    header = image_header(content, content.data.tobytes())
    check_shape(f"{file}: the mask", (header.height, header.width), shape, remedy="Use the masks of this frame.")
    image = read_indices(content)
    if image.ndim == 3:
        grey = image[..., 0]
        if np.any(image[..., :3] != grey[..., None]):
            raise InputError(f"{file} is a colour image, not a mask. Move such images out of the folder.")
        image = grey
    part = cropped(image > 0)
    if part is not None:
        yield part
