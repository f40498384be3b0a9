"""The noise of structured-light cameras, for scenes whose depth is known exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Depth = NDArray[np.float64]


@dataclass(frozen=True)
class StructuredLight:
    """A camera that measures disparity in steps, as a Kinect of the first kind does.

    Attributes
    ----------
    focal : float
        Focal length [px].
    baseline : float
        From the camera to the pattern projector [m].
    steps_per_pixel : int
        Disparity is measured in such fractions of a pixel.
    noise : float
        Standard deviation of the disparity [steps]; by default 1.3 mm at 1 m, growing with the square of the range.
    """

    focal: float
    baseline: float = 0.075
    steps_per_pixel: int = 8
    noise: float = 0.45

    @property
    def scale(self) -> float:
        """Depth x disparity [m x steps]."""
        return self.steps_per_pixel * self.focal * self.baseline

    def measured(self, depth: Depth, rng: np.random.Generator) -> Depth:
        """Depth [m], (H, W), with lateral jitter, correlated disparity noise and disparity steps."""
        height, width = depth.shape
        rows, columns = np.mgrid[:height, :width]
        jitter = np.round(0.45 * rng.standard_normal((2, height, width))).astype(int)
        seen = depth[np.clip(rows + jitter[0], 0, height - 1), np.clip(columns + jitter[1], 0, width - 1)]
        # Neighbours share most of their matching window, hence most of their error.
        shared = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 1.2)
        error = 0.8 * shared / shared.std() + 0.6 * rng.standard_normal(depth.shape)
        steps = np.round(self.scale / seen + self.noise * error)
        return self.scale / np.maximum(steps, 1)

    def deviation(self, depth: Depth) -> Depth:
        """Standard deviation [m] of noise and steps together at a depth, without the jitter."""
        return depth**2 / self.scale * math.sqrt(self.noise**2 + 1 / 12)
