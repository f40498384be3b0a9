"""Cutting a block along a line."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...blocks import Box
from .cracks import have_border
from .patches import LabelPatch, Labels, Mask, Points, box_of, patch_within

_NEAR = 3.0
"""How far [px] from a line's end the block's boundary may be for the line to be led there; straight on twice as far."""

_FRAGMENT = 16
"""Parts of up to so many pixels come of a trembling line, and go along wherever they lie."""


def split(
    labels: Labels,
    label: int,
    points: Points,
    locked: Collection[int] = (),
    first_new: int | None = None,
    near: float = _NEAR,
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
    near : float
        How far [px] from an end of the line the boundary may be for the line to be led there; straight on twice as far.
    """
    parted = None if label in locked else _part(labels, label, points, near)
    if parted is None:
        return None
    numbers = np.full(parted.sizes.size, label, np.int32)
    following = int(labels.max()) + 1 if first_new is None else first_new
    for piece in parted.pieces:
        for part in piece[1:]:
            numbers[part] = following
            following += 1
    return parted.patch(labels, numbers)


def cut_off(
    labels: Labels, source: int, points: Points, label: int, locked: Collection[int] = (), near: float = _NEAR
) -> LabelPatch | None:
    """Give a block what a line cuts off from another: of the parts beside it, all but the largest part.

    If the largest part alone is beside it, and has a border with it, that is what it gets; if none is, all parts but
    the largest. None if the line does not part the block `source`, if that is `label` itself, or if one of them is
    locked.

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
    near : float
        As in `split`; also how far [px] a part beside the block may be from it.
    """
    parted = None if label == source or {label, source} & set(locked) else _part(labels, source, points, near)
    if parted is None:
        return None
    taker = labels[parted.box] == label
    bordering = have_border(parted.parts, taker)
    distance = cv2.distanceTransform((~taker).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    beside = set(np.unique(parted.parts[distance <= max(near, 1.0)]).tolist())
    numbers = np.full(parted.sizes.size, source, np.int32)
    for largest, *others in parted.pieces:
        touching = [part for part in others if part in beside or parted.sizes[part] <= _FRAGMENT]
        if not touching:
            touching = [largest] if bordering[largest] else others
        numbers[touching] = label
    return parted.patch(labels, numbers)


def run_on(labels: Labels, label: int, points: Points, near: float = _NEAR) -> list[tuple[float, float]]:
    """A line whose ends in a block run on to the block's boundary, however far that is.

    They are led there as by `split` if it is near, and go straight on otherwise. It is no boundary where the block goes
    around another.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    label : int
        The block that is to be cut.
    points : sequence of (x, y)
        The line, two points or more.
    near : float
        As in `split`.

    Returns
    -------
    list of (x, y)
        The line with a point more at each end that has run on.
    """
    box = box_of(labels, label, rim=1)
    if box is None or len(points) < 2:
        return [(float(x), float(y)) for x, y in points]
    corner = box[1].start, box[0].start
    line = _led_on(labels[box] == label, np.asarray(points, np.float64) - corner, near, math.inf) + corner
    return [(float(x), float(y)) for x, y in line]


@dataclass(frozen=True, eq=False)
class _Parted:
    """A block that a line has cut.

    Attributes
    ----------
    box : tuple of slice
        Around the block.
    parts : ndarray of int32
        The number of the part at every pixel of the box; 0 off the block.
    sizes : ndarray of int
        Pixels of each part, by its number.
    pieces : list of list of int
        The parts of each connected piece of the block that the line has cut, the largest first.
    """

    box: Box
    parts: NDArray[np.int32]
    sizes: NDArray[np.intp]
    pieces: list[list[int]]

    def patch(self, labels: Labels, numbers: NDArray[np.int32]) -> LabelPatch | None:
        """The patch by which each part has a label of its own."""
        before = labels[self.box]
        return patch_within(self.box, before, np.where(self.parts > 0, numbers[self.parts], before).astype(np.int32))


def _part(labels: Labels, label: int, points: Points, near: float) -> _Parted | None:
    """A block in the parts that a line cuts it into; None if it stays whole."""
    box = None if label <= 0 or len(points) < 2 else box_of(labels, label, rim=1)
    if box is None:
        return None
    block = labels[box] == label
    line = np.asarray(points, np.float64) - (box[1].start, box[0].start)
    cut = block & _drawn(_led_on(block, line, near, 2 * near), block.shape)
    _, whole = cv2.connectedComponents(block.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    count, parts = cv2.connectedComponents((block & ~cut).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    sizes = np.bincount(parts.ravel(), minlength=count)
    piece_of = np.zeros(count, np.intp)
    piece_of[parts[block]] = whole[block]
    pieces = []
    for piece in np.unique(whole[cut]):
        found = np.flatnonzero(piece_of == piece)
        if np.count_nonzero(found) > 1:
            pieces.append(sorted(found[found > 0].tolist(), key=lambda number: -sizes[number]))
    if not pieces:
        return None
    return _Parted(box, np.where(block, _spread(parts, cut), 0).astype(np.int32), sizes, pieces)


def _drawn(line: NDArray[np.float64], shape: tuple[int, ...]) -> Mask:
    drawn = np.zeros(shape, np.uint8)
    path = np.floor(line).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(drawn, [path], isClosed=False, color=1, thickness=1, lineType=cv2.LINE_4)
    return drawn > 0


def _led_on(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    filled = _filled(block)
    before, after = (_beyond(filled, some, near, far) for some in (line[::-1], line))
    return np.concatenate([before, line, after])


def _filled(block: Mask) -> Mask:
    """A block with all that it goes around."""
    beyond = np.pad(block.astype(np.uint8), 1)
    cv2.floodFill(beyond, None, (0, 0), 2, flags=4)
    return np.asarray(beyond[1:-1, 1:-1] != 2, bool)


def _beyond(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    """The point off the block that a line's end is led on to; none where it needs none, or is too far from any.

    That straight on is up to twice as far as `near`; or else the nearest, up to `near`; or else that straight on, up to
    `far`.
    """
    end, nowhere = line[-1], np.empty((0, 2))
    if not _holds(block, end[None])[0]:
        return nowhere
    distance = np.hypot(*(line - end).T)
    direction = end - line[distance >= min(2 * near, distance.max())][-1]
    length = math.hypot(*direction)
    steps = np.arange(0.5, min(far, math.hypot(*block.shape)) + 0.5, 0.5) if length > 0 else np.empty(0)
    straight = end + steps[:, None] / max(length, 1e-9) * direction
    off = np.flatnonzero(~_holds(block, straight))[:1]
    if off.size and steps[off[0]] <= 2 * near:
        return straight[off]
    reach = math.ceil(near)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    around = np.stack([np.floor(end[0]) + right + 0.5, np.floor(end[1]) + down + 0.5], axis=-1).reshape(-1, 2)
    distance = np.hypot(*(around - end).T)
    distance[_holds(block, around)] = np.inf
    nearest = int(np.argmin(distance))
    return around[nearest : nearest + 1] if distance[nearest] <= near else straight[off]


def _holds(block: Mask, points: NDArray[np.float64]) -> Mask:
    """Which points (x, y), float (n, 2), lie in a block."""
    column, row = np.floor(points).astype(np.intp).T
    held = (row >= 0) & (row < block.shape[0]) & (column >= 0) & (column < block.shape[1])
    return held & block[np.where(held, row, 0), np.where(held, column, 0)]


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
