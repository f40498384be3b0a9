"""Halving the grid of a picture, and going back."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]


def sums_of_four(values: Array, mode: str = "constant") -> Array:
    """Sums over squares of 2 x 2, float32 ((H + 1) // 2, (W + 1) // 2); `mode` of `np.pad` completes odd sides."""
    return sum(_quarters(values, mode))  # type: ignore[return-value]


def largest_of_four(values: Array) -> Array:
    """Maxima over squares of 2 x 2."""
    return np.maximum.reduce(_quarters(values, "edge"))


def enlarged(values: Array, shape: tuple[int, ...]) -> Array:
    """Values of a halved grid on the grid of this shape that it came from, bilinearly."""
    size = (2 * values.shape[1], 2 * values.shape[0])
    return np.ascontiguousarray(cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]])


def _quarters(values: Array, mode: str) -> tuple[Array, Array, Array, Array]:
    even = values
    if any(size % 2 for size in values.shape):
        even = np.pad(values, [(0, size % 2) for size in values.shape], mode=mode)  # type: ignore[call-overload]
    return even[::2, ::2], even[1::2, ::2], even[::2, 1::2], even[1::2, 1::2]
