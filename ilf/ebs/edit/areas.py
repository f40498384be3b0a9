"""Areas of pixels that go to a block: what a brush has swept, what a line goes around, a piece."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from .brush import Stroke
from .patches import LabelPatch, Labels, Mask, Points, bounds, free_of, patch_within


def paint(labels: Labels, stroke: Stroke, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give the stroke's pixels to a block (0 takes them from every block), except those of locked blocks."""
    before = labels[stroke.box]
    return patch_within(
        stroke.box, before, np.where(stroke.mask & free_of(before, locked), label, before).astype(np.int32)
    )


def give(labels: Labels, piece_mask: Mask, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give a piece, bool (H, W), to a block (0 takes it from every block), except pixels of locked blocks.

    None also where the block itself is locked.
    """
    box = bounds(piece_mask)
    if box is None or label in locked:
        return None
    return paint(labels, Stroke(box, piece_mask[box]), label, locked)


def assign_outline(labels: Labels, points: Points, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give all that a closed line goes around to a block, except pixels of locked blocks.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    points : sequence of (x, y)
        The line; its last point is joined to its first. Pixels whose centre it goes around count; where it crosses
        itself, those that it goes around an odd number of times. It may leave the frame.
    label : int
        The block, which may be a new one; 0 for none.
    locked : collection of int
        Blocks that must not change; None if `label` is one.
    """
    if label in locked:
        return None
    inside = inside_outline(labels.shape, points)
    return None if inside is None else paint(labels, inside, label, locked)


def inside_outline(shape: tuple[int, ...], points: Points) -> Stroke | None:
    """Pixels whose centre a closed line goes around, an odd number of times where it crosses itself; None for none."""
    line = np.asarray(points, np.float64).reshape(-1, 2)
    if len(line) < 3:
        return None
    left, top = np.floor(np.maximum(line.min(axis=0), 0)).astype(int)
    right, bottom = np.ceil(np.minimum(line.max(axis=0), (shape[1], shape[0]))).astype(int)
    if left >= right or top >= bottom:
        return None
    mask = parity(line - (left, top), (bottom - top, right - left))
    if not mask.any():
        return None
    return Stroke((slice(int(top), int(bottom)), slice(int(left), int(right))), mask)


def parity(line: np.ndarray, shape: tuple[int, int]) -> Mask:
    """Pixels of an image whose centre a closed line (n, 2) of (x, y) goes around an odd number of times.

    From left to right along the centres of every row, each crossing of the line turns outside to inside and back.
    """
    height, width = shape
    start, end = line, np.roll(line, -1, axis=0)
    upper, lower = (np.where((start[:, 1] <= end[:, 1])[:, None], *pair) for pair in ((start, end), (end, start)))
    # rows whose centre r + 0.5 lies in [upper, lower)
    first = np.clip(np.ceil(upper[:, 1] - 0.5), 0, height).astype(np.intp)
    stop = np.clip(np.ceil(lower[:, 1] - 0.5), 0, height).astype(np.intp)
    crossed = np.maximum(stop - first, 0)
    edge = np.repeat(np.arange(len(line)), crossed)
    row = np.arange(edge.size) - np.repeat(np.cumsum(crossed) - crossed, crossed) + first[edge]
    (x0, y0), (x1, y1) = upper[edge].T, lower[edge].T
    x = x0 + (row + 0.5 - y0) / (y1 - y0) * (x1 - x0)
    column = np.clip(np.ceil(x - 0.5), 0, width).astype(np.intp)
    turns = np.bincount(row * (width + 1) + column, minlength=height * (width + 1)).reshape(height, width + 1)
    return np.cumsum(turns[:, :width], axis=1) % 2 > 0
