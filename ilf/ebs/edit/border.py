"""Drawing the border between two blocks anew.

The drawn line, led to the old border at both ends, and the stretch of the old border between those ends go around the
swept areas: what lies inside an odd number of times changes hands, so the line may cross the old border at will.
"""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.spatial import cKDTree
from skimage.measure import label as connected_regions

from .areas import parity
from .cracks import OFF_FRAME, CrackPaths, Cracks, find_cracks, have_border
from .patches import LabelPatch, Labels, Mask, Points, bounds, grown, patch_within

_BEYOND_CROP = -2
"""In place of a label, where the label map goes on beyond what is looked at."""

_SHORTEST = 3.0
"""Length [px] from which on a line can be a border."""

_RIM = 150, 300
"""How far [px] around a line the old border is looked at: half the line's length, but at least and at most so far."""

_CLOSES = 0.1
"""Share of a line's length that its ends may be apart for it to be closed."""

_REACH, _REACH_SHARE = 16.0, 0.25
"""How far the ends of a line may be off the border that it is about: pixels, or a share of its length if larger; twice
that where both blocks end."""

_AT_OUTLINE = 6.0
"""How near [px] to another block or to the frame's rim an end of the line may be to be led there."""

_AROUND, _NEAR_END = 3.0, 4.0
"""How far from there it may be to the border along the outline: a multiple of the straight way, and pixels more."""

_OFF_PAIR = 25.0
"""What a line that runs through other blocks counts in the choice of the pair, in pixels off the border."""

_ALONG_BORDER, _ALONG_OUTLINE = 0.05, 1.0
"""Cost of a path per pixel along the border of the pair, and along its outline to others."""


def redraw_border(labels: Labels, points: Points, locked: Collection[int] = ()) -> LabelPatch | None:
    """Move a stretch of the border between two blocks to where a line is drawn.

    The areas between the line and the old border change hands, and nothing else does. What that cuts off from its
    block goes to the other one, too. Nothing goes to a block that it touches at a point only.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    points : sequence of (x, y)
        The stretch as it should be, over or beside the old border, which it may cross. Its ends are led to the old
        border, or to the neighbouring block or the frame's rim that they are at. It may leave the frame.
    locked : collection of int
        Blocks that must not change.

    Returns
    -------
    LabelPatch or None
        None if the line is near no border, if one of the two blocks is locked, or if nothing changes. One of the two
        may be 0, no block.
    """
    line = _dense(np.asarray(points, np.float64).reshape(-1, 2))
    length = 0.5 * (len(line) - 1)
    if length < _SHORTEST or not np.isfinite(line).all():
        return None
    rim = int(np.clip(length / 2, *_RIM))
    low, high = np.floor(line.min(axis=0)).astype(int), np.ceil(line.max(axis=0)).astype(int) + 1
    box = grown((slice(low[1], high[1]), slice(low[0], high[0])), rim, labels.shape)
    if box[0].start >= box[0].stop or box[1].start >= box[1].stop:
        return None
    padded = _padded(labels, box)
    line = line - (box[1].start - 1, box[0].start - 1)
    after = _redrawn(padded, line, length, locked)
    if after is None:
        return None
    inner = slice(1, -1), slice(1, -1)
    return patch_within(box, padded[inner], after[inner])


def _dense(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points every half pixel along a line; none of a line without length."""
    if len(line) < 2:
        return np.empty((0, 2))
    if np.hypot(*(line[-1] - line[0])) <= _CLOSES * np.hypot(*np.diff(line, axis=0).T).sum():
        line = np.concatenate([line, line[:1]])
    steps = np.hypot(*np.diff(line, axis=0).T)
    line, steps = line[np.append(True, steps > 0)], steps[steps > 0]
    if steps.size == 0:
        return np.empty((0, 2))
    along = np.append(0.0, np.cumsum(steps))
    # the given points stay, so that corners are as drawn
    wanted = np.union1d(along, np.arange(0.0, along[-1], 0.5))
    return np.stack([np.interp(wanted, along, line[:, k]) for k in range(2)], axis=1)


def _padded(labels: Labels, box: tuple[slice, slice]) -> Labels:
    """The labels in a box with a rim of one pixel that tells the frame's rim from where the map goes on."""
    padded = np.pad(labels[box], 1, constant_values=_BEYOND_CROP)
    rows, columns = box
    if rows.start == 0:
        padded[0] = OFF_FRAME
    if rows.stop == labels.shape[0]:
        padded[-1] = OFF_FRAME
    if columns.start == 0:
        padded[:, 0] = OFF_FRAME
    if columns.stop == labels.shape[1]:
        padded[:, -1] = OFF_FRAME
    return padded


def _redrawn(labels: Labels, line: NDArray[np.float64], length: float, locked: Collection[int]) -> Labels | None:
    cracks = find_cracks(labels)
    cracks = cracks[(cracks.sides[:, 0] != _BEYOND_CROP) & ((cracks.sides >= 0).any(axis=1))]
    under = _labels_under(labels, line)
    pair = _pair(cracks, line, under, length)
    if pair is None or set(pair) & set(locked):
        return None
    inside = np.flatnonzero(np.isin(under, pair))
    line = line[inside[0] : inside[-1] + 1]
    cracks = _in_one_piece(cracks[np.isin(cracks.sides, pair).any(axis=1)], pair, line)
    between = _between(cracks, pair)
    paths = CrackPaths(cracks, np.where(between, _ALONG_BORDER, _ALONG_OUTLINE))
    trimmed = inside[0] > 0, inside[-1] < len(under) - 1
    one, other = (_joint(paths, point, between, cut) for point, cut in zip((line[0], line[-1]), trimmed, strict=True))
    best: Labels | None = None
    for stretch in _stretches(paths, one, other, between):
        old = paths.line(one, stretch)
        swept = parity(np.concatenate([line, old[::-1]]), (labels.shape[0], labels.shape[1]))
        after = _swapped(labels, swept, pair, cracks[stretch])
        if best is None or np.count_nonzero(after != labels) < np.count_nonzero(best != labels):
            best = after
    return None if best is None else _without_fragments(labels, _where_they_touch(labels, best, pair), pair)


def _labels_under(labels: Labels, line: NDArray[np.float64]) -> NDArray[np.int32]:
    column, row = np.floor(line).astype(np.intp).T
    held = (row >= 0) & (row < labels.shape[0]) & (column >= 0) & (column < labels.shape[1])
    return np.where(held, labels[np.where(held, row, 0), np.where(held, column, 0)], OFF_FRAME)


def _pair(cracks: Cracks, line: NDArray[np.float64], under: NDArray[np.int32], length: float) -> tuple[int, int] | None:
    """The two labels whose border the line runs along, both ends near it; None if there are none."""
    reach = max(_REACH, _REACH_SHARE * length)
    sparse = np.unique(np.append(np.arange(0, len(line), 4), len(line) - 1))
    best, least = None, np.inf
    borders = cracks[(cracks.sides[:, 0] >= 0)]
    pairs, owner = np.unique(borders.sides, axis=0, return_inverse=True)
    for number, pair in enumerate(pairs):
        if np.count_nonzero(owner == number) < _SHORTEST:
            continue  # what touches at a point has no border to be moved
        inside = np.flatnonzero(np.isin(under, pair))
        if inside.size < len(line) / 2:
            continue
        distance = np.asarray(cKDTree(borders.middle[owner.ravel() == number]).query(line[sparse])[0])
        ends = [(line[inside[k]], distance[np.searchsorted(sparse, inside[k])]) for k in (0, -1)]
        cost = float(np.mean(distance)) + sum(off for _, off in ends) + _OFF_PAIR * (1 - inside.size / len(line))
        if cost < least and all(off <= reach * (1 + _at_outline(cracks, pair, end)) for end, off in ends):
            best, least = (int(pair[0]), int(pair[1])), cost
    return best


def _at_outline(cracks: Cracks, pair: NDArray[np.int32], point: NDArray[np.float64]) -> bool:
    """Whether a point is at the outline of two blocks, where a line can only be meant to part them."""
    outline = cracks.middle[np.isin(cracks.sides, pair).sum(axis=1) == 1]
    return bool(np.any(np.hypot(*(outline - point).T) <= _AT_OUTLINE))


def _between(cracks: Cracks, pair: tuple[int, int]) -> NDArray[np.bool_]:
    """Which cracks are the border between two labels."""
    return np.asarray(np.isin(cracks.sides, pair).all(axis=1))


def _in_one_piece(cracks: Cracks, pair: tuple[int, int], line: NDArray[np.float64]) -> Cracks:
    """Those cracks that are connected with the stretch of border to which the ends of the line are nearest."""
    parts = CrackPaths(cracks, np.ones(len(cracks.start))).parts()
    middle, between = cracks.middle, _between(cracks, pair)
    off = np.full((2, int(parts.max()) + 1), np.inf)
    for some, end in zip(off, (line[0], line[-1]), strict=True):
        np.minimum.at(some, parts[between], np.hypot(*(middle[between] - end).T))
    return cracks[parts == np.argmin(off.sum(axis=0))]


def _swapped(labels: Labels, swept: Mask, pair: tuple[int, int], stretch: Cracks) -> Labels:
    """The map in which areas of a pair of labels inside what is swept change hands, if they are at a stretch of border.

    What lies amidst such an area has the label already that all around it gets.
    """
    after = labels.copy()
    box = bounds(swept)
    if box is None:
        return after
    inside = np.where(swept & np.isin(labels, pair), labels + 1, 0)
    areas = np.zeros(labels.shape, np.int32)
    areas[box] = connected_regions(inside[box], background=0, connectivity=1)
    # the pixels right of and left of an upright crack, below and above a level one
    column, row = np.minimum(stretch.start, stretch.end).T
    upright = stretch.start[:, 0] == stretch.end[:, 0]
    at_stretch = np.zeros(int(areas.max()) + 1, bool)
    at_stretch[areas[row, column]] = True
    at_stretch[areas[row - ~upright, column - upright]] = True
    at_stretch[0] = False
    changing = at_stretch[areas] if len(stretch.start) else areas > 0
    after[changing & (labels == pair[0])] = pair[1]
    after[changing & (labels == pair[1])] = pair[0]
    return after


def _where_they_touch(before: Labels, after: Labels, pair: tuple[int, int]) -> Labels:
    """The map in which what has changed hands has its old label unless it has a border with the block that gets it."""
    kept = before == after
    for label, other in (pair, pair[::-1]):
        gained = ((before == label) & (after == other)).astype(np.uint8)
        areas = cv2.connectedComponents(gained, connectivity=4)[1].astype(np.int32)
        joined = have_border(areas, kept & (before == other))[areas]
        after = np.where((gained > 0) & ~joined, label, after).astype(np.int32)
    return after


def _joint(paths: CrackPaths, point: NDArray[np.float64], between: NDArray[np.bool_], trimmed: bool) -> int:
    """The corner that an end of the line is led to."""
    at_border, border_off = paths.nearest(point, between)
    if between.all():
        return at_border
    at_outline, outline_off = paths.nearest(point, ~between)
    if trimmed:
        return at_outline if outline_off < border_off else at_border
    if outline_off > _AT_OUTLINE or border_off < 1:
        return at_border
    # only where the border itself ends near by, the line is to end like it
    return at_outline if paths.length_to(at_outline, between) <= _AROUND * border_off + _NEAR_END else at_border


def _stretches(paths: CrackPaths, one: int, other: int, between: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The stretches of old border that the line may stand for: the shortest, and that the other way around a block."""
    if one == other:
        around = paths.around(one, between)
        return [np.empty(0, np.intp)] + ([] if around is None else [around])
    shortest = paths.between(one, other)
    if shortest is None:
        return []
    rest = paths.between(one, other, without=shortest[between[shortest]])
    return [found for found in (shortest, rest) if found is not None and between[found].any()]


def _without_fragments(before: Labels, after: Labels, pair: tuple[int, int]) -> Labels:
    """The map in which what has been cut off from its block belongs to the other one, if it has a border with that."""
    box = bounds(before != after)
    if box is None:
        return after
    for label, other in (pair, pair[::-1]):
        count, new = cv2.connectedComponents((after == label).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
        if count == 2:
            continue
        parts, old = cv2.connectedComponents((before == label).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
        stays = (old > 0) & (new > 0)
        anchored = np.zeros(count, bool)
        # of each old part the largest rest keeps its block, and so does what goes on beyond the crop
        shared = coo_array((np.ones(np.count_nonzero(stays)), (old[stays], new[stays])), shape=(parts, count)).tocsr()
        anchored[np.unique(np.asarray(shared.argmax(axis=1)).ravel()[shared.max(axis=1).toarray().ravel() > 0])] = True
        anchored[new[cv2.dilate((before == _BEYOND_CROP).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0]] = True
        loose = ~anchored
        loose[0] = False
        after = np.where((loose & have_border(new, after == other))[new], other, after).astype(np.int32)
    return after
