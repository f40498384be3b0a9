"""Noise of which outlines of holes are made."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def smooth_noise(shape: tuple[int, ...], grain: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Noise of mean 0 and variance about 1, whose hills are about `grain` px wide, float32 (H, W)."""
    height, width = shape
    if grain <= 1:
        return rng.standard_normal(shape, np.float32)
    coarse = rng.standard_normal((int(height / grain) + 3, int(width / grain) + 3), np.float32)
    field = cv2.resize(coarse, None, fx=grain, fy=grain, interpolation=cv2.INTER_CUBIC)
    top, left = int(rng.integers(field.shape[0] - height + 1)), int(rng.integers(field.shape[1] - width + 1))
    # Between the coarse samples the cubic's variance is about two thirds of theirs.
    return np.asarray(field[top : top + height, left : left + width] * np.float32(1.25), np.float32)
