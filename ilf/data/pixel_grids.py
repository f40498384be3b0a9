"""Operations on pixel grids: nearest pixels, connected regions, the watershed, pairs of neighbours, and halving."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .._runtime.compiling import compiled, is_compiled
from .._runtime.long_work import check_cancelled

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


def distance_to(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Distance to the nearest pixel of a mask [px], float32 (H, W); infinite if there is none."""
    if not mask.any():
        return np.full(mask.shape, np.inf, np.float32)
    return np.asarray(cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, 5), np.float32)


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


# The watershed.

_PIXELS_PER_CHECK = 20_000
"""Number of pixels that are flooded between two checks for cancellation: 2 ms of machine code, 0.1 s of Python."""

_STEPS_PER_PIXEL, _MAX_STEPS = 4, 1 << 20
"""Heights are rounded to so many steps: with fewer, their order is lost; with more, looking for the next one takes as
long as the pixels."""

Numbers = NDArray[np.int32]


def flood(heights: NDArray[np.float32], markers: NDArray[np.int32], mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Grow regions over their 4-connected neighbours in order of height, until they meet.

    Where all heights differ by more than a step, it is the watershed of scikit-image, pixel by pixel, but it can be
    cancelled. Without numba it takes about 20 times as long as compiled.

    Pixels that have been reached are queued: every step of the heights has a queue, and the lowest comes first, where
    the height of a pixel is at least the level at which it was reached. In a queue, markers come first, row by row,
    then what is reached from them, in this order.

    Parameters
    ----------
    heights : ndarray of float32, shape (H, W)
        Finite values; between the lowest and the highest, 4 steps a pixel are told apart, up to a million.
    markers : ndarray of int32, shape (H, W)
        Regions > 0 to grow, 0 elsewhere. Markers outside the mask are ignored.
    mask : ndarray of bool, shape (H, W)
        Pixels into which they may grow.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions; 0 outside the mask, and in pixels that no region can reach.
    """
    number = min(_STEPS_PER_PIXEL * mask.size, _MAX_STEPS)
    low, high = np.float32(heights.min()), float(heights.max())
    per_height = np.float32((number - 1) / max(high - float(low), 1e-30))

    def steps_of(values: NDArray[np.float32]) -> Numbers:
        return ((values - low) * per_height).astype(np.int32)

    # a rim that is never reached, so that every pixel has four neighbours
    height, width = mask.shape[0] + 2, mask.shape[1] + 2
    cells = np.zeros((height, width, 2), np.int32)
    regions = cells[1:-1, 1:-1, 0]
    for rows, *_ in strips(len(mask)):
        regions[rows] = np.where(markers[rows] > 0, markers[rows], ~steps_of(heights[rows])) * mask[rows]
    marked = np.flatnonzero((markers > 0) & mask)
    steps = steps_of(heights.ravel()[marked])
    marked += width + 1 + 2 * (marked // mask.shape[1])
    arrays: list[Any] = [cells.ravel(), np.full(2 * number, -1, np.int32), marked, steps]
    if not is_compiled():  # for Python, elements of a memoryview are twice as fast as those of an array
        arrays = [memoryview(array) for array in arrays]
    flat, ends, *_ = arrays
    _fill_queues(*arrays)
    reached = 0
    while reached < number:
        check_cancelled()
        reached = _grow_by_steps(flat, ends, reached, _PIXELS_PER_CHECK, width)
    return np.maximum(regions, 0)


@compiled()
def _fill_queues(cells: Numbers, ends: Numbers, marked: NDArray[np.intp], steps: Numbers) -> None:
    """Put marked pixels into the empty queues of their steps."""
    for place in range(len(marked)):
        _append(cells, ends, steps[place], marked[place])


@compiled()
def _append(cells: Numbers, ends: Numbers, step: int, pixel: int) -> None:
    """Put a pixel at the end of a step's queue."""
    cells[2 * pixel + 1] = -1
    if ends[2 * step] < 0:
        ends[2 * step] = pixel
    else:
        cells[2 * ends[2 * step + 1] + 1] = pixel
    ends[2 * step + 1] = pixel


@compiled()
def _grow_by_steps(cells: Numbers, ends: Numbers, step: int, pixels: int, width: int) -> int:
    """Grow the regions from the next `pixels` queued ones, or from all if there are fewer.

    Parameters
    ----------
    cells : ndarray of int32
        Two numbers for each pixel, side by side, since pixels come in no order that a cache foresees. First its region,
        0 if it is never reached, or, until it is reached, -1 minus the step of its height; then the pixel that follows
        it in its queue, -1 for none. Updated in place.
    ends : ndarray of int32
        First and last pixel of every step's queue; the first is -1 if it is empty. Updated in place.
    step : int
        The first step.
    pixels : int
    width : int
        Width of the image with its rim.

    Returns
    -------
    int
        The step that is reached; the number of steps at the end.
    """
    while pixels > 0 and 2 * step < len(ends):
        pixel = ends[2 * step]
        if pixel < 0:
            step += 1
            continue
        region, ends[2 * step] = cells[2 * pixel], cells[2 * pixel + 1]
        pixels -= 1
        for neighbour in (pixel - width, pixel - 1, pixel + 1, pixel + width):
            ground = cells[2 * neighbour]
            if ground < 0:
                cells[2 * neighbour] = region
                _append(cells, ends, max(-1 - ground, step), neighbour)
    return step


# Filled polygons, and pixels drawn from a mask.

_CROSSINGS = 2**20
"""Crossings of a line and rows that are computed at a time."""


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
    turns = np.zeros(height * (width + 1), bool)
    for edges in np.split(np.arange(len(line)), _parts_of(crossed)):
        counts = crossed[edges]
        edge = np.repeat(edges, counts)
        row = np.arange(edge.size) - np.repeat(np.cumsum(counts) - counts, counts) + first[edge]
        (x0, y0), (x1, y1) = upper[edge].T, lower[edge].T
        x = x0 + (row + 0.5 - y0) / (y1 - y0) * (x1 - x0)
        column = np.clip(np.ceil(x - 0.5), 0, width).astype(np.intp)
        turns ^= np.bincount(row * (width + 1) + column, minlength=turns.size) % 2 > 0
    return np.logical_xor.accumulate(turns.reshape(height, width + 1)[:, :width], axis=1)


def _parts_of(counts: NDArray[np.intp]) -> NDArray[np.intp]:
    """Where to divide edges so that those of a part have about `_CROSSINGS` crossings, which fit into memory."""
    return np.searchsorted(np.cumsum(counts), np.arange(_CROSSINGS, counts.sum(), _CROSSINGS))


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


def contrast(values: Array, known: NDArray[np.bool_], around: NDArray[np.integer | np.floating]) -> Array:
    """Return the ratio of the largest known value around each pixel to the smallest, float32 (H, W); 0 without any.

    Parameters
    ----------
    values : (H, W) float32
        Positive where `known` is True.
    known : (H, W) bool
    around : ndarray
        Structuring element.
    """
    largest = cv2.dilate(np.where(known, values, np.float32(0)), around)
    inverse = cv2.dilate(np.divide(1, values, out=np.zeros_like(values), where=known), around)
    return np.asarray(largest * inverse, np.float32)


# Cells of an image, halving and doubling its grid.


def padded(values: NDArray[Any], cell: int, mode: str = "constant", value: float = 0.0) -> NDArray[Any]:
    """Pad the sides of an image, below and on the right, to multiples of `cell`; `mode` as that of `np.pad`."""
    border = {"constant": cv2.BORDER_CONSTANT, "edge": cv2.BORDER_REPLICATE}[mode]
    below, right = (-size % cell for size in values.shape)
    return cv2.copyMakeBorder(values, 0, below, 0, right, border, value=value) if below or right else values


def cells_of(values: NDArray[Any], cell: int, mode: str = "constant", value: float = 0.0) -> NDArray[Any]:
    """Divide an image into cells of cell x cell pixels, (rows of cells, cell, columns of cells, cell), see `padded`."""
    whole = padded(values, cell, mode, value)
    return whole.reshape(whole.shape[0] // cell, cell, whole.shape[1] // cell, cell)


def sums_of_four(values: Array, mode: str = "constant") -> Array:
    """Return sums over 2 x 2 pixels, float32 ((H + 1) // 2, (W + 1) // 2); `mode` of `np.pad` pads odd sides."""
    upper_left, lower_left, upper_right, lower_right = _quarters(padded(values, 2, mode))
    return upper_left + lower_left + upper_right + lower_right


def largest_of_four(values: Array) -> Array:
    """Return maxima over 2 x 2 pixels."""
    return np.maximum.reduce(_quarters(padded(values, 2, "edge")))


def enlarged(values: Array, shape: tuple[int, ...]) -> Array:
    """Interpolate values of a halved grid bilinearly to the original grid of this shape."""
    size = (2 * values.shape[1], 2 * values.shape[0])
    return np.ascontiguousarray(cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]])


def _quarters(even: Array) -> tuple[Array, Array, Array, Array]:
    return even[::2, ::2], even[1::2, ::2], even[::2, 1::2], even[1::2, 1::2]
