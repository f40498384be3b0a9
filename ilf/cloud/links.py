"""Where the surface goes on from a pixel to the next, and where it is cut because depth jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from .points import known_pixels

_STEEPEST = 5.7
"""Tangent of 80 degrees: how steeply a surface may lie to the image for the step to the next pixel to be no jump."""

_NOISE = 0.010
"""Share of depth that a step may be at 1 m whatever the angle, and in proportion farther away, as sensors' noise is."""

_LEAST, _MOST = 0.01, 0.04
"""Share of depth that a step may always be, and above which it is a jump whatever the angle."""

_ON = 2
"""Steeper steps are no jump if the inverse depth goes on alike for so many pixels on both sides: a floor far away."""

_ALIKE = 0.5
"""Share of a step by which those beside it may differ."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Links:
    """Which neighbours lie on one surface.

    Parameters
    ----------
    right : ndarray of bool, shape (H, W - 1)
        Each pixel and the one to its right.
    down : ndarray of bool, shape (H - 1, W)
        Each pixel and the one below.
    """

    right: Mask
    down: Mask


def surface_links(depth: ArrayLike, intrinsics: CameraIntrinsics) -> Links:
    """Find which neighbours lie on one surface.

    Neighbours do unless the surface between them would be seen at a grazing angle (80 degrees), which in depth images
    is nearly always a jump, and the step is larger than noise. There they do if the surface goes on like that for two
    pixels on both sides, as a floor far away does.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). What is not finite and positive is missing, and linked to nothing.
    intrinsics : CameraIntrinsics
        Of this image.

    Examples
    --------
    >>> links = surface_links([[2.0, 2.01, 3.0, np.nan]], CameraIntrinsics(500.0, 500.0, 2.0, 0.0))
    >>> links.right.tolist(), links.down.shape
    ([[True, False, False]], (0, 4))
    """
    image = np.asarray(depth, np.float32)
    inverse = np.full(image.shape, np.nan, np.float32)
    np.divide(1, image, out=inverse, where=known_pixels(image))
    return Links(_along_rows(inverse, intrinsics.fx), _along_rows(inverse.T, intrinsics.fy).T)


def _along_rows(inverse: NDArray[np.float32], focal: float) -> Mask:
    """Whether the surface goes on from each pixel to the next of its row; inverse depth [1/m], NaN = missing."""
    if inverse.shape[1] < 2:
        return np.zeros((inverse.shape[0], 0), bool)
    step = np.diff(inverse, axis=1)
    size = np.abs(step)
    nearer, farther = np.maximum(inverse[:, 1:], inverse[:, :-1]), np.minimum(inverse[:, 1:], inverse[:, :-1])
    share = size / farther  # that of the depth's step in the nearer depth
    linked = share <= np.clip(np.maximum(_STEEPEST / focal, _NOISE / nearer), _LEAST, _MOST)
    goes_on = ~linked & np.isfinite(share)
    for away in range(1, _ON + 1):
        alike = np.abs(step[:, away:] - step[:, :-away])
        goes_on[:, :away] = goes_on[:, -away:] = False
        goes_on[:, away:] &= alike <= _ALIKE * size[:, away:]
        goes_on[:, :-away] &= alike <= _ALIKE * size[:, :-away]
    return np.asarray(linked | goes_on)
