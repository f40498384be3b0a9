"""A label map -> polygons that follow the edges of its pixels, so that filling them gives the same map again."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_EAST, _SOUTH, _WEST, _NORTH = range(4)


def outline_polygons(labels: NDArray[np.int32]) -> dict[int, list[NDArray[np.int64]]]:
    """The outlines of all blocks: for every 4-connected part one closed polygon.

    A part with holes is one polygon, too: a cut along a line of pixels leads to each hole and back again.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block.

    Returns
    -------
    dict
        Label -> its parts' polygons, each an array (n, 2) of x, y of corners of pixels; the last is joined to the
        first.

    Examples
    --------
    >>> outline_polygons(np.array([[0, 5, 5], [0, 0, 5]], np.int32))[5][0].tolist()
    [[1, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1]]
    """
    from skimage.measure import label as connected_regions

    parts = connected_regions(labels, background=0, connectivity=1)
    found: dict[int, list[NDArray[np.int64]]] = {label: [] for label in np.unique(labels[labels > 0]).tolist()}
    for (row, column), points in _traced(parts):
        found[int(labels[row, column])].append(points)
    return found


def _traced(parts: NDArray[np.integer]) -> Iterator[tuple[tuple[int, int], NDArray[np.int64]]]:
    """A pixel of each part, and the part's polygon.

    Each edge between a pixel and another part is gone along with the pixel on the right. At the end of an edge the
    next is the same pixel's if it has one there, so the way round a part is found edge by edge.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    height, width = parts.shape
    line, corners = width + 1, (height + 1) * (width + 1)
    edges, following = _linked(parts)
    count = len(edges)
    if count == 0:
        return
    direction, start = np.divmod(edges, corners)
    y, x = np.divmod(start, line)
    links = csr_array((np.ones(count, bool), (np.arange(count), following)), shape=(count, count))
    loops, loop = connected_components(links, directed=False)
    # twice round the same way: what lies right of an outer border is inside, what lies right of a hole's is outside
    turn = np.bincount(loop, np.where(direction == _SOUTH, x, 0) - np.where(direction == _NORTH, x, 0), loops)
    first_edge = np.full(loops, count)
    np.minimum.at(first_edge, loop, np.arange(count))
    ways = _Ways(following, start)
    southward = np.flatnonzero((direction == _SOUTH) & (turn[loop] < 0))
    southward = southward[np.lexsort((x[southward], loop[southward]))]
    _, leftmost = np.unique(loop[southward], return_index=True)
    for edge in southward[leftmost].tolist():
        # left of a hole's leftmost edge, at the other end of the row of pixels, lies another border of the same part
        row, column = int(y[edge]), int(x[edge]) - 1
        others = np.flatnonzero(parts[row, :column] != parts[row, column])
        opposite = _NORTH * corners + (row + 1) * line + (int(others[-1]) + 1 if others.size else 0)
        ways.join(int(np.searchsorted(edges, opposite)), edge, opposite - line - _NORTH * corners)
    for edge in first_edge[turn > 0].tolist():
        points = np.column_stack(np.divmod(ways.round(edge), line)[::-1])
        # the first edge of all is one that leads east, along the top of a pixel
        yield (int(y[edge]), int(x[edge])), _corners_of(points)


def _linked(parts: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All edges, numbered by direction and the corner that they start from, and each one's next: its place there."""
    height, width = parts.shape
    padded = np.pad(parts, 1)
    above_left, above = padded[:-1, :-1], padded[:-1, 1:]
    below_left, below = padded[1:, :-1], padded[1:, 1:]
    is_edge = np.stack([
        (below > 0) & (below != above),
        (below_left > 0) & (below_left != below),
        (above_left > 0) & (above_left != below_left),
        (above > 0) & (above != above_left),
    ]).ravel()  # fmt: skip
    edges = np.flatnonzero(is_edge)
    corners = (height + 1) * (width + 1)
    direction, start = np.divmod(edges, corners)
    end = start + np.array([1, width + 1, -1, -(width + 1)])[direction]
    right, ahead, left = ((direction + turn) % 4 * corners + end for turn in (1, 0, 3))
    chosen = np.where(is_edge[right], right, np.where(is_edge[ahead], ahead, left))
    return edges, np.searchsorted(edges, chosen)


class _Ways:
    """Closed ways from corner to corner, which can be joined to one."""

    def __init__(self, following: NDArray[np.int64], corner: NDArray[np.int64]) -> None:
        self._next = following.tolist()
        self._corner = corner.tolist()
        self._previous = np.argsort(following).tolist()

    def join(self, edge: int, hole: int, corner: int) -> None:
        """After an edge that ends at a corner, go to the start of a hole's edge, round the hole and back."""
        there, back, after, last = len(self._next), len(self._next) + 1, self._next[edge], self._previous[hole]
        self._next += [hole, after]
        self._previous += [edge, last]
        self._corner += [corner, self._corner[hole]]
        self._next[edge], self._previous[hole] = there, there
        self._next[last], self._previous[after] = back, back

    def round(self, first: int) -> NDArray[np.int64]:
        """The corners of the way that an edge lies on."""
        found, place = [self._corner[first]], self._next[first]
        while place != first:
            found.append(self._corner[place])
            place = self._next[place]
        return np.array(found)


def _corners_of(points: NDArray[np.int64]) -> NDArray[np.int64]:
    """Points of a closed way without those that it passes straight on."""
    into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    straight = (into[:, 0] * out[:, 1] == into[:, 1] * out[:, 0]) & ((into * out).sum(axis=1) > 0)
    return points[~straight]
