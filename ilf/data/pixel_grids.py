"""Operations on pixel grids: nearest pixels, connected regions, pairs of neighbours, and halving."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .._runtime.compiling import compiled

Array = NDArray[np.float32]
Scalar = TypeVar("Scalar", bound=np.number)


def nearest_values(
    values: NDArray[Scalar], there: NDArray[np.bool_], mask_size: int = 5
) -> tuple[Array, NDArray[Scalar]]:
    """Find for every pixel the nearest pixel of a mask: its distance and its value.

    Parameters
    ----------
    values : (H, W)
        Read where `there` is True.
    there : (H, W) bool
    mask_size : {3, 5}
        Mask size of the chamfer distance: 5 is closer to the Euclidean distance, 3 is faster.

    Returns
    -------
    (H, W) float32, (H, W)
        Distance [px], 0 inside the mask; and the value of the nearest pixel, 0 if the mask is empty.
    """
    distance, places = cv2.distanceTransformWithLabels(
        (~there).astype(np.uint8), cv2.DIST_L2, mask_size, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_place = np.zeros(int(places.max()) + 1, values.dtype)
    of_place[places[there]] = values[there]
    return np.asarray(distance, np.float32), of_place[places]


def _fill_by_loops(values: Array) -> Array:
    height, width = values.shape
    filled = values.copy()
    above, below, near, hull = np.full((4, width), -1)
    for y in range(height):
        for x in range(width):
            if not np.isnan(values[y, x]):
                above[x] = below[x] = y
            elif below[x] < y:
                below[x] = y + 1
                while below[x] < height and np.isnan(values[below[x], x]):
                    below[x] += 1
            # the nearest known pixel of the column; of two the upper one
            lower = below[x] < height and (above[x] < 0 or below[x] - y < y - above[x])
            near[x] = below[x] if lower else above[x]
        start = 0
        while start < width:
            stop = start
            while stop < width and near[stop] != y:
                stop += 1
            if stop > start:
                # nothing beyond the two known pixels at its ends is nearer to any pixel of the gap
                _fill_gap(filled, y, start, stop, near, hull)
            start = stop + 1
    return filled


@compiled()
def _fill_gap(filled: Array, y: int, start: int, stop: int, near: NDArray[np.intp], hull: NDArray[np.intp]) -> None:
    """Fill a row's missing pixels from `start` to `stop`, given the row of the nearest known pixel in every column.

    Over a row, the squared distance to one column's pixel is a parabola; `hull` has the columns that are the nearest
    somewhere, from left to right. All is in whole numbers, and therefore exact.
    """
    last = -1
    for x in range(max(start - 1, 0), min(stop + 1, near.size)):
        if near[x] < 0:
            continue
        while last >= 1:
            left, middle = hull[last - 1], hull[last]
            a, b = middle - left, x - middle
            rise = (a + b) * ((near[middle] - y) ** 2 - a * b) - b * (near[left] - y) ** 2 - a * (near[x] - y) ** 2
            if rise <= 0:
                break
            last -= 1
        last += 1
        hull[last] = x
    place = 0
    for x in range(start, stop):
        while place < last:
            this, following = hull[place], hull[place + 1]
            if (this - x) ** 2 + (near[this] - y) ** 2 <= (following - x) ** 2 + (near[following] - y) ** 2:
                break
            place += 1
        filled[y, x] = filled[near[hull[place]], hull[place]]


@compiled(_fill_by_loops)
def filled_from_nearest(values: Array) -> Array:
    """Replace missing values by those of the nearest known pixel; of several at the same distance, by that of the
    leftmost column, and there of the upper row.

    Parameters
    ----------
    values : (H, W) float32
        NaN = missing; at least one known.

    Returns
    -------
    (H, W) float32
    """
    # the indices alone: SciPy's distances are float64 and take most of its time
    rows, columns = distance_transform_edt(np.isnan(values), return_distances=False, return_indices=True)
    return values[rows, columns]


def connected_regions(values: NDArray[np.integer], *, background: int = 0, diagonal: bool = False) -> NDArray[np.int32]:
    """Number the regions of connected pixels with the same value.

    Parameters
    ----------
    values : (H, W) integer
    background : int
        Pixels with this value are in no region.
    diagonal : bool
        Whether pixels are also connected through their corners.

    Returns
    -------
    (H, W) int32
        Regions 1, 2, ... in the order of their first pixels, row by row; 0 in the background.

    Examples
    --------
    >>> connected_regions(np.array([[7, 0, 7], [7, 7, 0]])).tolist()
    [[1, 0, 2], [1, 1, 0]]
    """
    # pixels of equal value in a row form a run; runs of adjacent rows are connected where they touch
    starts = np.ones(values.shape, bool)
    starts[:, 1:] = values[:, 1:] != values[:, :-1]
    run_at = (np.cumsum(starts, dtype=np.int32) - 1).reshape(values.shape)
    width = values.shape[1]
    touching = []
    for shift in (-1, 0, 1) if diagonal else (0,):
        upper = np.s_[:-1, max(-shift, 0) : width - max(shift, 0)]
        lower = np.s_[1:, max(shift, 0) : width + min(shift, 0)]
        # once for each pair of runs: where one of them starts
        there = (values[upper] == values[lower]) & (starts[upper] | starts[lower])
        touching.append(np.stack([run_at[upper][there], run_at[lower][there]]))
    one, other = np.concatenate(touching, axis=1)
    runs = int(starts.sum())
    links = coo_array((np.ones(one.size, bool), (one, other)), (runs, runs))
    # regions are numbered in the order of their first runs
    region_of = connected_components(links, directed=False)[1]
    counted = np.zeros(runs, bool)
    counted[region_of] = values[starts] != background
    return (np.cumsum(counted, dtype=np.int32) * counted)[region_of][run_at]


def odd_even_fill(line: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels of an image whose centre a closed line (n, 2) of (x, y) encloses an odd number of times.

    From left to right along the centres of every row, each crossing of the line switches between outside and inside.
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


def drawn_from(mask: NDArray[np.bool_], rng: np.random.Generator, chosen: slice) -> NDArray[np.bool_]:
    """Some pixels of a mask: those at these places of a random order."""
    found = np.zeros(mask.shape, bool)
    found.flat[rng.permutation(np.flatnonzero(mask))[chosen]] = True
    return found


# Strips of an image.

_STRIP = 64
"""Number of rows that are worked out together, so that what that takes stays in the cache and needs no fresh memory."""


def strips(height: int, halo: int = 0, rows: int = _STRIP) -> Iterator[tuple[slice, slice, slice]]:
    """Divide the rows of an image into strips of so many rows.

    Yields
    ------
    rows, wider, inner : slice
        The rows of a strip; the same with up to `halo` rows more on both sides, as far as the image goes; and where the
        former are among the latter.
    """
    for top in range(0, height, rows):
        stop, first = min(top + rows, height), max(top - halo, 0)
        yield slice(top, stop), slice(first, min(stop + halo, height)), slice(top - first, stop - first)


# Pairs of neighbouring pixels: each pixel with its right neighbour, and with its lower neighbour.

Pairs = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Pairs with right neighbours, shape (H, W - 1), and with lower ones, shape (H - 1, W)."""


def sides(values: NDArray[Any]) -> tuple[tuple[NDArray[Any], NDArray[Any]], tuple[NDArray[Any], NDArray[Any]]]:
    """Return the values of both pixels of every pair: (left, right) and (upper, lower), from values of shape (H, W)."""
    return (values[:, :-1], values[:, 1:]), (values[:-1], values[1:])


def neighbours(*values: NDArray[Any]) -> Iterator[tuple[tuple[NDArray[Any], NDArray[Any]], ...]]:
    """Yield, for each of a pixel's four neighbours, the values of both, (here, there), from those of shape (H, W)."""
    for pairs in zip(*map(sides, values), strict=True):
        yield pairs
        yield tuple((there, here) for here, there in pairs)


def rim(values: NDArray[Any]) -> NDArray[Any]:
    """Return the values along the four sides of an image; those of the corners twice."""
    return np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])


def both(mask: NDArray[np.bool_]) -> Pairs:
    """Return the pairs with both pixels in a mask of shape (H, W)."""
    right, below = (one & other for one, other in sides(mask))
    return right, below


def different_labels(labels: NDArray[np.int32]) -> Pairs:
    """Return the pairs with different labels in a map of shape (H, W)."""
    right, below = (one != other for one, other in sides(labels))
    return right, below


def mark(pairs: Pairs) -> NDArray[np.bool_]:
    """Draw pairs as a mask of shape (H, W), 1 px wide: the left or upper pixel of every pair is set."""
    right, below = pairs
    marked = np.zeros((right.shape[0], below.shape[1]), bool)
    marked[:, :-1] |= right
    marked[:-1] |= below
    return marked


def mark_both(pairs: Pairs) -> NDArray[np.bool_]:
    """Draw pairs as a mask of shape (H, W), 2 px wide: both pixels of every pair are set."""
    marked = mark(pairs)
    marked[:, 1:] |= pairs[0]
    marked[1:] |= pairs[1]
    return marked


def long_lines(pairs: Pairs, length: int) -> Pairs:
    """Return the pairs in 8-connected lines of more than `length` pixels."""
    _, lines, sizes, _ = cv2.connectedComponentsWithStats(mark(pairs).view(np.uint8), connectivity=8)
    long = (sizes[:, cv2.CC_STAT_AREA] > length)[lines]
    return pairs[0] & long[:, :-1], pairs[1] & long[:-1]


def piece_sizes(mask: NDArray[np.bool_], links: Pairs) -> NDArray[np.int32]:
    """Return the number of pixels of the piece that each pixel of a mask belongs to, int32 (H, W); 0 elsewhere. Pairs
    of linked pixels are in one piece."""
    height, width = mask.shape
    # a grid of pixels with their links in between: its connected components are the pieces
    grid = np.zeros((2 * height - 1, 2 * width - 1), np.uint8)
    grid[::2, ::2], grid[::2, 1::2], grid[1::2, ::2] = mask, *links
    _, labels = cv2.connectedComponents(grid, connectivity=4, ltype=cv2.CV_32S)
    pieces = np.ascontiguousarray(labels[::2, ::2])
    sizes = np.bincount(pieces.reshape(-1)).astype(np.int32)
    sizes[0] = 0
    return np.asarray(sizes[pieces])


def spread(values: NDArray[Scalar], waiting: NDArray[np.bool_], passages: Pairs, rounds: int) -> NDArray[Scalar]:
    """Give pixels the value of the nearest pixel that has one, going from neighbour to neighbour.

    Parameters
    ----------
    values : (H, W)
        0 for none.
    waiting : (H, W) bool
        The pixels that get a value, which is 0 before.
    passages : Pairs
        The neighbours between which values pass.
    rounds : int
        How many pixels a value goes at most.

    Returns
    -------
    (H, W)
        0 where a waiting pixel was not reached.
    """
    # nothing passes the sides of the image, so that it does not matter which pixel is taken for a neighbour there
    across, down = np.pad(passages[0], ((0, 0), (0, 1))).ravel(), np.pad(passages[1], ((0, 1), (0, 0))).ravel()
    found, left = values.flatten(), np.flatnonzero(waiting)
    for _ in range(rounds):
        here = np.zeros(left.size, values.dtype)
        for way, step in ((across, 1), (down, values.shape[1])):
            for neighbour, passage in ((left - step, way[left - step]), (left + step, way[left])):
                here = np.where((here == 0) & passage, found.take(neighbour, mode="wrap"), here)
        if not here.any():
            break
        found[left] = here
        left = left[here == 0]
    return found.reshape(values.shape)


# Halving and doubling the grid of an image.


def sums_of_four(values: Array, mode: str = "constant") -> Array:
    """Return sums over 2 x 2 pixels, float32 ((H + 1) // 2, (W + 1) // 2); `mode` of `np.pad` pads odd sides."""
    upper_left, lower_left, upper_right, lower_right = _quarters(_even(values, mode))
    return upper_left + lower_left + upper_right + lower_right


def largest_of_four(values: Array) -> Array:
    """Return maxima over 2 x 2 pixels."""
    return np.maximum.reduce(_quarters(_even(values, "edge")))


def enlarged(values: Array, shape: tuple[int, ...]) -> Array:
    """Interpolate values of a halved grid bilinearly to the original grid of this shape."""
    size = (2 * values.shape[1], 2 * values.shape[0])
    return np.ascontiguousarray(cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]])


def _even(values: Array, mode: str) -> Array:
    """Pad odd sides."""
    border = {"constant": cv2.BORDER_CONSTANT, "edge": cv2.BORDER_REPLICATE}[mode]
    below, right = (size % 2 for size in values.shape)
    return cv2.copyMakeBorder(values, 0, below, 0, right, border) if below or right else values  # type: ignore[return-value]


def _quarters(even: Array) -> tuple[Array, Array, Array, Array]:
    return even[::2, ::2], even[1::2, ::2], even[::2, 1::2], even[1::2, 1::2]
