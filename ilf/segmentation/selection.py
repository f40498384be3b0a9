"""Selecting a surface or object by points inside and outside of it, from a hierarchy of regions of colour and depth."""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import check_cancelled
from ..data.frame import RGBDFrame, checked_frame
from ..data.frame_cache import once_per_frame
from ..data.parameters import BlockParameters
from ..data.pixel_grids import sides
from ..errors import InputError
from .edges.frame_edges import find_edges
from .edges.relief import filled_depth
from .editing.patches import Points
from .flooding import flood

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# The pieces of a frame: small regions that follow its edges.

_PIECES = 2500
"""Approximate number of pieces."""

_FAINT, _HALF_FAINT = 0.5, 10.0
"""Height of the strongest change of colour beside the edges, and the change [CIELAB per px] of half this height."""


def _pieces(landscape: NDArray[np.float32]) -> NDArray[np.int32]:
    """Pieces 0, 1, ..., int32 (H, W): a watershed from the lowest pixel of every square of a grid."""
    height, width = landscape.shape
    side = max(round(math.sqrt(landscape.size / _PIECES)), 2)
    rows, columns = -(-height // side), -(-width // side)
    padded = np.pad(landscape, ((0, rows * side - height), (0, columns * side - width)), constant_values=np.inf)
    squares = padded.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(rows * columns, -1)
    down, right = np.divmod(squares.argmin(axis=1), side)
    square = np.arange(rows * columns)
    markers = np.zeros(landscape.shape, np.int32)
    markers[square // columns * side + down, square % columns * side + right] = 1 + square
    return np.asarray(flood(landscape, markers, np.ones(landscape.shape, bool)) - 1, np.int32)


def _change_of_colour(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Change of colour [CIELAB per px], float32 (H, W)."""
    blurred = cv2.GaussianBlur(rgb, (0, 0), 1.0).astype(np.float32) / np.float32(255)
    lab = cv2.cvtColor(blurred, cv2.COLOR_RGB2LAB)
    across, down = (cv2.Sobel(lab, cv2.CV_32F, *way, ksize=3, scale=1 / 8) for way in ((1, 0), (0, 1)))
    return np.asarray(np.sqrt((across * across + down * down).sum(axis=2)), np.float32)


# The hierarchy: pieces merge in order of the edges between them, until one region is left.

_DEPTH_WEIGHT, _MAX_DEPTH_STEP = 1.0, 0.5
"""Weight of the difference of the mean log depth of two regions, and the value at which it is clipped; edges have the
weight 1."""

_SIZE_EXPONENT = 0.3
"""Exponent of the smaller region's share of the frame in the cost of a border: small regions merge first."""

_WEAK = 0.25
"""Edge strength below which a border is weak."""

_COEFFICIENTS = (5.53, -6.23, -0.102, -0.525, -0.496, -0.251, -3.44, -1.95, 7.5, 2.35, 0.832, 1.19, -17.7)
"""Coefficients of `_properties`: fitted on generated scenes (`python -m tests.bench.selection --fit --seed 501 --scenes
40`), so that among the regions around a point of an object, weighted by the exponential of their score, the mean IoU
with the object is largest."""


@dataclass(frozen=True, eq=False)
class _Hierarchy:
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
    score : ndarray of float64, shape (2 n - 1,)
        How likely the node is a surface or object, as a logarithm.
    """

    pieces: NDArray[np.int32]
    parents: NDArray[np.int64]
    order: NDArray[np.int64]
    first: NDArray[np.int64]
    stop: NDArray[np.int64]
    pixels: Array
    score: Array

    def above(self, piece: int) -> list[int]:
        """The nodes that contain a piece, from itself to the whole frame."""
        nodes = [piece]
        while self.parents[nodes[-1]] >= 0:
            nodes.append(int(self.parents[nodes[-1]]))
        return nodes

    def pieces_of(self, node: int) -> NDArray[np.int64]:
        """The pieces of a node."""
        return self.order[self.first[node] : self.stop[node]]


@once_per_frame
def _hierarchy(frame: RGBDFrame) -> _Hierarchy:
    pieces, tree = _tree_of(frame)
    check_cancelled()
    order, first, stop = _in_order(tree.parents, int(pieces.max()) + 1)
    return _Hierarchy(
        pieces, tree.parents, order, first, stop, tree.pixels, _properties(tree) @ np.array(_COEFFICIENTS)
    )


@dataclass(frozen=True, eq=False)
class _Tree:
    """What the merges give for every node.

    Attributes
    ----------
    parents : ndarray of int64, shape (2 n - 1,)
    levels, pixels : ndarray of float64, shape (2 n - 1,)
        Cost of the own merge, and size.
    outer : ndarray of float64, shape (2 n - 1, 3)
        Border to all other nodes inside the frame.
    """

    parents: NDArray[np.int64]
    levels: Array
    pixels: Array
    outer: Array


def _tree_of(frame: RGBDFrame) -> tuple[NDArray[np.int32], _Tree]:
    """The pieces of a frame, and the tree of their merges."""
    edges = find_edges(frame, BlockParameters()).strength
    change = _change_of_colour(frame.rgb)
    pieces = _pieces(edges + np.float32(_FAINT) * change / (change + np.float32(_HALF_FAINT)))
    check_cancelled()
    pixels = np.bincount(pieces.ravel()).astype(np.float64)
    sums = np.bincount(pieces.ravel(), np.log(filled_depth(frame.depth)[0]).ravel()).astype(np.float64)
    return pieces, _merge(_borders(pieces, edges), pixels, sums)


_Border = tuple[float, float, float]
"""Length of a border [pairs of pixels], the sum of the edges along it, and how many of its pairs are weak."""


def _borders(pieces: NDArray[np.int32], edges: NDArray[np.float32]) -> list[dict[int, _Border]]:
    """The borders of every piece, by its neighbours."""
    count = int(pieces.max()) + 1
    keys, strengths = [], []
    for (one, other), (edge, beyond) in zip(sides(pieces), sides(edges), strict=True):
        parted = one != other
        ends = np.sort(np.stack([one[parted], other[parted]], axis=1).astype(np.int64), axis=1)
        keys.append(ends @ [count, 1])
        strengths.append(np.maximum(edge, beyond)[parted])
    pairs, owner = np.unique(np.concatenate(keys), return_inverse=True)
    strength = np.concatenate(strengths)
    sums = [np.bincount(owner, values) for values in (np.ones(owner.size), strength, strength < _WEAK)]
    borders: list[dict[int, _Border]] = [{} for _ in range(count)]
    for pair, length, edge, weak in zip(pairs.tolist(), *(values.tolist() for values in sums), strict=True):
        one, other = divmod(pair, count)
        borders[one][other] = borders[other][one] = length, edge, weak
    return borders


def _merge(borders: list[dict[int, _Border]], piece_pixels: Array, piece_depth: Array) -> _Tree:
    """Merge neighbours in order of the cost of their border."""
    count, whole = piece_pixels.size, float(piece_pixels.sum())
    pixels, depth = piece_pixels.tolist(), piece_depth.tolist()
    parents, levels = [-1] * (2 * count - 1), [0.0] * count
    outer = [np.sum([*near.values(), (0.0, 0.0, 0.0)], axis=0) for near in borders]

    def cost(one: int, other: int) -> float:
        length, edge, _ = borders[one][other]
        step = abs(depth[one] / pixels[one] - depth[other] / pixels[other])
        size = (min(pixels[one], pixels[other]) / whole) ** _SIZE_EXPONENT
        return float((edge / length + _DEPTH_WEIGHT * min(step, _MAX_DEPTH_STEP)) * size)

    heap = [(cost(one, other), one, other) for one, near in enumerate(borders) for other in near if one < other]
    heapq.heapify(heap)
    while heap:
        level, one, other = heapq.heappop(heap)
        if parents[one] >= 0 or parents[other] >= 0:
            continue
        new = len(pixels)
        parents[one] = parents[other] = new
        pixels.append(pixels[one] + pixels[other])
        depth.append(depth[one] + depth[other])
        levels.append(max(level, levels[one], levels[other]))
        shared = borders[one].pop(other)
        del borders[other][one]
        outer.append(outer[one] + outer[other] - 2 * np.array(shared))
        joined, fewer = sorted((borders[one], borders[other]), key=len, reverse=True)
        for near, border in fewer.items():
            before = joined.get(near, (0.0, 0.0, 0.0))
            joined[near] = border[0] + before[0], border[1] + before[1], border[2] + before[2]
        borders.append(joined)
        for near, border in joined.items():
            borders[near].pop(one, None)
            borders[near].pop(other, None)
            borders[near][new] = border
            heapq.heappush(heap, (cost(near, new), near, new))
    return _Tree(np.array(parents), np.array(levels), np.array(pixels), np.array(outer))


def _in_order(parents: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """`order`, `first` and `stop` of a hierarchy."""
    above = parents.tolist()
    leaves = [1] * count + [0] * (count - 1)
    for node in range(len(above) - 1):
        leaves[above[node]] += leaves[node]
    first, used = [0] * len(above), [0] * len(above)
    for node in range(len(above) - 2, -1, -1):
        first[node] = first[above[node]] + used[above[node]]
        used[above[node]] += leaves[node]
    return np.argsort(first[:count]), np.array(first), np.array(first) + np.array(leaves)


def _properties(tree: _Tree) -> Array:
    """What the score of every node depends on, float64 (2 n - 1, 13)."""
    length = np.maximum(tree.outer[:, 0], 1)
    edge, weak = tree.outer[:, 1] / length, tree.outer[:, 2] / length
    share, parents = np.log(tree.pixels / tree.pixels[-1]), tree.parents
    return np.stack(
        [
            edge,
            weak,
            np.log(tree.levels + 1e-3),
            np.log(tree.levels[parents] + 1e-3),
            share,
            share**2,
            edge * share,
            np.log(length / np.sqrt(tree.pixels)),
            edge**2,
            edge[parents],
            weak * share,
            np.clip(share[parents] - share, 0, 3),
            np.exp(share),
        ],
        axis=1,
    )


# The selection: the likeliest nodes that contain the points inside and none outside.

_STEP = 1.2
"""Minimum ratio of the sizes of two nodes that count as different steps from part to object."""

_GROWTH = 2.5
"""Maximum size of the region of a further point inside, in multiples of what is selected before."""

_INSIDE_BOX, _BOX_SHARE = 0.95, 0.1
"""Minimum share of a node inside a box for belonging to it, and the share of the box that it must cover if no point is
given."""


def select_region(
    frame: RGBDFrame,
    inside: Points,
    outside: Points = (),
    box: tuple[float, float, float, float] | None = None,
    *,
    steps: int | Sequence[int] = 0,
) -> Mask:
    """Select the surface or object at some points, by colour and depth.

    The frame is divided into small pieces along its edges, which merge step by step to a hierarchy of regions; it is
    cached with the frame. For each point inside, in order, the region that most likely is a surface or an object is
    added; then for each point outside, the likeliest region around it without a point inside is taken away.

    Parameters
    ----------
    frame : RGBDFrame
    inside : sequence of (x, y)
        Points of the object in image coordinates: pixel (row r, column c) covers x in [c, c + 1), y in [r, r + 1).
    outside : sequence of (x, y), optional
        Points that do not belong to it.
    box : (left, top, right, bottom), optional
        A box around the object [px]; regions that continue beyond it are not selected. Without points inside, the large
        regions in it are.
    steps : int or sequence of int
        Steps from the likeliest region at the last point inside, or at each: positive to larger regions (the object),
        negative to smaller ones (its parts).

    Returns
    -------
    ndarray of bool, shape (H, W)
        The selected pixels: those of every point inside, and of no point outside, unless both lie in one piece, which
        then is selected.

    Raises
    ------
    InputError
        If the input is not a frame, a point or the box lies outside of it, there are neither points inside nor a box,
        or there are not as many steps as points inside.

    Examples
    --------
    >>> import ilf
    >>> from ilf._runtime.installation import asset_path
    >>> frame = ilf.load_frame(asset_path("samples/room"))
    >>> mask = ilf.select_region(frame, [(320, 240)])
    >>> bool(mask[240, 320]), mask.shape
    (True, (480, 640))
    """
    checked_frame(frame)
    if box is None and not len(inside):
        raise InputError("Give at least one point inside, or a box.")
    each = [0] * (len(inside) - 1) + [steps] if isinstance(steps, int) else steps
    if len(inside) and len(each) != len(inside):
        raise InputError(f"Give one number of steps for each of the {len(inside)} points inside.")
    shown = None if box is None else _inside_box(frame.shape, box)
    tree = _hierarchy(frame)
    wanted, unwanted = (_pieces_at(tree.pieces, points) for points in (inside, outside))
    fits = np.ones(tree.parents.size, bool)
    if shown is not None:
        within = np.bincount(tree.pieces[shown].ravel(), minlength=tree.order.size)[tree.order]
        before = np.concatenate([[0], np.cumsum(within)])
        fits = before[tree.stop] - before[tree.first] >= _INSIDE_BOX * tree.pixels
    chosen = np.zeros(tree.order.size, bool)
    if shown is not None and not wanted:
        chosen = _largest(tree, fits, _BOX_SHARE * np.count_nonzero(tree.pieces[shown] >= 0))
    for piece, stepped in zip(wanted, each[: len(wanted)], strict=True):
        limit = _GROWTH * tree.pixels[: chosen.size][chosen].sum() if chosen.any() else math.inf
        nodes = [node for node in tree.above(piece) if fits[node] and tree.pixels[node] <= limit] or [piece]
        chosen[tree.pieces_of(_likeliest(tree, nodes, stepped))] = True
    for piece in unwanted:
        if chosen[piece]:
            chosen[tree.pieces_of(_likeliest(tree, _without(tree, piece, wanted), 0))] = False
    chosen[wanted] = True
    return np.asarray(chosen[tree.pieces])


def prepare_selection(frame: RGBDFrame) -> None:
    """Compute what `select_region` caches with a frame."""
    _hierarchy(frame)


def _likeliest(tree: _Hierarchy, nodes: Sequence[int], steps: int) -> int:
    """The likeliest surface or object of nodes that contain each other, from small to large, and some steps from it."""
    best = max(range(len(nodes)), key=lambda k: tree.score[nodes[k]])
    found = nodes[best]
    for node in nodes[best + 1 :] if steps > 0 else nodes[:best][::-1]:
        if steps == 0:
            break
        ratio = tree.pixels[node] / tree.pixels[found]
        if max(ratio, 1 / ratio) >= _STEP:
            found, steps = node, steps - (1 if steps > 0 else -1)
    return found


def _without(tree: _Hierarchy, piece: int, others: Sequence[int]) -> list[int]:
    """The nodes that contain a piece and none of others, from itself on; at least the piece."""
    places = tree.first[list(others)]  # of a piece: its place in the order
    nodes = tree.above(piece)
    return [k for k in nodes if not ((tree.first[k] <= places) & (places < tree.stop[k])).any()] or [piece]


def _largest(tree: _Hierarchy, fits: Mask, pixels: float) -> Mask:
    """The pieces of the largest fitting nodes: of all with at least so many pixels, or of one."""
    whole = np.flatnonzero(fits & ~((tree.parents >= 0) & fits[tree.parents]))
    sizes = tree.pixels[whole]
    taken = np.zeros(tree.order.size, bool)
    for node in whole[sizes >= min(pixels, sizes.max(initial=0))]:
        taken[tree.pieces_of(node)] = True
    return taken


def _pieces_at(pieces: NDArray[np.int32], points: Points) -> list[int]:
    height, width = pieces.shape
    found = []
    for x, y in points:
        if not (0 <= x < width and 0 <= y < height):
            raise InputError(f"The point ({x:g}, {y:g}) lies outside the frame of {width} x {height} pixels.")
        found.append(int(pieces[int(y), int(x)]))
    return found


def _inside_box(shape: tuple[int, int], box: tuple[float, float, float, float]) -> tuple[slice, slice]:
    left, top, right, bottom = box
    rows = slice(max(math.floor(top), 0), min(math.ceil(bottom), shape[0]))
    columns = slice(max(math.floor(left), 0), min(math.ceil(right), shape[1]))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        raise InputError("The box contains no pixel of the frame.")
    return rows, columns
