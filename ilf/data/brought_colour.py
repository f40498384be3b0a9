"""Colour of a frame in the pixels of its depth camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .camera import Camera


@dataclass(frozen=True, eq=False)
class BroughtColour:
    """How the colour of a frame in the depth camera's view was brought there (`ilf.sources.registration.register`).

    Attributes
    ----------
    seen : ndarray of bool, shape (H, W)
        Pixels that the colour camera sees; the frame's `rgb` is black elsewhere.
    edge_rgb : ndarray of uint8, shape (H, W, 3)
        The frame's `rgb` with the other pixels filled smoothly, so that their outline is no evidence of an edge.
    camera : Camera
        The colour camera, without distortion and with its size.
    depth_to_colour : ndarray of float64, shape (4, 4)
        Transform of points [m] from the depth camera to the colour camera.
    """

    seen: NDArray[np.bool_]
    edge_rgb: NDArray[np.uint8]
    camera: Camera
    depth_to_colour: NDArray[np.float64]
