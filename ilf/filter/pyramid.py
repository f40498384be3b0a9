"""Halving the grid of a picture, and going back."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..compiling import compiled

Array = NDArray[np.float32]


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
