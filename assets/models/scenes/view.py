"""What a depth camera looks at, and the random fields that its faults follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

SKY = 60.0
"""Depth [m] that stands for nothing there while a camera is simulated."""


@dataclass(frozen=True, eq=False)
class View:
    """A scene as a depth camera's light meets it, everything (H, W).

    Attributes
    ----------
    depth : ndarray of float32
        Depth [m], `SKY` where there is nothing.
    normals : ndarray of float32, shape (H, W, 3)
        In camera coordinates.
    facing : ndarray of float32
        Cosine between the surface's normal and the direction to the camera, 0 to 1.
    shade : ndarray of float32
        How much light comes back from it, 0 to 1.
    flags : mapping of str to ndarray of bool
        "black", "glossy", "transparent" and "emitting" surfaces.
    unlit : ndarray of bool
        What a projector beside the camera does not reach.
    """

    depth: np.ndarray
    normals: np.ndarray
    facing: np.ndarray
    shade: np.ndarray
    flags: Mapping[str, np.ndarray]
    unlit: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        height, width = self.depth.shape
        return height, width


def facing(normals: np.ndarray, K: np.ndarray | tuple[float, ...]) -> np.ndarray:
    """Cosine between normals (H, W, 3) and the direction to the camera."""
    fx, fy, cx, cy = (np.float32(value) for value in K)
    height, width = normals.shape[:2]
    x = ((np.arange(width, dtype=np.float32) - cx) / fx)[None, :]
    y = ((np.arange(height, dtype=np.float32) - cy) / fy)[:, None]
    along = normals[..., 0] * x + normals[..., 1] * y + normals[..., 2]
    return np.abs(along) / np.sqrt(x**2 + y**2 + 1)


def smooth_noise(shape: tuple[int, ...], grain: float, rng: np.random.Generator) -> np.ndarray:
    """Noise of mean 0 and variance about 1 with a wavelength of about `grain` px, float32 (H, W)."""
    height, width = shape
    if grain <= 1:
        return rng.standard_normal(shape, np.float32)
    coarse = rng.standard_normal((int(height / grain) + 3, int(width / grain) + 3), np.float32)
    field = cv2.resize(coarse, None, fx=grain, fy=grain, interpolation=cv2.INTER_CUBIC)
    top, left = int(rng.integers(field.shape[0] - height + 1)), int(rng.integers(field.shape[1] - width + 1))
    # Cubic interpolation reduces the variance to about two thirds between the coarse samples.
    return np.asarray(field[top : top + height, left : left + width] * np.float32(1.25), np.float32)


def ragged(shape: tuple[int, int], grain: float, rng: np.random.Generator) -> np.ndarray:
    """`smooth_noise` with smaller ones on them: its outlines are torn."""
    return 0.85 * smooth_noise(shape, grain, rng) + 0.5 * smooth_noise(shape, max(grain / 3.5, 1.2), rng)


def patches(mask: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A standard normal number for each connected patch of a mask, float32 (H, W)."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8))
    return rng.standard_normal(count, dtype=np.float32)[labels]


def jumps(depth: np.ndarray, share: float) -> np.ndarray:
    """Pixels beside which depth jumps by more than a share of it, bool (H, W); a slope, however steep, is none."""
    inverse = 1 / depth
    across = cv2.filter2D(inverse, -1, np.array([[1, -2, 1]], np.float32))
    down = cv2.filter2D(inverse, -1, np.array([[1], [-2], [1]], np.float32))
    return np.maximum(np.abs(across), np.abs(down)) > share * inverse
