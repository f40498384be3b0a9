"""Cutting a block along a line."""

from __future__ import annotations

import math
from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from .patches import LabelPatch, Labels, Mask, Points, box_of, patch_within

_STRAIGHT_ON, _ASIDE = 6.0, 3.0
"""How far [px] short of the block's boundary a line may stop: along its last direction, and in any other."""


def split(
    labels: Labels, label: int, points: Points, locked: Collection[int] = (), first_new: int | None = None
) -> LabelPatch | None:
    """Cut a block along a line; the largest part keeps the label, the others get new ones.

    The line's own pixels go to the nearest part, and an end that stops a few pixels short of the block's boundary is
    led on to it. None if the line does not part the block.

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
    box = None if label in locked or label <= 0 or len(points) < 2 else box_of(labels, label, rim=1)
    if box is None:
        return None
    before = labels[box]
    block = before == label
    line = np.asarray(points, np.float64) - (box[1].start, box[0].start)
    cut = block & _drawn(_led_on(block, line), block.shape)
    _, before_parts = cv2.connectedComponents(block.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    count, parts = cv2.connectedComponents((block & ~cut).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    sizes = np.bincount(parts.ravel(), minlength=count)
    crossed = np.unique(before_parts[cut])
    whole = np.zeros(count, np.intp)  # which connected piece of the block a part is of
    whole[parts[block]] = before_parts[block]
    numbers = np.full(count, label, np.int32)
    following = int(labels.max()) + 1 if first_new is None else first_new
    for piece in crossed:
        found = np.flatnonzero(whole == piece)
        for part in sorted(found[found > 0], key=lambda number: -sizes[number])[1:]:
            numbers[part] = following
            following += 1
    if (numbers == label).all():
        return None
    return patch_within(box, before, np.where(block, numbers[_spread(parts, cut)], before).astype(np.int32))


def cut_off(labels: Labels, source: int, points: Points, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give a block what a line cuts off from another: all but the largest part of that.

    None if the line does not part the block `source`, if that is `label` itself, or if one of them is locked.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    source : int
        The block to cut.
    points : sequence of (x, y)
        The line, as in `split`.
    label : int
        The block that gets what is cut off.
    locked : collection of int
        Blocks that must not change.
    """
    parted = None if label in locked or label == source else split(labels, source, points, locked)
    if parted is None:
        return None
    after = np.where(parted.after != parted.before, label, parted.after)
    return LabelPatch(parted.box, parted.before, after.astype(np.int32))


def _drawn(line: NDArray[np.float64], shape: tuple[int, ...]) -> Mask:
    drawn = np.zeros(shape, np.uint8)
    path = np.floor(line).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(drawn, [path], isClosed=False, color=1, thickness=1, lineType=cv2.LINE_4)
    return drawn > 0


def _led_on(block: Mask, line: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([_beyond(block, line[::-1])[::-1], line, _beyond(block, line)])


def _beyond(block: Mask, line: NDArray[np.float64]) -> NDArray[np.float64]:
    """The point off the block that a line's end is led on to; none where it needs none, or is too far from any."""
    end, nowhere = line[-1], np.empty((0, 2))
    if not _holds(block, end):
        return nowhere
    back = line[np.hypot(*(line - end).T) >= min(4.0, np.hypot(*(line - end).T).max())]
    direction = end - back[-1]
    length = math.hypot(*direction)
    if length > 0:
        for step in np.arange(0.5, _STRAIGHT_ON + 0.5, 0.5):
            point = end + step / length * direction
            if not _holds(block, point):
                return point[None]
    reach = math.ceil(_ASIDE)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    points = np.stack([np.floor(end[0]) + right + 0.5, np.floor(end[1]) + down + 0.5], axis=-1).reshape(-1, 2)
    distance = np.hypot(*(points - end).T)
    off = [k for k in np.argsort(distance) if distance[k] <= _ASIDE and not _holds(block, points[k])]
    return points[off[:1]]


def _holds(block: Mask, point: NDArray[np.float64]) -> bool:
    column, row = (math.floor(value) for value in point)
    return 0 <= row < block.shape[0] and 0 <= column < block.shape[1] and bool(block[row, column])


def _spread(parts: NDArray[np.int32], cut: Mask) -> NDArray[np.int32]:
    """The parts with the line's pixels, each in the part that is nearest through other pixels of the line."""
    spread = np.pad(parts, 1)
    width = spread.shape[1]
    flat = spread.ravel()
    waiting = np.flatnonzero(np.pad(cut, 1))
    while waiting.size:
        found = np.zeros(waiting.size, flat.dtype)
        for step in (-1, 1, -width, width):
            found = np.where(found == 0, flat[waiting + step], found)
        if not found.any():
            break
        flat[waiting] = found
        waiting = waiting[found == 0]
    return spread[1:-1, 1:-1]
