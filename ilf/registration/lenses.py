"""What lenses do to images, and images as a lens without distortion would give them."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..camera import CameraIntrinsics
from ..errors import InputError
from ..masks import fixed
from .pair import Camera

_WIDEST = 3.0
"""Tangent of the angle to the axis up to which rays are followed: 71.6 degrees."""

_RADIAL_STEPS = 3000

_BORDER_STEPS = 400
"""Points of each side of a colour image by which the undistorted image's size is found."""

_CLOSE = 0.05
"""How far a border point may come out from where it was [px] for a distortion to count as undone."""


@lru_cache(maxsize=8)
def widest(distortion: tuple[float, ...]) -> float:
    """Tangent of the largest angle to the axis up to which farther out in the scene is farther out in the image.

    Beyond it the model of the lens folds back, and would show things that the camera never saw.
    """
    k1, k2, _, _, k3, k4, k5, k6 = (*distortion, *(0.0,) * (8 - len(distortion)))
    radius = np.linspace(0.0, _WIDEST, _RADIAL_STEPS)
    square = radius**2
    below = 1 + square * (k4 + square * (k5 + square * k6))
    with np.errstate(divide="ignore", invalid="ignore"):
        seen = radius * (1 + square * (k1 + square * (k2 + square * k3))) / below
    falls = ~(np.diff(seen) > 0) | (below[1:] <= 0)
    return float(radius[np.argmax(falls)]) if falls.any() else _WIDEST


@lru_cache(maxsize=8)
def undistorted_view(camera: Camera) -> tuple[CameraIntrinsics, NDArray[np.float32], NDArray[np.float32]]:
    """How an image of the same size without distortion is made, each of whose pixels has a source in the camera's.

    Returns
    -------
    CameraIntrinsics
        Of the new image: the largest rectangle without gaps that has the same ratio of focal lengths.
    ndarray, ndarray of float32, shape (H, W)
        Column and row [px] in the camera's image that each pixel comes from.

    Raises
    ------
    InputError
        If the distortion cannot be undone over the image.
    """
    width, height = camera.size
    across, down = np.linspace(0, width - 1, _BORDER_STEPS), np.linspace(0, height - 1, _BORDER_STEPS)
    left = _rays(camera, np.zeros_like(down), down)[:, 0].max()
    right = _rays(camera, np.full_like(down, width - 1), down)[:, 0].min()
    top = _rays(camera, across, np.zeros_like(across))[:, 1].max()
    bottom = _rays(camera, across, np.full_like(across, height - 1))[:, 1].min()
    own = camera.intrinsics
    if not (left < right and top < bottom):
        raise _cannot_be_undone(camera)
    scale = float(max((width - 1) / own.fx / (right - left), (height - 1) / own.fy / (bottom - top)))
    fx, fy = scale * own.fx, scale * own.fy
    cx, cy = (width - 1 - fx * float(left + right)) / 2, (height - 1 - fy * float(top + bottom)) / 2
    new = CameraIntrinsics(fx, fy, cx, cy, own.name)
    columns, rows = cv2.initUndistortRectifyMap(
        camera.matrix, camera.coefficients, None, Camera(new, camera.size).matrix, camera.size, cv2.CV_32FC1
    )
    return new, fixed(np.clip(columns, 0, width - 1)), fixed(np.clip(rows, 0, height - 1))


def undistorted_colour(rgb: NDArray[np.uint8], camera: Camera) -> tuple[NDArray[np.uint8], CameraIntrinsics]:
    """Colour without the lens's distortion, shape (H, W, 3), and its intrinsics.

    Raises
    ------
    InputError
        If the distortion cannot be undone over the image.
    """
    if camera.coefficients is None:
        return rgb, camera.intrinsics
    intrinsics, columns, rows = undistorted_view(camera)
    return np.asarray(cv2.remap(rgb, columns, rows, cv2.INTER_LINEAR), np.uint8), intrinsics


def _rays(camera: Camera, columns: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where rays of pixels cross the plane at depth 1, (N, 2); InputError where the lens's model does not tell."""
    seen = np.stack([columns, rows], axis=1)[:, None]
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
    rays = cv2.undistortPoints(seen, camera.matrix, camera.coefficients, None, None, None, criteria)
    points = np.concatenate([rays, np.ones_like(rays[..., :1])], axis=2)
    again, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    found = rays[:, 0]
    if not (np.abs(again - seen) < _CLOSE).all() or (np.hypot(*found.T) > widest(camera.distortion)).any():
        raise _cannot_be_undone(camera)
    return np.asarray(found, np.float64)


def _cannot_be_undone(camera: Camera) -> InputError:
    numbers = ", ".join(f"{number:g}" for number in camera.distortion)
    return InputError(
        f"The colour camera's distortion ({numbers}) cannot be undone over an image of {camera.size[0]} x "
        f"{camera.size[1]}. Check that the coefficients are OpenCV's, k1 k2 p1 p2 k3 k4 k5 k6, and of this camera."
    )
