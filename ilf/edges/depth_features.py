"""What the depth-edge network is told of the known depth: the same numbers in training and in use."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..nearest import nearest_values

Array = NDArray[np.float32]

CHANNELS = ("known", "filled", "fine relief", "wide relief", "distance", "nearest")
"""What `depth_features` gives, in this order."""

_FINE, _WIDE = 5, 33
"""Sides [px] of the squares whose mean is taken off for the relief."""

_FINE_GAIN, _WIDE_GAIN, _NEAREST_GAIN = 20, 4, 4
_LIMIT = 4
"""Weights that bring jumps of a few per cent to about 1, and the largest number that is passed on."""


def depth_features(depth: Array) -> Array:
    """The known depth as pictures for the network, independent of scale: the logarithm less its median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.

    Returns
    -------
    ndarray of float32, shape (6, H, W)
        In the order of `CHANNELS`: 1 where depth is known; the log depth, its gaps filled from around
        (`filled_log_depth`); where it is known, what it rises above its mean in 5 x 5 pixels; what the filled one
        rises above its mean in 33 x 33; log(1 + distance to known depth [px]) / 4; and the log depth of the nearest
        known pixel less the filled one.
    """
    known = np.isfinite(depth)
    if not known.any():
        features = np.zeros((len(CHANNELS), *depth.shape), np.float32)
        features[4] = np.log1p(np.float32(max(depth.shape))) / 4
        return features
    filled, median = filled_log_depth(depth)
    return features_of(filled - np.float32(median), known)


def features_of(filled: Array, known: NDArray[np.bool_]) -> Array:
    """`depth_features` from the filled log depth less the median of the known one, and where depth is known."""
    features = np.zeros((len(CHANNELS), *filled.shape), np.float32)
    distance, nearest = nearest_values(filled, known)
    features[0] = known
    features[1] = filled
    features[2] = known * _FINE_GAIN * (filled - cv2.blur(filled, (_FINE, _FINE)))
    features[3] = _WIDE_GAIN * (filled - cv2.blur(filled, (_WIDE, _WIDE)))
    features[4] = np.log1p(distance) / 4
    features[5] = _NEAREST_GAIN * (nearest - filled)
    return np.clip(features, -_LIMIT, _LIMIT, out=features)


def filled_log_depth(depth: Array) -> tuple[Array, float]:
    """Log depth whose gaps are filled from around, and the median of the known one.

    A gap gets the mean of the smallest square of 2, 4, 8 ... pixels around it that holds known depth, interpolated.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.
    """
    known = np.isfinite(depth)
    logarithm = np.log(np.where(known, depth, 1), dtype=np.float32)
    return _fill(logarithm, known.astype(np.float32)), float(np.median(logarithm[known]))


def _fill(values: Array, weights: Array) -> Array:
    """Values where they weigh 1, values of the halved picture where they weigh 0, and something between elsewhere."""
    if weights.all() or min(values.shape) == 1:
        return values if weights.all() else np.full_like(values, np.average(values, weights=weights))
    half = (-(-values.shape[1] // 2), -(-values.shape[0] // 2))
    share = cv2.resize(weights, half, interpolation=cv2.INTER_AREA)
    total = cv2.resize(values * weights, half, interpolation=cv2.INTER_AREA)
    coarse = _fill(np.divide(total, share, out=np.zeros_like(total), where=share > 0), (share > 0).astype(np.float32))
    around = cv2.resize(coarse, values.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(weights > 0, values, around)
