"""Edges of the colour image: where boundaries of surfaces are looked for (section 2)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_GRADIENT_SHARE, _NETWORK_SHARE = 0.6, 0.5
"""Otsu's threshold parts strong edges from all others; watertight boundaries need the fainter ones too."""


_FAINTEST = 0.1
"""Least threshold that Otsu's rule may give for the network's strength: an image of one colour has no edges."""


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
    sizes = np.abs(dx) + np.abs(dy)
    size, strongest_x, strongest_y = sizes[..., 0], dx[..., 0], dy[..., 0]
    for channel in (
        1,
        2,
    ):  # arrays of one channel each: reducing along the last, short axis takes several times as long
        larger = sizes[..., channel] > size
        size = np.maximum(size, sizes[..., channel])
        strongest_x = np.where(larger, dx[..., channel], strongest_x)
        strongest_y = np.where(larger, dy[..., channel], strongest_y)
    return np.ascontiguousarray(strongest_x), np.ascontiguousarray(strongest_y)


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
        high = _GRADIENT_SHARE * _otsu(magnitude / top)
    threshold = high * top
    edges = cv2.Canny(dx, dy, low_ratio * threshold, threshold, L2gradient=True)
    return edges > 0


def otsu_edges(strength: NDArray[np.float32], threshold: float) -> NDArray[np.bool_]:
    """Binarised edge strength.

    Parameters
    ----------
    strength : ndarray of float32, shape (H, W)
        In [0, 1].
    threshold : float
        Strength from which on there is an edge; 0 takes half of Otsu's threshold, 0.1 at least.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    return strength >= (threshold or max(_NETWORK_SHARE * _otsu(strength), _FAINTEST))


def _magnitude(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> tuple[NDArray[np.float32], float]:
    """Length of the gradient, and its 99th percentile."""
    magnitude = np.hypot(dx.astype(np.float32), dy.astype(np.float32))
    return magnitude, float(np.percentile(magnitude, 99))


def _otsu(strength: NDArray[np.float32]) -> float:
    levels = (np.clip(strength, 0, 1) * 255).astype(np.uint8)
    return cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255
