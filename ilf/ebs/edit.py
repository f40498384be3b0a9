"""Pure edits of a label map. Each gives a patch that can be applied and reverted, or None if nothing changes.

Blocks that are locked keep every pixel they have, whatever the edit.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ..blocks import Box

Labels = NDArray[np.int32]
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


@dataclass(frozen=True, eq=False)
class Stroke:
    """Pixels that a brush has swept: a box of the frame and a mask inside it."""

    box: Box
    mask: NDArray[np.bool_]


def patch_between(before: Labels, after: Labels) -> LabelPatch | None:
    """The smallest patch that turns one label map into another of the same shape; None if they are equal."""
    changed = before != after
    rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    if rows.size == 0:
        return None
    box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
    return LabelPatch(box, before[box].copy(), after[box].copy())


def brush_stroke(shape: tuple[int, int], points: Points, radius: float) -> Stroke | None:
    """Pixels whose centre lies within `radius` [px] of the line through `points`; None if all are off the frame.

    The pixel under each end of a segment always belongs to it, so a tiny brush still paints.
    """
    path = np.asarray(points, np.float64)
    reach = radius + 1
    top, left = np.floor(path[:, ::-1].min(axis=0) - reach).astype(int)
    bottom, right = np.ceil(path[:, ::-1].max(axis=0) + reach).astype(int)
    top, left = max(top, 0), max(left, 0)
    bottom, right = min(bottom, shape[0]), min(right, shape[1])
    if top >= bottom or left >= right:
        return None
    centre_y, centre_x = np.mgrid[top:bottom, left:right] + 0.5
    mask = np.zeros(centre_x.shape, bool)
    for start, end in zip(path, path[1:] if len(path) > 1 else path, strict=False):
        mask |= _near_segment(centre_x, centre_y, start, end, radius)
    for x, y in path:
        row, column = int(np.floor(y)) - top, int(np.floor(x)) - left
        if 0 <= row < mask.shape[0] and 0 <= column < mask.shape[1]:
            mask[row, column] = True
    if not mask.any():
        return None
    return Stroke((slice(int(top), int(bottom)), slice(int(left), int(right))), mask)


def paint(labels: Labels, stroke: Stroke, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give the stroke's pixels to a block (0 takes them from every block), except those of locked blocks."""
    before = labels[stroke.box].copy()
    target = stroke.mask & (before != label) & ~np.isin(before, list(locked))
    return _patch(stroke.box, before, target, label)


def erase(labels: Labels, stroke: Stroke, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Take the stroke's pixels from one block; they belong to no block afterwards."""
    if label in locked:
        return None
    before = labels[stroke.box].copy()
    return _patch(stroke.box, before, stroke.mask & (before == label), 0)


def delete(labels: Labels, chosen: Collection[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Dissolve blocks: their pixels belong to no block afterwards."""
    doomed = [label for label in chosen if label not in locked and label > 0]
    return patch_between(labels, np.where(np.isin(labels, doomed), 0, labels).astype(np.int32))


def merge(labels: Labels, chosen: Sequence[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Join blocks under the first label of `chosen`. Locked blocks take no part."""
    free = [label for label in chosen if label not in locked and label > 0]
    if len(free) < 2:
        return None
    return patch_between(labels, np.where(np.isin(labels, free), free[0], labels).astype(np.int32))


def split(
    labels: Labels, label: int, points: Points, locked: Collection[int] = (), first_new: int | None = None
) -> LabelPatch | None:
    """Cut a block along a line; the largest part keeps the label, the others get new ones.

    The line's own pixels go to the nearest part. None if the line does not part the block.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    label : int
        The block to cut.
    points : sequence of (x, y)
        The line, two points or more.
    locked : collection of int
        Blocks that must not change.
    first_new : int, optional
        Number of the first new block; one more than the largest label if left out.
    """
    block = labels == label
    if label in locked or label == 0 or not block.any():
        return None
    line = np.zeros(labels.shape, np.uint8)
    path = np.floor(np.asarray(points, np.float64)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], isClosed=False, color=1, thickness=1, lineType=cv2.LINE_4)
    cut = block & (line > 0)
    _, before_parts = cv2.connectedComponents(block.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    count, parts = cv2.connectedComponents((block & ~cut).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    after = labels.copy()
    following = int(labels.max()) + 1 if first_new is None else first_new
    sizes = np.bincount(parts.ravel(), minlength=count)
    for piece in np.unique(before_parts[cut]):
        inside = before_parts == piece
        found = np.unique(parts[inside & (parts > 0)])
        if found.size < 2:
            continue
        nearest = distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
        spread = np.where(inside & cut, parts[tuple(nearest)], parts)
        for part in sorted(found, key=lambda number: -sizes[number])[1:]:
            after[inside & (spread == part)] = following
            following += 1
    return patch_between(labels, after)


def _patch(box: Box, before: Labels, target: NDArray[np.bool_], label: int) -> LabelPatch | None:
    if not target.any():
        return None
    return LabelPatch(box, before, np.where(target, label, before).astype(np.int32))


def _near_segment(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    radius: float,
) -> NDArray[np.bool_]:
    along = end - start
    length = float(along @ along)
    share = 0.0 if length == 0 else np.clip(((x - start[0]) * along[0] + (y - start[1]) * along[1]) / length, 0, 1)
    off_x, off_y = x - start[0] - share * along[0], y - start[1] - share * along[1]
    return off_x**2 + off_y**2 <= radius**2
