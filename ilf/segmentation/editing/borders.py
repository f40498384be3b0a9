"""Redrawing the border between two blocks.

The drawn line, connected to the old border at both ends, and the section of the old border between these ends enclose
the swept areas. Pixels enclosed an odd number of times go to the other block, so the line may cross the old border.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from ...data.blocks import bounds, grown
from ...data.pixel_grids import connected_regions, different_labels, neighbours, odd_even_fill
from .patches import LabelPatch, Labels, Mask, Points, patch_within, values_at

# Cracks between pixels of different labels, which form the borders of blocks.
#
# A crack is one pixel long and lies between two neighbouring pixels; its ends are corners of pixels.

OFF_FRAME = -1
"""Value in place of a label outside the frame."""

_CONTACT, _CONTACT_SHARE = 3.0, 0.25
"""Minimum length [px] of contact for two areas to have a border; for small areas, this fraction of the square root of
the number of pixels is enough."""


@dataclass(frozen=True, eq=False)
class Cracks:
    """Cracks of a label map.

    Attributes
    ----------
    start, end : ndarray of int, shape (n, 2)
        Their ends (x, y).
    sides : ndarray of int32, shape (n, 2)
        The labels on both sides, the smaller first; `OFF_FRAME` outside the frame.
    """

    start: NDArray[np.intp]
    end: NDArray[np.intp]
    sides: NDArray[np.int32]

    @property
    def middle(self) -> NDArray[np.float64]:
        """Their midpoints (x, y), float64 (n, 2)."""
        return (self.start + self.end) / 2

    def __getitem__(self, chosen: Any) -> Cracks:
        """A selection of the cracks."""
        return Cracks(self.start[chosen], self.end[chosen], self.sides[chosen])


def find_cracks(labels: Labels) -> Cracks:
    """All cracks between pixels of different labels of a map with `OFF_FRAME` outside the frame."""
    rows, columns = np.nonzero(labels[:, :-1] != labels[:, 1:])
    upright = np.stack([columns + 1, rows], axis=1), np.stack([columns + 1, rows + 1], axis=1)
    beside = labels[rows, columns], labels[rows, columns + 1]
    rows, columns = np.nonzero(labels[:-1] != labels[1:])
    level = np.stack([columns, rows + 1], axis=1), np.stack([columns + 1, rows + 1], axis=1)
    above = labels[rows, columns], labels[rows + 1, columns]
    start, end = (np.concatenate(ends) for ends in zip(upright, level, strict=True))
    sides = np.sort(np.stack([np.concatenate(side) for side in zip(beside, above, strict=True)], axis=1), axis=1)
    return Cracks(start, end, sides)


def have_border(areas: NDArray[np.int32], other: Mask) -> Mask:
    """Which areas of a map have a border with some pixels, rather than only touching them at a point or two.

    Parameters
    ----------
    areas : ndarray of int32, shape (H, W)
        The number of the area at every pixel; 0 for none.
    other : ndarray of bool, shape (H, W)
        The pixels.

    Returns
    -------
    ndarray of bool, shape (N + 1,)
        Indexed by the number of the area; the first is False.
    """
    sizes = np.bincount(areas.ravel())
    lengths = np.zeros(sizes.size)
    for (one, _), (_, there) in neighbours(areas, other):
        lengths += np.bincount(one[there], minlength=sizes.size)
    found = (lengths > 0) & (lengths >= np.minimum(_CONTACT, _CONTACT_SHARE * np.sqrt(sizes)))
    found[0] = False
    return np.asarray(found, bool)


class CrackPaths:
    """Cheapest paths along cracks.

    Parameters
    ----------
    cracks : Cracks
    cost : ndarray of float64, shape (n,)
        Cost of each crack, > 0.
    """

    def __init__(self, cracks: Cracks, cost: NDArray[np.float64]) -> None:
        ends = np.concatenate([cracks.start, cracks.end])
        self.corners, numbers = np.unique(ends, axis=0, return_inverse=True)
        numbers = numbers.ravel()
        self._start, self._end = numbers[: len(cost)], numbers[len(cost) :]
        self._cost = cost

    def parts(self) -> NDArray[np.intp]:
        """The number of the connected component of every crack."""
        return np.asarray(connected_components(self._graph(self._cost), directed=False)[1], np.intp)[self._start]

    def _graph(self, cost: NDArray[np.float64], cracks: Any = slice(None)) -> csr_array:
        """The corners, with some cracks between them."""
        size = len(self.corners)
        return coo_array((cost, (self._start[cracks], self._end[cracks])), shape=(size, size)).tocsr()

    def nearest(self, point: NDArray[np.float64], among: NDArray[np.bool_]) -> tuple[int, float]:
        """The number of the corner nearest to a point (x, y), among the ends of some cracks, and its distance."""
        numbers = np.unique(np.concatenate([self._start[among], self._end[among]]))
        distance = np.hypot(*(self.corners[numbers] - point).T)
        best = int(np.argmin(distance))
        return int(numbers[best]), float(distance[best])

    def length_to(self, corner: int, among: NDArray[np.bool_]) -> float:
        """Length [px] of the path from a corner along other cracks to the nearest of some; infinite without one."""
        ways = self._graph(np.ones(np.count_nonzero(~among)), ~among)
        length = dijkstra(ways, directed=False, indices=np.array(corner))
        return float(length[np.concatenate([self._start[among], self._end[among]])].min())

    def between(self, one: int, other: int, without: NDArray[np.intp] | None = None) -> NDArray[np.intp] | None:
        """The numbers of the cracks of the cheapest path between two corners; None if there is none.

        Parameters
        ----------
        one, other : int
            Numbers of the corners.
        without : ndarray of int, optional
            Numbers of cracks that the path must not use.
        """
        used = np.ones(self._cost.size, bool)
        if without is not None:
            used[without] = False
        crack = np.flatnonzero(used)
        start, end = self._start[crack], self._end[crack]
        size, graph = len(self.corners), self._graph(self._cost[crack], crack)
        came_from = dijkstra(graph, directed=False, indices=np.array(one), return_predecessors=True)[1]
        corners = [other]
        while corners[-1] != one:
            if came_from[corners[-1]] < 0:
                return None
            corners.append(int(came_from[corners[-1]]))
        visited = np.array(corners[::-1])
        first, second = np.minimum(visited[:-1], visited[1:]), np.maximum(visited[:-1], visited[1:])
        keys = np.minimum(start, end) * size + np.maximum(start, end)
        order = np.argsort(keys)
        return crack[order[np.searchsorted(keys[order], first * size + second)]]

    def around(self, corner: int, among: NDArray[np.bool_]) -> NDArray[np.intp] | None:
        """The numbers of the cracks of a closed path from a corner, starting with one of some cracks at the corner."""
        at_corner = np.flatnonzero(among & ((self._start == corner) | (self._end == corner)))
        if at_corner.size == 0:
            return None
        first = at_corner[:1]
        beyond = int(self._start[first[0]] + self._end[first[0]] - corner)
        back = self.between(beyond, corner, without=first)
        return None if back is None else np.concatenate([first, back])

    def line(self, one: int, cracks: NDArray[np.intp]) -> NDArray[np.float64]:
        """The corners (x, y) along a path from a corner."""
        visited = [one]
        for start, end in zip(self._start[cracks].tolist(), self._end[cracks].tolist(), strict=True):
            visited.append(end if visited[-1] == start else start)
        return self.corners[visited].astype(np.float64)

    def longest(self) -> NDArray[np.float64]:
        """The corners (x, y) of a long path: between two corners far apart, or all around for closed paths."""
        size, graph = len(self.corners), self._graph(self._cost)
        _, part = connected_components(graph, directed=False)
        sizes = np.bincount(part)
        members = np.flatnonzero(part == np.argmax(sizes))
        ends = members[np.bincount(np.concatenate([self._start, self._end]), minlength=size)[members] == 1]
        if ends.size == 0:
            corner = int(members[0])
            around = self.around(corner, np.ones(self._cost.size, bool))
            return self.line(corner, np.empty(0, np.intp) if around is None else around)
        one = int(ends[0])
        for _ in range(2):
            distance = dijkstra(graph, directed=False, indices=np.array(one))
            farthest = int(ends[np.argmax(np.where(np.isfinite(distance[ends]), distance[ends], -1))])
            one, other = farthest, one
        path = self.between(one, other)
        return self.line(one, path if path is not None else np.empty(0, np.intp))


# Redrawing the border between two blocks.

_BEYOND_CROP = -2
"""Value in place of a label where the label map continues outside the crop."""

_SHORTEST = 3.0
"""Minimum length [px] of a line to be a border."""

_RIM = 150, 300
"""Minimum and maximum distance [px] around a line in which the old border is searched; half the line's length between
them."""

_CLOSES = 0.1
"""Maximum distance of a line's ends for it to be closed, as a fraction of its length."""

_REACH, _REACH_SHARE = 16.0, 0.25
"""Maximum distance of a line's ends from the border to redraw: pixels, or a fraction of its length if larger; where
both blocks end, twice the pixels or the length."""

_AT_OUTLINE = 6.0
"""Maximum distance [px] of a line's end from another block or the frame's rim to be connected to it."""

_AROUND, _NEAR_END = 3.0, 4.0
"""Maximum distance from there to the border along the outline: a multiple of the straight distance, plus pixels."""

_OFF_PAIR = 50.0
"""Penalty for a line that runs through other blocks than the pair, in changed pixels per pixel of the line."""

_REPLACED = 2.0
"""Changed pixels that are made up for by one pixel of border that the line replaces."""

_ALONG_BORDER, _ALONG_OUTLINE = 0.05, 1.0
"""Cost of a path per pixel along the border of the pair, and along its outline to others."""


def redraw_border(labels: Labels, points: Points, locked: Collection[int] = ()) -> LabelPatch | None:
    """Move a section of the border between two blocks to a drawn line.

    Of the borders within reach it is that whose two blocks the line runs through, and where few pixels change. Only
    the areas between the line and the old border go to the other block, and parts that this cuts off from their block.
    No area goes to a block that it touches only at a point.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    points : sequence of (x, y)
        The new section, over or beside the old border, which it may cross. Its ends are connected to the old border, or
        to the neighbouring block or the frame's rim if they are close to it. It may leave the frame.
    locked : collection of int
        Blocks that must not change.

    Returns
    -------
    LabelPatch or None
        None if there is no border near the line, if one of the two blocks is locked, or if nothing changes. One of the
        two may be 0, no block.
    """
    line = _resampled(np.asarray(points, np.float64).reshape(-1, 2))
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


def _resampled(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points every half pixel along a line; empty for a line without length."""
    if len(line) < 2:
        return np.empty((0, 2))
    if np.hypot(*(line[-1] - line[0])) <= _CLOSES * np.hypot(*np.diff(line, axis=0).T).sum():
        line = np.concatenate([line, line[:1]])
    steps = np.hypot(*np.diff(line, axis=0).T)
    line, steps = line[np.append(True, steps > 0)], steps[steps > 0]
    if steps.size == 0:
        return np.empty((0, 2))
    along = np.append(0.0, np.cumsum(steps))
    # the given points stay, so that corners remain as drawn
    wanted = np.union1d(along, np.arange(0.0, along[-1], 0.5))
    return np.stack([np.interp(wanted, along, line[:, k]) for k in range(2)], axis=1)


def _padded(labels: Labels, box: tuple[slice, slice]) -> Labels:
    """The labels in a box with a rim of one pixel that marks where the frame ends and where the map continues."""
    ends_at_frame = [(side.start == 0, side.stop == size) for side, size in zip(box, labels.shape, strict=True)]
    return np.pad(labels[box], 1, constant_values=np.where(ends_at_frame, OFF_FRAME, _BEYOND_CROP).tolist())


def _redrawn(labels: Labels, line: NDArray[np.float64], length: float, locked: Collection[int]) -> Labels | None:
    """The labels after a line, between the pair of blocks where it changes least."""
    cracks = find_cracks(labels)
    cracks = cracks[(cracks.sides[:, 0] != _BEYOND_CROP) & ((cracks.sides >= 0).any(axis=1))]
    under = values_at(labels, line, OFF_FRAME)
    best, least, chosen = None, np.inf, (0, 0)
    for pair, off_pair in _pairs(cracks, line, under, length):
        after = _redrawn_between(labels, cracks, pair, line, under)
        if after is not None and not np.array_equal(after, labels):
            cost = _change(labels, after) / length + off_pair
            if cost < least:
                best, least, chosen = after, cost, pair
    return None if set(chosen) & set(locked) else best


def _redrawn_between(
    labels: Labels, cracks: Cracks, pair: tuple[int, int], line: NDArray[np.float64], under: NDArray[np.int32]
) -> Labels | None:
    """The labels after a line moves the border between a pair of blocks."""
    inside = np.flatnonzero(np.isin(under, pair))
    line = line[inside[0] : inside[-1] + 1]
    cracks = _in_one_piece(cracks[np.isin(cracks.sides, pair).any(axis=1)], pair, line)
    between = _between(cracks, pair)
    paths = CrackPaths(cracks, np.where(between, _ALONG_BORDER, _ALONG_OUTLINE))
    trimmed = inside[0] > 0, inside[-1] < len(under) - 1
    one, other = (
        _end_corner(paths, point, between, cut) for point, cut in zip((line[0], line[-1]), trimmed, strict=True)
    )
    best: Labels | None = None
    for section in _candidate_sections(paths, one, other, between):
        old = paths.line(one, section)
        swept = odd_even_fill(np.concatenate([line, old[::-1]]), (labels.shape[0], labels.shape[1]))
        after = _swap_areas(labels, swept, pair, cracks[section])
        if best is None or np.count_nonzero(after != labels) < np.count_nonzero(best != labels):
            best = after
    return None if best is None else _without_fragments(labels, _undo_without_border(labels, best, pair), pair)


def _change(before: Labels, after: Labels) -> float:
    """How much a line changes [px]: the least is meant, and of about equal changes that which replaces most border."""
    changes = zip(different_labels(before), different_labels(after), strict=True)
    gone = sum(np.count_nonzero(was & ~now) for was, now in changes)
    return np.count_nonzero(before != after) - _REPLACED * gone


def _pairs(
    cracks: Cracks, line: NDArray[np.float64], under: NDArray[np.int32], length: float
) -> Iterator[tuple[tuple[int, int], float]]:
    """The pairs of labels along whose border the line may run, with both ends near it, and their penalties."""
    borders = cracks[(cracks.sides[:, 0] >= 0)]
    pairs, owner = np.unique(borders.sides, axis=0, return_inverse=True)
    for number, pair in enumerate(pairs):
        if np.count_nonzero(owner == number) < _SHORTEST:
            continue  # blocks that touch at a point have no border to move
        inside = np.flatnonzero(np.isin(under, pair))
        if inside.size < len(line) / 2:
            continue
        ends = line[inside[[0, -1]]]
        off = np.asarray(cKDTree(borders.middle[owner.ravel() == number]).query(ends)[0])
        reach = [
            max(2 * _REACH, length) if _at_outline(cracks, pair, end) else max(_REACH, _REACH_SHARE * length)
            for end in ends
        ]
        if (off <= reach).all():
            yield (int(pair[0]), int(pair[1])), _OFF_PAIR * (1 - inside.size / (inside[-1] - inside[0] + 1))


def _at_outline(cracks: Cracks, pair: NDArray[np.int32], point: NDArray[np.float64]) -> bool:
    """Whether a point is at the common outline of two blocks, where a line can only be a border between them."""
    outline = cracks.middle[np.isin(cracks.sides, pair).sum(axis=1) == 1]
    return bool(np.any(np.hypot(*(outline - point).T) <= _AT_OUTLINE))


def _between(cracks: Cracks, pair: tuple[int, int]) -> NDArray[np.bool_]:
    """Which cracks are the border between two labels."""
    return np.asarray(np.isin(cracks.sides, pair).all(axis=1))


def _in_one_piece(cracks: Cracks, pair: tuple[int, int], line: NDArray[np.float64]) -> Cracks:
    """The cracks that are connected with the section of border nearest to the ends of the line."""
    parts = CrackPaths(cracks, np.ones(len(cracks.start))).parts()
    middle, between = cracks.middle, _between(cracks, pair)
    off = np.full((2, int(parts.max()) + 1), np.inf)
    for some, end in zip(off, (line[0], line[-1]), strict=True):
        np.minimum.at(some, parts[between], np.hypot(*(middle[between] - end).T))
    return cracks[parts == np.argmin(off.sum(axis=0))]


def _swap_areas(labels: Labels, swept: Mask, pair: tuple[int, int], section: Cracks) -> Labels:
    """Swap the two labels of a pair in swept areas that are adjacent to a section of border.

    Areas enclosed by such an area already have the label that their surroundings get.
    """
    after = labels.copy()
    box = bounds(swept)
    if box is None:
        return after
    inside = np.where(swept & np.isin(labels, pair), labels + 1, 0)
    areas = np.zeros(labels.shape, np.int32)
    areas[box] = connected_regions(inside[box])
    # the pixels right of and left of a vertical crack, below and above a horizontal one
    column, row = np.minimum(section.start, section.end).T
    upright = section.start[:, 0] == section.end[:, 0]
    at_stretch = np.zeros(int(areas.max()) + 1, bool)
    at_stretch[areas[row, column]] = True
    at_stretch[areas[row - ~upright, column - upright]] = True
    at_stretch[0] = False
    changing = at_stretch[areas] if len(section.start) else areas > 0
    after[changing & (labels == pair[0])] = pair[1]
    after[changing & (labels == pair[1])] = pair[0]
    return after


def _undo_without_border(before: Labels, after: Labels, pair: tuple[int, int]) -> Labels:
    """Restore the old label of areas that were swapped but have no border with the block that gets them."""
    kept = before == after
    for label, other in (pair, pair[::-1]):
        gained = ((before == label) & (after == other)).astype(np.uint8)
        areas = cv2.connectedComponents(gained, connectivity=4)[1].astype(np.int32)
        joined = have_border(areas, kept & (before == other))[areas]
        after = np.where((gained > 0) & ~joined, label, after).astype(np.int32)
    return after


def _end_corner(paths: CrackPaths, point: NDArray[np.float64], between: NDArray[np.bool_], trimmed: bool) -> int:
    """The corner to which an end of the line is connected."""
    at_border, border_off = paths.nearest(point, between)
    if between.all():
        return at_border
    at_outline, outline_off = paths.nearest(point, ~between)
    if trimmed:
        return at_outline if outline_off < border_off else at_border
    if outline_off > _AT_OUTLINE or border_off < 1:
        return at_border
    # connect to the outline only where the border itself ends close by
    return at_outline if paths.length_to(at_outline, between) <= _AROUND * border_off + _NEAR_END else at_border


def _candidate_sections(paths: CrackPaths, one: int, other: int, between: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """The sections of old border that the line may replace: the shortest, and the one the other way around a block."""
    if one == other:
        around = paths.around(one, between)
        return [np.empty(0, np.intp)] + ([] if around is None else [around])
    shortest = paths.between(one, other)
    if shortest is None:
        return []
    rest = paths.between(one, other, without=shortest[between[shortest]])
    return [found for found in (shortest, rest) if found is not None and between[found].any()]


def _without_fragments(before: Labels, after: Labels, pair: tuple[int, int]) -> Labels:
    """Give fragments that were cut off from their block to the other block, if they have a border with it."""
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
        # of each old part, the largest rest keeps its block, and so do parts that continue outside the crop
        shared = coo_array((np.ones(np.count_nonzero(stays)), (old[stays], new[stays])), shape=(parts, count)).tocsr()
        anchored[np.unique(np.asarray(shared.argmax(axis=1)).ravel()[shared.max(axis=1).toarray().ravel() > 0])] = True
        anchored[new[cv2.dilate((before == _BEYOND_CROP).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0]] = True
        loose = ~anchored
        loose[0] = False
        after = np.where((loose & have_border(new, after == other))[new], other, after).astype(np.int32)
    return after
