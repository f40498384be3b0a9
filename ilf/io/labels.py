"""Label maps as 16-bit PNG, masks, and conversion of overlapping shapes to label maps."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import FileSource, read_file
from .._runtime.formatting import counted, natural
from ..data.arrays import check_shape, plain_array
from ..data.blocks import BlockInfo, Blocks, Box, Region, block_colour, cropped, labels_in, union
from ..errors import ExportError, FormatError, InputError
from .images import encode_image, image_header, read_indices


def encode_mask(mask: NDArray[np.bool_]) -> bytes:
    """Return a mask (H, W) as 8-bit PNG, 255 where it is True."""
    return encode_image(".png", 255 * plain_array(mask).astype(np.uint8))


def read_mask(path: FileSource, shape: tuple[int, int] | None = None) -> NDArray[np.bool_]:
    """Read a mask from an image with one channel of 8 or 16 bits, bool (H, W): True where it is not 0.

    Parameters
    ----------
    path : path-like or FileContent
    shape : (int, int), optional
        Required (H, W).

    Raises
    ------
    InputError, FormatError
        As `read_labels`.
    """
    return read_labels(path, shape, what="mask") > 0


def encode_labels(labels: ArrayLike) -> bytes:
    """Return a label map as PNG; raises ExportError if the labels do not fit into 16 bits."""
    return encode_image(".png", checked_for_writing(labels).astype(np.uint16))


def checked_for_writing(labels: ArrayLike) -> NDArray[np.int32]:
    """Return the label map as int32 (H, W); raise ExportError if it is invalid, or does not fit into 16 bits."""
    array = plain_array(labels)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iu":
        raise ExportError(f"Labels must be integers with shape (H, W), not {array.dtype} {array.shape}.")
    if array.min() < 0 or array.max() > 65535:
        raise ExportError(f"Labels to write must be 0 to 65535, not {array.min()} to {array.max()}. Renumber them.")
    return array.astype(np.int32)


def read_labels(
    path: FileSource, shape: tuple[int, int] | None = None, *, what: str = "label map"
) -> NDArray[np.int32]:
    """Read a label map from a PNG with 8 or 16 bits, int32 (H, W); 0 = no block. The labels of a PNG with a palette are
    its indices.

    Parameters
    ----------
    path : path-like or FileContent
    shape : (int, int), optional
        Required (H, W).
    what : str
        Its name in messages.

    Raises
    ------
    InputError
        If the file does not exist or its size differs from `shape`.
    FormatError
        If it is damaged or not a label map.
    """
    image = read_indices(path)
    if image.ndim != 2 or image.dtype.kind != "u" or image.dtype.itemsize > 2:
        wanted = f"{path}: a {what} must have one channel with 8 or 16 bits, not {image.dtype} {image.shape}"
        raise FormatError(f"{wanted}. Export the values themselves, not a coloured image of them.")
    if shape is not None:
        check_shape(f"{path}: the {what}", image.shape, shape, remedy=f"Use the {what} of this frame.")
    return image.astype(np.int32)


# Conversion of masks that may overlap, from files of other programs, to a label map: the smallest is on top.

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
