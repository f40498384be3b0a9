"""Patches: changes of a label map inside a box that can be applied and reverted."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Box, bounds, grown, labels_in, moved, whole, within
from ...data.pixel_grids import different_labels, mark_both

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

    @property
    def touched(self) -> frozenset[int]:
        """Blocks that gain or lose pixels."""
        changed = self.before != self.after
        return labels_in(self.before[changed]) | labels_in(self.after[changed])

    def apply(self, labels: Labels) -> None:
        """Apply the change, in place."""
        labels[self.box] = self.after

    def revert(self, labels: Labels) -> None:
        """Revert the change, in place."""
        labels[self.box] = self.before


def patch_between(before: Labels, after: Labels) -> LabelPatch | None:
    """The smallest patch that turns one label map into another of the same shape; None if they are equal."""
    return patch_within(whole(before.shape), before, after)


def patch_within(box: Box, before: Labels, after: Labels) -> LabelPatch | None:
    """The smallest patch for a change from `before` to `after` inside a box of a map; None if they are equal."""
    inner = bounds(before != after)
    if inner is None:
        return None
    return LabelPatch(
        moved(inner, int(box[0].start), int(box[1].start)), before[inner].copy(), after[inner].astype(np.int32)
    )


def box_of(labels: Labels, label: int, rim: int = 0) -> Box | None:
    """The bounding box of a block, enlarged by a rim; None if there is no such block."""
    box = bounds(labels == label)
    return None if box is None else grown(box, rim, labels.shape)


def values_at(values: NDArray[Any], points: NDArray[np.float64], beyond: int) -> NDArray[Any]:
    """The values of the pixels under points (x, y); `beyond` for points outside."""
    column, row = np.floor(points).astype(np.intp).T
    held = (row >= 0) & (row < values.shape[0]) & (column >= 0) & (column < values.shape[1])
    return np.where(held, values[np.where(held, row, 0), np.where(held, column, 0)], beyond)


def unlocked_pixels(labels: Labels, locked: Collection[int]) -> Mask:
    """Pixels that belong to no locked block."""
    closed = list(locked)
    return ~np.isin(labels, closed) if closed else np.ones(labels.shape, bool)


# Borders of blocks that were drawn by hand, and how an edit updates them.
#
# A *border link* connects two neighbours of different labels along a row or a column. A pixel of a block is drawn if
# one of its border links was created by an edit; the filter then treats all of its border links as drawn.


def border_pixels(labels: Labels) -> Mask:
    """Pixels of blocks, bool (H, W), that have a 4-neighbour of another label in a map, int32 (H, W).

    Examples
    --------
    >>> border_pixels(np.array([[1, 1, 2, 0]])).tolist()
    [[False, True, True, False]]
    """
    return mark_both(different_labels(labels)) & (labels > 0)


def redrawn(drawn: Mask | None, labels: Labels, patch: LabelPatch) -> tuple[Box, Mask]:
    """Update the drawn pixels after an edit.

    A pixel is drawn after the edit if it belongs to a block and has a border link that did not exist before, or if it
    was drawn and still has a border link.

    Parameters
    ----------
    drawn : ndarray of bool, shape (H, W), or None
        The drawn pixels before; None if there are none.
    labels : ndarray of int32, shape (H, W)
        The label map, before or after the patch is applied.
    patch : LabelPatch
        The edit.

    Returns
    -------
    tuple of slice
        Rows and columns in which pixels may have changed: those of the patch, and one more on every side.
    ndarray of bool
        The drawn pixels in that box, to replace the old ones; keep the old ones to undo it.

    Examples
    --------
    >>> labels = np.array([[1, 1, 1, 2]], np.int32)
    >>> patch = LabelPatch((slice(0, 1), slice(1, 3)), labels[:, 1:3].copy(), np.array([[1, 2]], np.int32))
    >>> box, now = redrawn(None, labels, patch)
    >>> now.tolist()
    [[False, True, True, False]]
    """
    box = grown(patch.box, 1, labels.shape)
    around = grown(box, 1, labels.shape)
    before = labels[around].copy()
    after = before.copy()
    inside = within(patch.box, around)
    before[inside], after[inside] = patch.before, patch.after
    was, now = different_labels(before), different_labels(after)
    marked = mark_both((now[0] & ~was[0], now[1] & ~was[1]))
    if drawn is not None:
        marked |= drawn[around] & mark_both(now)
    return box, (marked & (after > 0))[within(box, around)]
