"""The nearest pixel of some, seen from every pixel."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.compiling import compiled

Array = NDArray[np.float32]


def nearest_values(values: Array, there: NDArray[np.bool_], mask_size: int = 5) -> tuple[Array, Array]:
    """How far it is to the nearest of some pixels, and what is there.

    Parameters
    ----------
    values : (H, W) float32
        Looked at where `there` is True.
    there : (H, W) bool
    mask_size : {3, 5}
        Of the chamfer distance: 5 is closer to the Euclidean one, 3 is faster.

    Returns
    -------
    (H, W) float32, (H, W) float32
        Distance [px], 0 where `there`; and the value there. Values are 0 if there is no such pixel.
    """
    distance, places = cv2.distanceTransformWithLabels(
        (~there).astype(np.uint8), cv2.DIST_L2, mask_size, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_place = np.zeros(int(places.max()) + 1, np.float32)
    of_place[places[there]] = values[there]
    return np.asarray(distance, np.float32), of_place[places]


# What holds between neighbouring pixels: between each one and its right neighbour, and its lower one.

Pairs = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Right neighbours, shape (H, W - 1), and lower ones, shape (H - 1, W)."""


def sides(values: NDArray[Any]) -> tuple[tuple[NDArray[Any], NDArray[Any]], tuple[NDArray[Any], NDArray[Any]]]:
    """Both pixels of every pair: (left, right) and (upper, lower) of values of shape (H, W)."""
    return (values[:, :-1], values[:, 1:]), (values[:-1], values[1:])


def both(mask: NDArray[np.bool_]) -> Pairs:
    """Neighbours that both are in a mask of shape (H, W)."""
    right, below = (one & other for one, other in sides(mask))
    return right, below


def apart(labels: NDArray[np.int32]) -> Pairs:
    """Neighbours of different labels in a map of shape (H, W)."""
    right, below = (one != other for one, other in sides(labels))
    return right, below


def mark(pairs: Pairs) -> NDArray[np.bool_]:
    """Pairs as a picture of shape (H, W), a line 1 px wide: the left or upper pixel of every pair is set."""
    right, below = pairs
    marked = np.zeros((right.shape[0], below.shape[1]), bool)
    marked[:, :-1] |= right
    marked[:-1] |= below
    return marked


def long_lines(pairs: Pairs, length: int) -> Pairs:
    """Those pairs whose 8-connected lines are longer than `length` pixels."""
    _, lines, sizes, _ = cv2.connectedComponentsWithStats(mark(pairs).astype(np.uint8), connectivity=8)
    long = sizes[:, cv2.CC_STAT_AREA][lines] > length
    return pairs[0] & long[:, :-1], pairs[1] & long[:-1]


# Halving the grid of a picture, and going back.


def sums_of_four(values: Array, mode: str = "constant") -> Array:
    """Sums over squares of 2 x 2, float32 ((H + 1) // 2, (W + 1) // 2); `mode` of `np.pad` completes odd sides."""
    return _sums(_even(values, mode))


def largest_of_four(values: Array) -> Array:
    """Maxima over squares of 2 x 2."""
    return _largest(_even(values, "edge"))


def enlarged(values: Array, shape: tuple[int, ...]) -> Array:
    """Values of a halved grid on the grid of this shape that it came from, bilinearly."""
    size = (2 * values.shape[1], 2 * values.shape[0])
    return np.ascontiguousarray(cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]])


def _even(values: Array, mode: str) -> Array:
    """Odd sides completed."""
    border = {"constant": cv2.BORDER_CONSTANT, "edge": cv2.BORDER_REPLICATE}[mode]
    below, right = (size % 2 for size in values.shape)
    return cv2.copyMakeBorder(values, 0, below, 0, right, border) if below or right else values  # type: ignore[return-value]


def _quarters(even: Array) -> tuple[Array, Array, Array, Array]:
    return even[::2, ::2], even[1::2, ::2], even[::2, 1::2], even[1::2, 1::2]


def _add(even: Array) -> Array:
    result = np.empty((even.shape[0] // 2, even.shape[1] // 2), np.float32)
    for y in range(result.shape[0]):
        upper, lower, row = even[2 * y], even[2 * y + 1], result[y]
        for x in range(row.size):
            row[x] = upper[2 * x] + lower[2 * x] + upper[2 * x + 1] + lower[2 * x + 1]
    return result


@compiled(_add)
def _sums(even: Array) -> Array:
    return sum(_quarters(even))  # type: ignore[return-value]


def _take_largest(even: Array) -> Array:
    result = np.empty((even.shape[0] // 2, even.shape[1] // 2), np.float32)
    for y in range(result.shape[0]):
        upper, lower, row = even[2 * y], even[2 * y + 1], result[y]
        for x in range(row.size):
            row[x] = max(max(upper[2 * x], lower[2 * x]), max(upper[2 * x + 1], lower[2 * x + 1]))
    return result


@compiled(_take_largest)
def _largest(even: Array) -> Array:
    return np.maximum.reduce(_quarters(even))
