"""What an edit gives: the change of a label map inside a box, to be made and taken back."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...blocks import Box

Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]
Points = Sequence[tuple[float, float]]
"""Points (x, y) in image coordinates: pixel (row r, column c) covers x in [c, c + 1), y in [r, r + 1)."""


@dataclass(frozen=True, eq=False)
class LabelPatch:
    """A change of a label map inside a box.

    Attributes
    ----------
    box : tuple of slice
        Rows and columns.
    before, after : ndarray of int32
        The labels inside the box.
    """

    box: Box
    before: Labels
    after: Labels

    def apply(self, labels: Labels) -> None:
        """Make the change, in place."""
        labels[self.box] = self.after

    def revert(self, labels: Labels) -> None:
        """Take the change back, in place."""
        labels[self.box] = self.before


def patch_between(before: Labels, after: Labels) -> LabelPatch | None:
    """The smallest patch that turns one label map into another of the same shape; None if they are equal."""
    height, width = before.shape
    return patch_within((slice(0, height), slice(0, width)), before, after)


def patch_within(box: Box, before: Labels, after: Labels) -> LabelPatch | None:
    """The smallest patch for a change from `before` to `after` inside a box of a map; None if they are equal."""
    inner = bounds(before != after)
    if inner is None:
        return None
    return LabelPatch(
        moved(inner, int(box[0].start), int(box[1].start)), before[inner].copy(), after[inner].astype(np.int32)
    )


def bounds(mask: Mask) -> Box | None:
    """The smallest box that holds all of a mask; None if it is empty."""
    rows = np.flatnonzero(mask.any(axis=1))
    if rows.size == 0:
        return None
    columns = np.flatnonzero(mask[rows[0] : rows[-1] + 1].any(axis=0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def moved(box: Box, down: int, right: int) -> Box:
    """A box moved by so many pixels."""
    rows, columns = box
    return slice(rows.start + down, rows.stop + down), slice(columns.start + right, columns.stop + right)


def grown(box: Box, by: int, shape: tuple[int, ...]) -> Box:
    """A box with a rim of so many pixels around it, as far as the image goes."""
    rows, columns = box
    return (
        slice(max(rows.start - by, 0), min(rows.stop + by, shape[0])),
        slice(max(columns.start - by, 0), min(columns.stop + by, shape[1])),
    )


def box_of(labels: Labels, label: int, rim: int = 0) -> Box | None:
    """The box of a block with a rim around it; None if there is no such block."""
    box = bounds(labels == label)
    return None if box is None else grown(box, rim, labels.shape)


def free_of(labels: Labels, locked: Collection[int]) -> Mask:
    """Pixels that belong to no locked block."""
    closed = list(locked)
    return ~np.isin(labels, closed) if closed else np.ones(labels.shape, bool)
