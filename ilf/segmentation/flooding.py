"""Watershed that can be cancelled while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import check_cancelled
from .._runtime.compiling import compiled, is_compiled
from ..data.pixel_grids import strips

_PIXELS_PER_CHECK = 20_000
"""Number of pixels that are flooded between two checks for cancellation: 5 ms of machine code, 0.1 s of Python."""

_MAX_PIXELS, _STEPS = 1 << 22, 1 << 20
"""Number of pixels above which heights may be rounded to so many steps."""

Keys = NDArray[np.int64]
Pixels = NDArray[np.int32]


def flood(heights: NDArray[np.float32], markers: NDArray[np.int32], mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Grow regions over their 4-connected neighbours in order of height, until they meet.

    Same result as the watershed of scikit-image, pixel by pixel, but it can be cancelled. Without numba it takes about
    20 times as long as compiled.

    Pixels that have been reached are queued in a binary heap. The lowest comes first, where the height of a pixel is at
    least the level at which it was reached; among equals the one reached first; among equal markers, which are queued
    from the start, the one on top of the heap.

    Parameters
    ----------
    heights : ndarray of float32, shape (H, W)
        Finite values.
    markers : ndarray of int32, shape (H, W)
        Regions > 0 to grow, 0 elsewhere. Markers outside the mask are ignored.
    mask : ndarray of bool, shape (H, W)
        Pixels into which they may grow.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions; 0 outside the mask, and in pixels that no region can reach.
    """
    # a rim that is never reached, so that every pixel has four neighbours
    regions = np.pad(np.where(mask, markers, 0).astype(np.int32, copy=False), 1)
    dry = np.pad(mask, 1) & (regions == 0)
    levels = np.zeros(regions.shape, np.int64)
    np.left_shift(_ranks(heights), 32, out=levels[1:-1, 1:-1], dtype=np.int64)
    room = np.count_nonzero(mask)
    arrays: list[Any] = [levels.ravel(), dry.ravel(), regions.ravel(), np.flatnonzero(regions)]
    arrays += [np.empty(room, np.int64), np.empty(room, np.int32)]
    *flat, marked, keys, pixels = _for_loops(arrays)
    waiting, reached = fill_heap((keys, pixels), flat[0], marked), 0
    while waiting > 0:
        check_cancelled()
        waiting, reached = grow_regions((keys, pixels), waiting, reached, _PIXELS_PER_CHECK, regions.shape[1], *flat)
    return np.ascontiguousarray(regions[1:-1, 1:-1])


def flood_large(heights: NDArray[np.float32], markers: NDArray[np.int32], mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Do the same as `flood`, faster for a large image: its heights are rounded to a million steps with a
    queue each, and equal markers come row by row."""
    if mask.size <= _MAX_PIXELS:
        return flood(heights, markers, mask)
    low, high = np.float32(heights.min()), float(heights.max())
    per_height = np.float32((_STEPS - 1) / max(high - float(low), 1e-6))

    def steps_of(values: NDArray[np.float32]) -> NDArray[np.int32]:
        return ((values - low) * per_height).astype(np.int32)

    # a rim that is never reached, so that every pixel has four neighbours
    width = mask.shape[1] + 2
    cells = np.zeros((mask.shape[0] + 2, width, 2), np.int32)
    regions = cells[1:-1, 1:-1, 0]
    for rows, *_ in strips(len(mask)):
        regions[rows] = np.where(markers[rows] > 0, markers[rows], ~steps_of(heights[rows])) * mask[rows]
    marked = np.flatnonzero((markers > 0) & mask)
    steps = steps_of(heights.ravel()[marked])
    marked += width + 1 + 2 * (marked // mask.shape[1])
    flat, ends, *queued = _for_loops([cells.ravel(), np.full(2 * _STEPS, -1, np.int32), marked, steps])
    fill_queues(flat, ends, *queued)
    reached = 0
    while reached < _STEPS:
        check_cancelled()
        reached = grow_by_steps(flat, ends, reached, _PIXELS_PER_CHECK, width)
    return np.maximum(regions, 0)


def _for_loops(arrays: list[Any]) -> list[Any]:
    """For Python, elements of a memoryview are twice as fast as those of an array."""
    return arrays if is_compiled() else [memoryview(array) for array in arrays]


def _ranks(heights: NDArray[np.float32]) -> NDArray[np.int32]:
    """Integers in the order of the heights, equal for equal heights."""
    bits = (heights.astype(np.float32, copy=False) + np.float32(0)).view(np.int32)  # adding 0 turns -0 into 0
    bits ^= (bits >> 31) & np.int32(0x7FFFFFFF)  # all but the sign of negative ones
    return bits


@compiled()
def fill_heap(heap: tuple[Keys, Pixels], levels: Keys, marked: NDArray[np.intp]) -> int:
    """Put marked pixels into an empty heap; returns the number of queued pixels."""
    for waiting in range(len(marked)):
        push(heap, waiting, levels[marked[waiting]], marked[waiting])
    return len(marked)


@compiled()
def push(heap: tuple[Keys, Pixels], waiting: int, key: int, pixel: int) -> None:
    """Put a pixel into a heap with `waiting` queued pixels."""
    keys, pixels = heap
    place = waiting
    while place > 0:
        above = (place - 1) // 2
        if keys[above] <= key:
            break
        keys[place], pixels[place] = keys[above], pixels[above]
        place = above
    keys[place], pixels[place] = key, pixel


@compiled()
def pop_first(heap: tuple[Keys, Pixels], waiting: int) -> None:
    """Remove the first pixel from a heap with `waiting` queued pixels: the last one replaces it and is sifted down."""
    keys, pixels = heap
    last = waiting - 1
    key, pixel = keys[last], pixels[last]
    place, below = 0, 1
    while below < last:
        if below + 1 < last and keys[below + 1] < keys[below]:
            below += 1
        if key <= keys[below]:
            break
        keys[place], pixels[place] = keys[below], pixels[below]
        place, below = below, 2 * below + 1
    keys[place], pixels[place] = key, pixel


@compiled()
def grow_regions(
    heap: tuple[Keys, Pixels],
    waiting: int,
    reached: int,
    steps: int,
    width: int,
    levels: Keys,
    dry: NDArray[np.bool_],
    regions: NDArray[np.int32],
) -> tuple[int, int]:
    """Grow the regions from the next `steps` queued pixels, or from all if there are fewer.

    Parameters
    ----------
    heap : tuple of ndarray
        Keys (a pixel's level plus the order in which it was reached) and pixels, with room for all.
    waiting, reached : int
        Number of queued pixels, and of pixels reached so far.
    steps : int
    width : int
        Width of the image with its rim.
    levels : ndarray of int64
        Level of each pixel in multiples of 2^32; raised to the level at which it is reached, in place.
    dry : ndarray of bool
        Pixels that have not been reached, updated in place.
    regions : ndarray of int32
        Updated in place.

    Returns
    -------
    waiting, reached : int
    """
    for _ in range(steps):
        if waiting == 0:
            break
        pixel = heap[1][0]
        pop_first(heap, waiting)
        waiting -= 1
        for neighbour in (pixel - width, pixel - 1, pixel + 1, pixel + width):
            if dry[neighbour]:
                dry[neighbour] = False
                regions[neighbour] = regions[pixel]
                levels[neighbour] = max(levels[neighbour], levels[pixel])
                reached += 1
                push(heap, waiting, levels[neighbour] + reached, neighbour)
                waiting += 1
    return waiting, reached


@compiled()
def fill_queues(cells: Pixels, ends: Pixels, marked: NDArray[np.intp], steps: Pixels) -> None:
    """Put marked pixels into the empty queues of their steps."""
    for place in range(len(marked)):
        append(cells, ends, steps[place], marked[place])


@compiled()
def append(cells: Pixels, ends: Pixels, step: int, pixel: int) -> None:
    """Put a pixel at the end of a step's queue."""
    cells[2 * pixel + 1] = -1
    if ends[2 * step] < 0:
        ends[2 * step] = pixel
    else:
        cells[2 * ends[2 * step + 1] + 1] = pixel
    ends[2 * step + 1] = pixel


@compiled()
def grow_by_steps(cells: Pixels, ends: Pixels, step: int, pixels: int, width: int) -> int:
    """Grow the regions from the next `pixels` queued ones, or from all if there are fewer; like `grow_regions`.

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
                append(cells, ends, max(-1 - ground, step), neighbour)
    return step
