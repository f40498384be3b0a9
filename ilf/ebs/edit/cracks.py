"""The cracks between pixels of different labels: what borders of blocks are made of.

A crack is one pixel long and lies between two neighbouring pixels; its ends are corners of pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from .patches import Labels, Mask

OFF_FRAME = -1
"""What lies beyond the frame, in place of a label."""

_CONTACT, _CONTACT_SHARE = 3.0, 0.25
"""Length [px] from which on two areas that touch have a border; less is enough for a small one: this share of the root
of its pixels."""


@dataclass(frozen=True, eq=False)
class Cracks:
    """Cracks of a label map.

    Attributes
    ----------
    start, end : ndarray of int, shape (n, 2)
        Their ends (x, y).
    sides : ndarray of int32, shape (n, 2)
        The labels on both sides, the smaller first; `OFF_FRAME` beyond the frame.
    """

    start: NDArray[np.intp]
    end: NDArray[np.intp]
    sides: NDArray[np.int32]

    @property
    def middle(self) -> NDArray[np.float64]:
        """Their middles (x, y), float64 (n, 2)."""
        return (self.start + self.end) / 2

    def __getitem__(self, chosen: Any) -> Cracks:
        """Some of them."""
        return Cracks(self.start[chosen], self.end[chosen], self.sides[chosen])


def find_cracks(labels: Labels) -> Cracks:
    """All cracks between pixels of different labels of a map in which `OFF_FRAME` stands beyond the frame."""
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
    """Which areas of a map have a border with some pixels, instead of touching them at a point or two.

    Parameters
    ----------
    areas : ndarray of int32, shape (H, W)
        The number of the area at every pixel; 0 for none.
    other : ndarray of bool, shape (H, W)
        The pixels.

    Returns
    -------
    ndarray of bool, shape (N + 1,)
        By the number of the area; the first is False.
    """
    sizes = np.bincount(areas.ravel())
    lengths = np.zeros(sizes.size)
    for beside, pixels in (
        (areas[1:], other[:-1]),
        (areas[:-1], other[1:]),
        (areas[:, 1:], other[:, :-1]),
        (areas[:, :-1], other[:, 1:]),
    ):
        lengths += np.bincount(beside[pixels], minlength=sizes.size)
    found = (lengths > 0) & (lengths >= np.minimum(_CONTACT, _CONTACT_SHARE * np.sqrt(sizes)))
    found[0] = False
    return np.asarray(found, bool)


class CrackPaths:
    """Cheapest paths along cracks.

    Parameters
    ----------
    cracks : Cracks
    cost : ndarray of float64, shape (n,)
        Of each crack, > 0.
    """

    def __init__(self, cracks: Cracks, cost: NDArray[np.float64]) -> None:
        ends = np.concatenate([cracks.start, cracks.end])
        self.corners, numbers = np.unique(ends, axis=0, return_inverse=True)
        numbers = numbers.ravel()
        self._start, self._end = numbers[: len(cost)], numbers[len(cost) :]
        self._cost = cost

    def parts(self) -> NDArray[np.intp]:
        """Of every crack the number of the connected part that it belongs to."""
        size = len(self.corners)
        ways = coo_array((np.ones(self._cost.size), (self._start, self._end)), shape=(size, size))
        numbers = np.asarray(connected_components(ways.tocsr(), directed=False)[1], np.intp)
        return numbers[self._start]

    def nearest(self, point: NDArray[np.float64], among: NDArray[np.bool_]) -> tuple[int, float]:
        """The number of the corner nearest to a point (x, y), among the ends of some cracks, and its distance."""
        numbers = np.unique(np.concatenate([self._start[among], self._end[among]]))
        distance = np.hypot(*(self.corners[numbers] - point).T)
        best = int(np.argmin(distance))
        return int(numbers[best]), float(distance[best])

    def length_to(self, corner: int, among: NDArray[np.bool_]) -> float:
        """Length [px] of the way from a corner along the other cracks to the nearest of some; infinite without one."""
        size, rest = len(self.corners), ~among
        ways = coo_array((np.ones(np.count_nonzero(rest)), (self._start[rest], self._end[rest])), shape=(size, size))
        length = dijkstra(ways.tocsr(), directed=False, indices=np.array(corner))
        return float(length[np.concatenate([self._start[among], self._end[among]])].min())

    def between(self, one: int, other: int, without: NDArray[np.intp] | None = None) -> NDArray[np.intp] | None:
        """The numbers of the cracks of the cheapest path between two corners; None if there is none.

        Parameters
        ----------
        one, other : int
            Numbers of the corners.
        without : ndarray of int, optional
            Numbers of cracks that it must not use.
        """
        used = np.ones(self._cost.size, bool)
        if without is not None:
            used[without] = False
        crack = np.flatnonzero(used)
        start, end = self._start[crack], self._end[crack]
        size = len(self.corners)
        graph = coo_array((self._cost[crack], (start, end)), shape=(size, size)).tocsr()
        came_from = dijkstra(graph, directed=False, indices=np.array(one), return_predecessors=True)[1]
        corners = [other]
        while corners[-1] != one:
            if came_from[corners[-1]] < 0:
                return None
            corners.append(int(came_from[corners[-1]]))
        walked = np.array(corners[::-1])
        first, second = np.minimum(walked[:-1], walked[1:]), np.maximum(walked[:-1], walked[1:])
        keys = np.minimum(start, end) * size + np.maximum(start, end)
        order = np.argsort(keys)
        return crack[order[np.searchsorted(keys[order], first * size + second)]]

    def around(self, corner: int, among: NDArray[np.bool_]) -> NDArray[np.intp] | None:
        """The numbers of the cracks of a way from a corner back to it, by one of some cracks at it."""
        at_corner = np.flatnonzero(among & ((self._start == corner) | (self._end == corner)))
        if at_corner.size == 0:
            return None
        first = at_corner[:1]
        beyond = int(self._start[first[0]] + self._end[first[0]] - corner)
        back = self.between(beyond, corner, without=first)
        return None if back is None else np.concatenate([first, back])

    def line(self, one: int, cracks: NDArray[np.intp]) -> NDArray[np.float64]:
        """The corners (x, y) along a path that starts at a corner."""
        walked = [one]
        for start, end in zip(self._start[cracks].tolist(), self._end[cracks].tolist(), strict=True):
            walked.append(end if walked[-1] == start else start)
        return self.corners[walked].astype(np.float64)

    def longest(self) -> NDArray[np.float64]:
        """The corners (x, y) of a long path: of that between two corners far apart, or all around where paths close."""
        size = len(self.corners)
        graph = coo_array((self._cost, (self._start, self._end)), shape=(size, size)).tocsr()
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
