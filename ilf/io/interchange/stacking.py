"""What other programs' files hold, masks that may overlap, -> a label map: the smallest lies on top."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

LARGEST_LABEL = 65535
"""Label maps are written with 16 bits."""

UNNAMED = "block"
"""What a block without a name is called in formats that want one."""

_LONGEST_NAME = 80


class Part(NamedTuple):
    """Pixels on a box (rows, columns) of the image."""

    box: tuple[slice, slice]
    mask: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Candidate:
    """What may become a block.

    Attributes
    ----------
    name : str
        "" for none.
    number : int or None
        The label that it should have, if the file says one.
    parts : iterable of Part
        Read once, when its turn comes: parts may be worked out then. They may overlap; together they are the block.
    """

    name: str
    number: int | None
    parts: Iterable[Part]


@dataclass(frozen=True, eq=False)
class LoadedBlocks:
    """The blocks of a file.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block.
    names : dict
        Label -> name, of those blocks that have one.
    notes : tuple of str
        What the user should know of how the file was read, a sentence each.
    """

    labels: NDArray[np.int32]
    names: dict[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def stacked(
    path: object, shape: tuple[int, int], candidates: Sequence[Candidate], notes: Iterable[str]
) -> LoadedBlocks:
    """Lay candidates over each other, the smaller on the larger, of equal ones the later on the earlier.

    Raises
    ------
    InputError
        If there are more than 65535 of them, or what their parts raise.
    """
    if len(candidates) > LARGEST_LABEL:
        raise InputError(
            f"{path} holds {len(candidates)} shapes; at most {LARGEST_LABEL} blocks are possible. Merge some."
        )
    numbers = _numbers([candidate.number for candidate in candidates])
    stack = _Stack(shape)
    empty = sum(not stack.add(number, one.parts) for number, one in zip(numbers, candidates, strict=True))
    left = frozenset(np.flatnonzero(np.bincount(stack.labels.ravel())).tolist()) - {0}
    hidden = len(candidates) - empty - len(left)
    overlap = int(np.count_nonzero(stack.overlap))
    found = [*notes]
    if overlap:
        found.append(f"{_counted(overlap, 'pixel lies', 'pixels lie')} in several shapes: each goes to the smallest.")
    if hidden:
        found.append(f"{_counted(hidden, 'shape is', 'shapes are')} left out: smaller ones cover all of it.")
    if empty:
        found.append(f"{_counted(empty, 'shape is', 'shapes are')} left out: no pixel's centre lies inside.")
    if not left:
        found.append(f"{path} holds no blocks.")
    names = {
        number: name
        for number, one in zip(numbers, candidates, strict=True)
        if number in left and (name := " ".join(one.name.split())[:_LONGEST_NAME]) not in {"", UNNAMED}
    }
    return LoadedBlocks(stack.labels, names, tuple(found))


def cropped(mask: NDArray[np.bool_], top: int = 0, left: int = 0) -> Part | None:
    """The pixels of a mask whose first pixel is (top, left) of the image, on their bounding box; None without any."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if rows.size == 0:
        return None
    inside = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    box = slice(inside[0].start + top, inside[0].stop + top), slice(inside[1].start + left, inside[1].stop + left)
    return Part(box, mask[inside])


class _Stack:
    """The label map so far. Masks come one at a time, in any order, and none is kept."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.labels = np.zeros(shape, np.int32)
        self.overlap = np.zeros(shape, bool)
        self._areas = np.full(shape, np.iinfo(np.int32).max, np.int32)
        self._scratch = np.zeros(shape, bool)

    def add(self, label: int, parts: Iterable[Part]) -> bool:
        """Lay one more down; False if it has no pixels."""
        box: tuple[slice, slice] | None = None
        for part in parts:
            self._scratch[part.box] |= part.mask
            box = part.box if box is None else (_joint(box[0], part.box[0]), _joint(box[1], part.box[1]))
        if box is None:
            return False
        mask = self._scratch[box].copy()
        self._scratch[box] = False
        labels, areas = self.labels[box], self._areas[box]
        self.overlap[box] |= mask & (labels > 0)
        area = np.count_nonzero(mask)
        wins = mask & (area <= areas)
        labels[wins], areas[wins] = label, area
        return bool(area)


def _joint(one: slice, other: slice) -> slice:
    return slice(min(one.start, other.start), max(one.stop, other.stop))


def _numbers(wanted: Sequence[int | None]) -> list[int]:
    """The labels that are wanted, and free ones for the others; 1, 2, ... if they cannot all be had."""
    given = [number for number in wanted if number is not None]
    if len(set(given)) < len(given) or not all(0 < number <= LARGEST_LABEL for number in given):
        return [*range(1, len(wanted) + 1)]
    free = itertools.filterfalse(set(given).__contains__, itertools.count(1))
    return [next(free) if number is None else number for number in wanted]


def _counted(count: int, one: str, several: str) -> str:
    return f"{count} {one if count == 1 else several}"
