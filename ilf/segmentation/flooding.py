"""Watershed that can be cancelled while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import check_cancelled
from .._runtime.compiling import compiled, is_compiled
from ..data.pixel_grids import strips

_PIXELS_PER_CHECK = 20_000
"""Number of pixels that are flooded between two checks for cancellation: 2 ms of machine code, 0.1 s of Python."""

_STEPS_PER_PIXEL, _MAX_STEPS = 4, 1 << 20
"""Heights are rounded to so many steps: with fewer, their order is lost; with more, looking for the next one takes as
long as the pixels."""

Pixels = NDArray[np.int32]


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

    def steps_of(values: NDArray[np.float32]) -> Pixels:
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
    fill_queues(*arrays)
    reached = 0
    while reached < number:
        check_cancelled()
        reached = grow_by_steps(flat, ends, reached, _PIXELS_PER_CHECK, width)
    return np.maximum(regions, 0)


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
                append(cells, ends, max(-1 - ground, step), neighbour)
    return step
