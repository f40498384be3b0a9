"""Lenses: where a camera sees a ray, which ray a pixel sees, and images without distortion."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .camera import FISHEYE, ORDERS, Camera
from .frame import RGBDFrame, read_only

_Value = TypeVar("_Value", bound=np.generic)

_MAX_RAY_TANGENT = 3.0
"""Tangent of the maximum angle of a ray to the axis: 71.6 degrees."""

_RADIAL_STEPS = 3000

_BORDER_STEPS = 400
"""Points on each side of a colour image from which the extent of the undistorted image is found."""

_MAX_INVERSION_ERROR = 0.05
"""Maximum error [px] of a border point that is undistorted and distorted again, for a valid inverse."""


def seen_at(camera: Camera, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """The pixels, (N, 2), at which a camera sees rays, given by their points on the plane at depth 1, (N, 2)."""
    if camera.model == FISHEYE:
        seen = cv2.fisheye.distortPoints(rays[:, None], camera.matrix, np.array(camera.coefficients))
        return np.asarray(seen[:, 0], np.float64)
    points = np.column_stack([rays, np.ones(len(rays))])
    seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    return np.asarray(seen[:, 0], np.float64)


def rays_of(camera: Camera, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points on the plane at depth 1, (N, 2), that pixels (N, 2) see; wrong where the model is not invertible."""
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
    invert = cv2.fisheye.undistortPoints if camera.model == FISHEYE else cv2.undistortPoints
    coefficients = np.zeros(4) if camera.coefficients is None else camera.coefficients
    rays = invert(pixels[:, None], camera.matrix, coefficients, R=None, P=None, criteria=criteria)
    return np.asarray(rays[:, 0], np.float64)


def places_in_image(
    camera: Camera, matrix: NDArray[np.float64], size: tuple[int, int]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Column and row [px] in a camera's image of each pixel of an image without distortion, of a camera matrix and a
    size (width, height)."""
    of_model = cv2.fisheye if camera.model == FISHEYE else cv2
    turn = np.eye(3)
    return of_model.initUndistortRectifyMap(camera.matrix, camera.coefficients, turn, matrix, size, cv2.CV_32FC1)


@lru_cache(maxsize=8)
def max_ray_tangent(camera: Camera) -> float:
    """Tangent of the largest angle to the axis up to which the radial distortion is monotonic.

    Beyond it the model folds back, and would show points that the camera did not see.
    """
    radius = np.linspace(0.0, _MAX_RAY_TANGENT, _RADIAL_STEPS)
    if camera.model == FISHEYE:
        angle = np.arctan(radius)
        k1, k2, k3, k4 = camera.distortion or (0.0,) * 4
        square, below = angle**2, np.ones_like(radius)
        seen = angle * (1 + square * (k1 + square * (k2 + square * (k3 + square * k4))))
    else:
        k1, k2, _, _, k3, k4, k5, k6 = (*camera.distortion[:8], *(0.0,) * (8 - len(camera.distortion)))
        square = radius**2
        below = 1 + square * (k4 + square * (k5 + square * k6))
        with np.errstate(divide="ignore", invalid="ignore"):
            seen = radius * (1 + square * (k1 + square * (k2 + square * k3))) / below
    falls = ~(np.diff(seen) > 0) | (below[1:] <= 0)
    return float(radius[np.argmax(falls)]) if falls.any() else _MAX_RAY_TANGENT


@lru_cache(maxsize=8)
def undistorted_view(camera: Camera) -> tuple[Camera, NDArray[np.float32], NDArray[np.float32]]:
    """The remapping to an undistorted image of the same size, without empty pixels.

    Returns
    -------
    Camera
        Intrinsics of the new image: the largest rectangle without gaps that has the same ratio of focal lengths. Of a
        fisheye it ends where its corners are 71.6 degrees off the axis.
    ndarray, ndarray of float32, shape (H, W)
        Source column and row [px] of each pixel in the camera's image.

    Raises
    ------
    InputError
        If the distortion cannot be inverted over the image.
    """
    height, width = camera.shape
    across, down = np.linspace(0, width - 1, _BORDER_STEPS), np.linspace(0, height - 1, _BORDER_STEPS)
    widest = _MAX_RAY_TANGENT / math.sqrt(2) if camera.model == FISHEYE else _MAX_RAY_TANGENT
    left = _border_rays(camera, np.zeros_like(down), down)[:, 0].max(initial=-widest)
    right = _border_rays(camera, np.full_like(down, width - 1), down)[:, 0].min(initial=widest)
    top = _border_rays(camera, across, np.zeros_like(across))[:, 1].max(initial=-widest)
    bottom = _border_rays(camera, across, np.full_like(across, height - 1))[:, 1].min(initial=widest)
    if not (left < right and top < bottom):
        raise _not_invertible(camera)
    scale = float(max((width - 1) / camera.fx / (right - left), (height - 1) / camera.fy / (bottom - top)))
    fx, fy = scale * camera.fx, scale * camera.fy
    cx, cy = (width - 1 - fx * float(left + right)) / 2, (height - 1 - fy * float(top + bottom)) / 2
    new = Camera(fx, fy, cx, cy, camera.name, camera.size)
    columns, rows = places_in_image(camera, new.matrix, (width, height))
    return new, read_only(np.clip(columns, 0, width - 1)), read_only(np.clip(rows, 0, height - 1))


def undistorted(values: NDArray[_Value], frame: RGBDFrame, *, of_depth: bool = False) -> NDArray[_Value]:
    """Values for the pixels of the file whose view the frame has, or of its depth file, (H, W), by the nearest pixel
    for those of the frame, which was undistorted on reading; unchanged if it was not."""
    if frame.inputs is None or frame.inputs.lenses is None or frame.intrinsics is None:
        return values
    height, width = frame.shape
    lens = frame.inputs.lenses[of_depth or frame.brought is not None]
    columns, rows = places_in_image(lens, frame.intrinsics.matrix, (width, height))
    inside = (np.clip(np.rint(at), 0, last).astype(int) for at, last in ((rows, height - 1), (columns, width - 1)))
    return values[tuple(inside)]


def _border_rays(camera: Camera, columns: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rays of pixels of the border, of a fisheye without those that are too wide for a plane; raises InputError
    where the distortion model is not invertible."""
    seen, reach = np.stack([columns, rows], axis=1), max_ray_tangent(camera)
    found = rays_of(camera, seen)
    is_valid = (np.abs(seen_at(camera, found) - seen) < _MAX_INVERSION_ERROR).all(axis=1)
    is_valid &= np.hypot(*found.T) <= reach
    if not is_valid.all() and (camera.model != FISHEYE or reach < _MAX_RAY_TANGENT):
        raise _not_invertible(camera)
    return found[is_valid]


def _not_invertible(camera: Camera) -> InputError:
    numbers = ", ".join(f"{number:g}" for number in camera.distortion)
    return InputError(
        f"The camera's distortion ({numbers}) cannot be inverted over an image of {camera.shape[1]} x "
        f"{camera.shape[0]}. Check that the coefficients are OpenCV's, {ORDERS[camera.model]}, and of this camera."
    )
