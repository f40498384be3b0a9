"""Tiles of noise, made once, that patterns look values up in."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

SIDE = 512
"""Pixels of a tile; one unit of its coordinates is 1 / 8 of it."""


@cache
def _tile(kind: str) -> np.ndarray:
    """Noise that repeats without a seam, mean 0 and standard deviation 1."""
    slope, stretch, number = {"cloud": (1.4, 1.0, 1), "grain": (0.0, 1.0, 2), "fibre": (0.9, 14.0, 3)}[kind]
    rng = np.random.default_rng([20, number])
    across, down = np.meshgrid(np.fft.rfftfreq(SIDE), np.fft.fftfreq(SIDE))
    frequency = np.hypot(across * stretch, down)
    frequency[0, 0] = np.inf
    strength = np.maximum(frequency, 2 / SIDE) ** -slope * (frequency < 0.3)
    made = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIDE, SIDE))) * strength, (SIDE, SIDE))
    return ((made - made.mean()) / made.std()).astype(np.float32)


def noise(kind: str, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Noise at points, (N,): "cloud" at all scales, "grain" fine, "fibre" drawn out along u."""
    columns = 1024
    rows = -(-len(u) // columns)
    where = np.zeros((2, rows * columns), np.float32)
    for axis, x in zip(where, (u, v), strict=True):
        axis[: len(x)] = np.mod(x * (SIDE / 8), SIDE)
    x, y = where.reshape(2, rows, columns)
    return cv2.remap(_tile(kind), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP).ravel()[: len(u)]


def hashed(*integers: np.ndarray) -> np.ndarray:
    """Number in [0, 1) that belongs to a lattice cell, (N,)."""
    mixed = np.zeros(len(integers[0]), np.uint32)
    for i in integers:
        mixed = (mixed ^ i.astype(np.int32).view(np.uint32)) * np.uint32(0x9E3779B1)
        mixed ^= mixed >> np.uint32(15)
        mixed *= np.uint32(0x85EBCA77)
        mixed ^= mixed >> np.uint32(13)
    return (mixed >> np.uint32(8)).astype(np.float32) / np.float32(2**24)
