"""Trees of the regions of a frame: small pieces along its edges, merged pair by pair by edges, depth and colour."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import check_cancelled
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.parameters import BlockParameters
from ..data.pixel_grids import cells_of, flood, sides
from .edges.frame_edges import filled_depth, find_edges

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RegionTree:
    """Binary tree of regions: nodes 0 to n - 1 are the pieces, each later node is two earlier ones together.

    Attributes
    ----------
    pieces : ndarray of int32, shape (H, W)
        The piece of every pixel.
    parents : ndarray of int64, shape (2 n - 1,)
        The node that contains a node; -1 for the last.
    order : ndarray of int64, shape (n,)
        Pieces in an order in which those of every node are neighbours.
    first, stop : ndarray of int64, shape (2 n - 1,)
        Where the pieces of a node begin and end in this order.
    pixels : ndarray of float64, shape (2 n - 1,)
    ends : ndarray of int64, shape (B, 2)
        The two pieces at every border.
    borders : ndarray of float32, shape (B, 4)
        Length of every border [pairs of pixels], the sum of the edges along it, how many of its pairs are weak, and the
        sum of the steps of log depth.
    colour : ndarray of float32, shape (n, 3)
        Mean colour of the pieces [CIELAB].
    depth : ndarray of float32, shape (n,)
        Mean logarithm of their depth [m]; where it is missing, that of the nearest known depth.
    others : tuple of RegionTree
        The same pieces, merged in other orders: by everything, by depth, and by colour.
    """

    pieces: NDArray[np.int32]
    parents: NDArray[np.int64]
    order: NDArray[np.int64]
    first: NDArray[np.int64]
    stop: NDArray[np.int64]
    pixels: Array
    ends: NDArray[np.int64]
    borders: NDArray[np.float32]
    colour: NDArray[np.float32]
    depth: NDArray[np.float32]
    others: tuple[RegionTree, ...] = ()

    def above(self, piece: int) -> list[int]:
        """The nodes that contain a piece, from itself to the whole frame."""
        nodes = [piece]
        while self.parents[nodes[-1]] >= 0:
            nodes.append(int(self.parents[nodes[-1]]))
        return nodes

    def masks(self, nodes: list[int]) -> NDArray[np.bool_]:
        """The pieces of nodes, bool (K, n)."""
        found = np.zeros((len(nodes), self.order.size), bool)
        for mask, node in zip(found, nodes, strict=True):
            mask[self.order[self.first[node] : self.stop[node]]] = True
        return found


@once_per_frame
def region_tree(frame: RGBDFrame) -> RegionTree:
    """The tree of a frame, cached with it."""
    edges = find_edges(frame, BlockParameters()).strength
    change = _change_of_colour(frame.edge_rgb)
    pieces = _pieces(edges + np.float32(_FAINT) * change / (change + np.float32(_HALF_FAINT)))
    check_cancelled()
    sizes = np.bincount(pieces.ravel()).astype(np.float64)
    lab = cv2.cvtColor(frame.edge_rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB)
    log_depth = np.log(filled_depth(frame.depth))
    of_piece = [np.bincount(pieces.ravel(), values.ravel()) for values in (*cv2.split(lab), log_depth)]
    sums = np.stack(of_piece, axis=1).astype(np.float64)
    ends, borders = _borders(pieces, edges, log_depth)
    means = (sums / sizes[:, None]).astype(np.float32)
    trees: list[RegionTree] = []
    for order in _ORDERS:
        check_cancelled()
        parents, pixels = _merge(ends, borders, sizes, sums, order)
        nodes = _in_order(parents, sizes.size)
        trees.append(RegionTree(pieces, parents, *nodes, pixels, ends, borders, means[:, :3], means[:, 3]))
    return replace(trees[0], others=tuple(trees[1:]))


# The pieces of a frame: small regions that follow its edges.

_PIECES = 2500
"""Approximate number of pieces."""

_FAINT, _HALF_FAINT = 0.5, 10.0
"""Height of the strongest change of colour beside the edges, and the change [CIELAB per px] of half this height."""


def _pieces(landscape: NDArray[np.float32]) -> NDArray[np.int32]:
    """Pieces 0, 1, ..., int32 (H, W): a watershed from the lowest pixel of every square of a grid."""
    side = max(round(math.sqrt(landscape.size / _PIECES)), 2)
    squares = cells_of(landscape, side, value=math.inf).swapaxes(1, 2)
    columns = squares.shape[1]
    down, right = np.divmod(squares.reshape(-1, side * side).argmin(axis=1), side)
    square = np.arange(down.size)
    markers = np.zeros(landscape.shape, np.int32)
    markers[square // columns * side + down, square % columns * side + right] = 1 + square
    return np.asarray(flood(landscape, markers, np.ones(landscape.shape, bool)) - 1, np.int32)


def _change_of_colour(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Change of colour [CIELAB per px], float32 (H, W)."""
    blurred = cv2.GaussianBlur(rgb, (0, 0), 1.0).astype(np.float32) / np.float32(255)
    lab = cv2.cvtColor(blurred, cv2.COLOR_RGB2LAB)
    across, down = (cv2.Sobel(lab, cv2.CV_32F, *way, ksize=3, scale=1 / 8) for way in ((1, 0), (0, 1)))
    return np.asarray(np.sqrt((across * across + down * down).sum(axis=2)), np.float32)


# A tree: pieces merge in order of what parts them, until one region is left.


class _Order(NamedTuple):
    """Weights in the cost of a border: of its mean edge, of the mean step of log depth across it, and of the
    differences of mean log depth and mean colour [CIELAB] of the two regions."""

    edge: float
    step: float
    depth: float
    colour: float


_ORDERS = (
    _Order(edge=1.0, step=0.0, depth=1.0, colour=0.0),
    _Order(edge=1.0, step=10.0, depth=1.0, colour=1 / 80),
    _Order(edge=0.15, step=20.0, depth=0.3, colour=0.0),
    _Order(edge=0.3, step=0.0, depth=0.0, colour=1 / 40),
)

_MAX_STEP, _MAX_DEPTH, _MAX_COLOUR = 0.05, 0.5, 60.0
"""Values at which the step across a pair of pixels, and the differences of depth and colour, are clipped."""

_SIZE_EXPONENT = 0.3
"""Exponent of the smaller region's share of the frame in the cost of a border: small regions merge first."""

_WEAK = 0.25
"""Edge strength below which a border is weak."""


def _borders(
    pieces: NDArray[np.int32], edges: NDArray[np.float32], log_depth: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """`ends` and `borders` of a tree."""
    count = int(pieces.max()) + 1
    keys, strengths, steps = [], [], []
    for (one, other), (edge, beyond), (near, far) in zip(sides(pieces), sides(edges), sides(log_depth), strict=True):
        parted = one != other
        both = np.sort(np.stack([one[parted], other[parted]], axis=1).astype(np.int64), axis=1)
        keys.append(both @ [count, 1])
        strengths.append(np.maximum(edge, beyond)[parted])
        steps.append(np.minimum(np.abs(near - far)[parted], np.float32(_MAX_STEP)))
    pairs, owner = np.unique(np.concatenate(keys), return_inverse=True)
    strength = np.concatenate(strengths)
    values = np.ones(owner.size), strength, strength < _WEAK, np.concatenate(steps)
    sums = [np.bincount(owner, value) for value in values]
    return np.stack(np.divmod(pairs, count), axis=1), np.stack(sums, axis=1).astype(np.float32)


def _merge(
    ends: NDArray[np.int64], borders: NDArray[np.float32], sizes: Array, sums: Array, order: _Order
) -> tuple[NDArray[np.int64], Array]:
    """`parents` and `pixels` of a tree: neighbours merge in order of the cost of their border.

    Sizes and sums, of colour and log depth, are those of the pieces.
    """
    count, whole = sizes.size, float(sizes.sum())
    pixels, parents = sizes.tolist(), [-1] * (2 * count - 1)
    features: list[tuple[float, float, float, float]] = [tuple(one) for one in sums.tolist()]
    near: list[dict[int, tuple[float, float]]] = [{} for _ in range(count)]
    walls = order.edge * borders[:, 1].astype(np.float64) + order.step * borders[:, 3]
    for (one, other), length, wall in zip(ends.tolist(), borders[:, 0].tolist(), walls.tolist(), strict=True):
        near[one][other] = near[other][one] = length, wall

    def cost(one: int, other: int) -> float:
        length, wall = near[one][other]
        here, there = pixels[one], pixels[other]
        (x1, y1, z1, d1), (x2, y2, z2, d2) = features[one], features[other]
        apart = order.depth * min(abs(d1 / here - d2 / there), _MAX_DEPTH)
        if order.colour:
            colour = math.hypot(x1 / here - x2 / there, y1 / here - y2 / there, z1 / here - z2 / there)
            apart += order.colour * min(colour, _MAX_COLOUR)
        return float((wall / length + apart) * (min(here, there) / whole) ** _SIZE_EXPONENT)

    heap = [(cost(one, other), one, other) for one, other in ends.tolist()]
    heapq.heapify(heap)
    while heap:
        _, one, other = heapq.heappop(heap)
        if parents[one] >= 0 or parents[other] >= 0:
            continue
        new = len(pixels)
        parents[one] = parents[other] = new
        pixels.append(pixels[one] + pixels[other])
        (x1, y1, z1, d1), (x2, y2, z2, d2) = features[one], features[other]
        features.append((x1 + x2, y1 + y2, z1 + z2, d1 + d2))
        del near[one][other], near[other][one]
        joined, fewer = sorted((near[one], near[other]), key=len, reverse=True)
        for beyond, (length, wall) in fewer.items():
            before = joined.get(beyond, (0.0, 0.0))
            joined[beyond] = length + before[0], wall + before[1]
        near.append(joined)
        for beyond, border in joined.items():
            near[beyond].pop(one, None)
            near[beyond].pop(other, None)
            near[beyond][new] = border
            heapq.heappush(heap, (cost(beyond, new), beyond, new))
    return np.array(parents), np.array(pixels)


def _in_order(parents: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """`order`, `first` and `stop` of a tree."""
    above = parents.tolist()
    leaves = [1] * count + [0] * (count - 1)
    for node in range(len(above) - 1):
        leaves[above[node]] += leaves[node]
    first, used = [0] * len(above), [0] * len(above)
    for node in range(len(above) - 2, -1, -1):
        first[node] = first[above[node]] + used[above[node]]
        used[above[node]] += leaves[node]
    return np.argsort(first[:count]), np.array(first), np.array(first) + np.array(leaves)
