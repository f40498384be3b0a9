"""Merging neighbouring regions without a jump, crease or strong edge between them (section 2)."""

from __future__ import annotations

import heapq
import itertools
import math
import operator
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.blocks import find_blocks, least_known_pixels
from ..data.frame import RGBDFrame
from ..data.pixel_grids import connected_regions, sides, strips
from .edges.frame_edges import Relief

_JUMPS_ALLOWED, _JUMP_SHARE_ALLOWED = 2, 0.02
"""Jumps (pairs of neighbours) along a border for which two regions may still merge: at most the larger of a number and
a share of the border."""

_JUMP_BOUND_SHARE = 0.2
"""Share of the usual minimum size that a region needs to be a block if jumps part it from all its neighbours."""

_JUMP_COST = 9.0
"""Cost of a border with jumps, above that of all borders without jumps."""

_CONTINUOUS_EDGE_WEIGHT = 0.1
"""Weight of a colour edge where the depth is continuous across it."""

_JUMPLESS_WEIGHT = 0.7
"""How far depth counts as continuous where it does not jump, but a jump or hole is too near to measure its bend."""

_BEND_COST, _FREE_BEND, _MAX_BEND = 0.2, 0.5, 3.0
"""Cost of a bend, the bend up to which it is 0, and the bend at which it is clipped."""

_COPLANAR_EDGE_WEIGHT = 0.2
"""Weight of a colour edge where depth is missing at the border, but both regions lie on one plane."""

_SEEN_SHARE = 0.5
"""Minimum known fraction of a border for which its own depth decides whether the surface is continuous; below it, the
planes of the regions decide."""

_PLANE_STEP, _MIN_PLANE_SAMPLES = 2, 50
"""Sampling step [px] of the depth for fitting planes, and the minimum number of samples of a region."""

_PLANE_SHARE, _PLANE_PER_METRE = 0.01, 0.003
"""Maximum RMS deviation from a plane as a fraction of depth: the larger of a constant and a term that grows with
depth."""


Border = tuple[float, ...]
"""What `_borders` sums along a border. Python's numbers: for so few, an array takes several times as long."""


class RegionGraph:
    """Graph of regions and their borders, with the properties of both; merging two regions updates it.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions 1, 2, ...; 0 for none.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    frame : RGBDFrame
    relief : Relief or None
        Jumps and bends of the known depth; without it, only edges count.
    """

    def __init__(
        self, regions: NDArray[np.int32], strength: NDArray[np.float32], frame: RGBDFrame, relief: Relief | None
    ) -> None:
        count = int(regions.max()) + 1
        self._regions = regions
        self._parent = np.arange(count)
        self.pixels, self.known = np.zeros((2, count), np.intp)
        for rows, *_ in strips(len(regions)):
            self.pixels += np.bincount(regions[rows].ravel(), minlength=count)
            self.known += np.bincount(regions[rows][frame.known[rows]], minlength=count)
        self._planes = _Planes(regions, frame, count) if relief is not None else None
        self._borders: list[dict[int, Border]] = [{} for _ in range(count)]
        for one, other, border in _borders(regions, strength, relief):
            self._borders[one][other] = self._borders[other][one] = border

    def merge_below(self, limit: float) -> None:
        """Merge neighbours in order of border cost, as long as a border costs less than `limit`.

        The cost of a border is that at its creation, or its present one if that is higher.
        """
        heap: list[tuple[float, int, int, int, Border]] = []
        serial = itertools.count()

        def push(one: int, other: int) -> None:
            cost = self._cost(one, other)
            if cost < limit:
                heapq.heappush(heap, (cost, next(serial), one, other, self._borders[one][other]))

        for one, neighbours in enumerate(self._borders):
            for other in neighbours:
                if one < other:
                    push(one, other)
        while heap:
            cost, _, one, other, border = heapq.heappop(heap)
            if self._borders[one].get(other) is not border:
                continue
            if self._cost(one, other) > cost:  # a region merged since may lie on another plane
                push(one, other)
                continue
            kept, moved = self._merge(one, other)
            for neighbour in moved:
                push(kept, neighbour)

    def merge_unfit(self, pixels: float, known_share: float, known_pixels: int, density: float = 1.0) -> None:
        """Merge every region that cannot be a block, the smallest first, into the neighbour with the cheapest border.

        A region without neighbours is a block nevertheless, unless it has no known depth.

        Parameters
        ----------
        pixels : float
            Minimum number of pixels of a block.
        known_share : float
            Minimum fraction of its pixels with depth, 0-1.
        known_pixels : int
            Minimum number of its pixels with depth, unless the fraction is 0.
        density : float
            Fraction of the frame's pixels with depth, see `least_known_pixels`.
        """

        def unfit(region: int, share: float = 1.0) -> bool:
            own, least = self.pixels[region], share * pixels
            if own < least or not known_share:
                return bool(own < least)
            return bool(self.known[region] < least_known_pixels(own, known_share, known_pixels, density))

        heap = [(self.pixels[region], region) for region in range(1, self.pixels.size) if unfit(region)]
        heapq.heapify(heap)
        while heap:
            size, region = heapq.heappop(heap)
            if self._parent[region] != region or self.pixels[region] != size or not self._borders[region]:
                continue
            cost, nearest = min((self._cost(region, other), other) for other in self._borders[region])
            if cost >= _JUMP_COST and not unfit(region, _JUMP_BOUND_SHARE):
                continue
            kept, _ = self._merge(region, nearest)
            if unfit(kept):
                heapq.heappush(heap, (self.pixels[kept], kept))
        for region in range(1, self.pixels.size):
            if self._parent[region] == region and self.known[region] == 0:
                self._parent[region] = 0

    def labels(self) -> NDArray[np.int32]:
        """Label map of the merged regions, int32 (H, W), numbered in order of decreasing size."""
        root = self._parent
        while not np.array_equal(root, root[root]):
            root = root[root]
        sizes = np.where(root == np.arange(root.size), self.pixels, 0)
        return _by_size(sizes)[root][self._regions]

    def _cost(self, one: int, other: int) -> float:
        length, edge, jumps, seen, evaluated, bend = self._borders[one][other]
        if jumps > _JUMPS_ALLOWED and jumps > _JUMP_SHARE_ALLOWED * length:
            return _JUMP_COST + jumps / length
        edge /= length
        seen /= length
        if self._planes is not None and seen < _SEEN_SHARE and self._planes.shared(one, other):
            edge *= _COPLANAR_EDGE_WEIGHT
        bent = _BEND_COST * max(bend / evaluated - _FREE_BEND, 0.0) if evaluated else 0.0
        return (1 - seen) * edge + seen * (bent + _CONTINUOUS_EDGE_WEIGHT * edge)

    def _merge(self, one: int, other: int) -> tuple[int, list[int]]:
        """Merge two regions; returns the number that is kept, and the neighbours to which its border has changed."""
        kept, gone = (one, other) if len(self._borders[one]) >= len(self._borders[other]) else (other, one)
        self._parent[gone] = kept
        self.pixels[kept] += self.pixels[gone]
        self.known[kept] += self.known[gone]
        if self._planes is not None:
            self._planes.moments[kept] += self._planes.moments[gone]
        del self._borders[kept][gone], self._borders[gone][kept]
        for neighbour, border in self._borders[gone].items():
            del self._borders[neighbour][gone]
            known = self._borders[kept].get(neighbour)
            joined = border if known is None else tuple(map(operator.add, border, known))
            self._borders[kept][neighbour] = self._borders[neighbour][kept] = joined
        moved = list(self._borders[gone])
        self._borders[gone] = {}
        return kept, moved


def numbered(labels: NDArray[np.integer]) -> NDArray[np.int32]:
    """A label map with its blocks numbered 1, 2, ... in order of decreasing size; 0 stays."""
    return _by_size(np.bincount(labels.ravel()))[labels]


def _by_size(sizes: NDArray[np.integer]) -> NDArray[np.int32]:
    """The numbers of labels of these sizes: 1 for the largest; 0 for label 0 and for labels without pixels."""
    there = 1 + np.flatnonzero(sizes[1:])
    numbers = np.zeros(sizes.size, np.int32)
    numbers[there[np.argsort(-sizes[there], kind="stable")]] = np.arange(1, there.size + 1)
    return numbers


def _borders(
    regions: NDArray[np.int32], strength: NDArray[np.float32], relief: Relief | None
) -> Iterator[tuple[int, int, Border]]:
    """Neighbouring regions and their border: its length, and the sums along it of the edge strength, the jumps, how far
    depth is seen to be continuous, the pixels with a valid bend, and their bend."""
    count = int(regions.max()) + 1
    keys, columns = [], []
    for side, (one, other) in enumerate(sides(regions)):
        # many times as fast as `np.nonzero` of two dimensions
        parted = np.unravel_index(np.flatnonzero((one != other) & (one > 0) & (other > 0)), one.shape)
        first, second = one[parted].astype(np.int64), other[parted].astype(np.int64)
        keys.append(np.minimum(first, second) * count + np.maximum(first, second))
        column = [np.ones(first.size), np.maximum(*_ends(strength, side, parted))]
        if relief is not None:
            evaluated = np.logical_and(*_ends(relief.evaluated, side, parted))
            near = np.logical_and(*_ends(relief.near, side, parted))
            bend = np.maximum(*_ends(relief.bend, side, parted))
            jumpless = near & ~relief.all_jumps[side][parted]
            seen = np.maximum(evaluated, _JUMPLESS_WEIGHT * jumpless)
            column += [relief.jumps[side][parted], seen, evaluated, np.minimum(bend, _MAX_BEND) * evaluated]
        else:
            column += [np.zeros(first.size)] * 4
        columns.append(np.stack(column))
    pairs, owner = np.unique(np.concatenate(keys), return_inverse=True)
    sums = [np.bincount(owner, values, minlength=pairs.size) for values in np.concatenate(columns, axis=1)]
    for pair, *border in zip(pairs.tolist(), *(one.tolist() for one in sums), strict=True):
        yield pair // count, pair % count, tuple(border)


def _ends(values: NDArray[Any], side: int, pairs: tuple[NDArray[np.intp], ...]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The values of both pixels of pairs, given by their rows and columns; for `side` see `sides`."""
    one, other = sides(values)[side]
    return one[pairs], other[pairs]


class _Planes:
    """Planes fitted to the known depth of every region, by moments that are added when regions merge.

    On a plane, inverse depth is linear in the image coordinates for every camera.
    """

    def __init__(self, regions: NDArray[np.int32], frame: RGBDFrame, count: int) -> None:
        coarse = np.s_[::_PLANE_STEP, ::_PLANE_STEP]
        rows, columns = _PLANE_STEP * np.argwhere(frame.known[coarse] & (regions[coarse] > 0)).T
        owner = regions[rows, columns].astype(np.intp)
        height, width = regions.shape
        inverse = 1 / frame.depth[rows, columns].astype(np.float64)
        terms = (np.ones(rows.size), columns / width - 0.5, rows / height - 0.5, inverse)
        self.moments = np.empty((count, 4, 4))
        for one in range(4):
            for other in range(one + 1):
                product = np.bincount(owner, terms[one] * terms[other], minlength=count)
                self.moments[:, one, other] = self.moments[:, other, one] = product

    def shared(self, one: int, other: int) -> bool:
        """Whether the known depth of both lies on one plane."""
        if min(self.moments[one, 0, 0], self.moments[other, 0, 0]) < _MIN_PLANE_SAMPLES:
            return False
        moments = self.moments[one] + self.moments[other]
        pixels, sums = moments[0, 0], moments[3, :3]
        # slight regularisation: all known pixels may lie on one line
        plane = np.linalg.solve(moments[:3, :3] + 1e-9 * pixels * np.eye(3), sums)
        deviation = math.sqrt(max(moments[3, 3] - plane @ sums, 0.0) / pixels)
        depth = pixels / moments[3, 0]
        return deviation * depth <= max(_PLANE_SHARE, _PLANE_PER_METRE * depth)


# The paper's existence rate: splitting and removing blocks with too little known depth (section 2).

_HALVINGS = 2


def keep_existing(
    labels: NDArray[np.int32], known: NDArray[np.bool_], rate: float, smallest: float
) -> NDArray[np.int32]:
    """Halve blocks with too small a known fraction, up to twice, and keep the parts that reach the rate.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    known : ndarray of bool, shape (H, W)
        Pixels with depth.
    rate : float
        Minimum fraction of a block's pixels with depth, 0-1.
    smallest : float
        Minimum number of pixels of a part.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Blocks that reach the rate keep their label; the parts of others, each one 4-connected region, get new labels
        above the largest. Pixels of parts below the rate belong to no block.
    """
    kept = labels.copy()
    following = int(labels.max()) + 1
    for block in find_blocks(labels).values():
        pixels = np.argwhere(block.mask)
        has_depth = known[block.box][block.mask]
        if has_depth.mean() >= rate:
            continue
        parts = np.zeros(block.mask.shape, np.int32)
        for number, part in enumerate(_parts_above_rate(pixels, has_depth, rate, _HALVINGS), 1):
            parts[tuple(part.T)] = number
        pieces = connected_regions(parts)
        large = np.bincount(pieces.ravel()) >= smallest
        large[0] = False
        numbers = np.where(large, np.cumsum(large) + following - 1, 0)
        kept[block.box][block.mask] = numbers[pieces][block.mask]
        following += int(np.count_nonzero(large))
    return kept


def _parts_above_rate(
    pixels: NDArray[np.intp], has_depth: NDArray[np.bool_], rate: float, halvings: int
) -> list[NDArray[np.intp]]:
    """The parts of a block that reach the rate, as rows of (row, column)."""
    if has_depth.mean() >= rate:
        return [pixels]
    if halvings == 0 or len(pixels) < 2:
        return []
    off = pixels - pixels.mean(axis=0)
    _, axes = np.linalg.eigh(off.T @ off)
    along = off @ axes[:, -1]
    first = along < np.median(along)
    if not first.any():
        return []
    halves = ((pixels[part], has_depth[part]) for part in (first, ~first))
    return [part for half in halves for part in _parts_above_rate(*half, rate, halvings - 1)]
