"""Edges of the colour image and of the known depth: where boundaries of surfaces are looked for (section 2)."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

_TRUSTED_DISTANCE = 3.0
"""How far [px] from known depth a jump is still one: farther inside a hole, it is only where two nearest fills meet."""

_OTSU_SHARE = 0.6
"""Otsu's threshold parts strong edges from all others; watertight boundaries need the fainter ones too."""


def colour_gradient(rgb: NDArray[np.uint8], sigma: float) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Sobel derivatives of the smoothed image, each pixel's from the Lab channel in which they are largest.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    sigma : float
        Standard deviation of the Gaussian blur [px]; 0 for none.

    Returns
    -------
    dx, dy : ndarray of int16, shape (H, W)
    """
    lab = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2Lab)
    if sigma > 0:
        lab = cv2.GaussianBlur(lab, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    dx = cv2.Sobel(lab, cv2.CV_16S, 1, 0, borderType=cv2.BORDER_REFLECT)
    dy = cv2.Sobel(lab, cv2.CV_16S, 0, 1, borderType=cv2.BORDER_REFLECT)
    strongest = np.argmax(np.abs(dx.astype(np.int32)) + np.abs(dy.astype(np.int32)), axis=2)[..., None]
    return _pick(dx, strongest), _pick(dy, strongest)


def gradient_strength(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> NDArray[np.float32]:
    """Gradient magnitude scaled to [0, 1] by its 99th percentile, float32 (H, W)."""
    magnitude, top = _magnitude(dx, dy)
    return np.clip(magnitude / top, 0.0, 1.0) if top > 0 else magnitude


def canny_edges(dx: NDArray[np.int16], dy: NDArray[np.int16], high: float, low_ratio: float) -> NDArray[np.bool_]:
    """Canny's edges of a colour gradient: thin lines by non-maximum suppression and hysteresis.

    Parameters
    ----------
    dx, dy : ndarray of int16, shape (H, W)
        From `colour_gradient`.
    high : float
        Threshold in the unit of `gradient_strength`; 0 takes 0.6 of Otsu's threshold of the strength.
    low_ratio : float
        The lower threshold as a share of `high`.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    magnitude, top = _magnitude(dx, dy)
    if top == 0:
        return np.zeros(dx.shape, bool)
    if high == 0:
        levels = (np.clip(magnitude / top, 0, 1) * 255).astype(np.uint8)
        otsu = cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255
        high = _OTSU_SHARE * otsu
    threshold = high * top
    edges = cv2.Canny(dx, dy, low_ratio * threshold, threshold, L2gradient=True)
    return edges > 0


def depth_edges(depth: NDArray[np.float32], jump: float, share: float) -> NDArray[np.bool_]:
    """Discontinuities of the known depth.

    A pixel of the filled depth (`filled_depth`) is an edge if it differs from its right or lower neighbour by more
    than max(jump, share * depth), and known depth is near.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.
    jump : float
        Smallest jump [m].
    share : float
        Smallest jump as a share of the nearer depth.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    smooth, distance = filled_depth(depth)
    edges = np.zeros(depth.shape, bool)
    for first, second in (
        (np.s_[:, :-1], np.s_[:, 1:]),
        (np.s_[:-1, :], np.s_[1:, :]),
    ):
        near = np.minimum(smooth[first], smooth[second])
        edges[first] |= np.abs(smooth[first] - smooth[second]) > np.maximum(jump, share * near)
    return edges & (distance <= _TRUSTED_DISTANCE)


def filled_depth(depth: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Depth to look for jumps in: gaps filled from the nearest known pixel, outliers taken out by a 5 x 5 median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.

    Returns
    -------
    filled : ndarray of float32, shape (H, W)
        Depth [m] everywhere.
    distance : ndarray of float64, shape (H, W)
        To the nearest known pixel [px].
    """
    distance, (rows, columns) = distance_transform_edt(np.isnan(depth), return_indices=True)
    return np.asarray(cv2.medianBlur(np.ascontiguousarray(depth[rows, columns]), 5), np.float32), distance


def _pick(values: NDArray[Any], channel: NDArray[np.intp]) -> NDArray[np.int16]:
    return np.take_along_axis(values, channel, axis=2)[..., 0]


def _magnitude(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> tuple[NDArray[np.float32], float]:
    """Length of the gradient, and its 99th percentile."""
    magnitude = np.hypot(dx.astype(np.float32), dy.astype(np.float32))
    return magnitude, float(np.percentile(magnitude, 99))
