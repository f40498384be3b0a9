"""What the correction network is told of a frame: the same numbers in training and in use."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..edges.depth_features import CHANNELS as KNOWN_CHANNELS
from ..edges.depth_features import features_of, filled_log_depth

Array = NDArray[np.float32]

CHANNELS = (*KNOWN_CHANNELS, "completed", "departure", "completed relief", "contours")
"""What `correction_features` gives, in this order."""

_DEPARTURE_GAIN, _RELIEF_GAIN = 4, 20
_FINE = 5
_LIMIT = 4


def correction_features(depth: Array, completed: Array, contours: Array) -> tuple[Array, Array]:
    """Known and completed depth and contours as pictures for the network, independent of scale.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing; at least one known pixel.
    completed : ndarray of float32, shape (H, W)
        Completed depth [m]; NaN where it has not been completed.
    contours : ndarray of float32, shape (H, W)
        Strength of the edges that the filter saw, in [0, 1].

    Returns
    -------
    features : ndarray of float32, shape (10, H, W)
        In the order of `CHANNELS`: those of `depth_features`; the completed log depth; what it departs from the one
        whose gaps are filled from around; what it rises above its mean in 5 x 5 pixels; the contours.
    log_depth : ndarray of float32, shape (H, W)
        The completed log depth less the median of the known one, filled from around where it has not been completed.
    """
    filled, median = filled_log_depth(depth)
    filled -= np.float32(median)
    with np.errstate(invalid="ignore"):
        log_depth = np.where(np.isfinite(completed), np.log(completed) - np.float32(median), filled).astype(np.float32)
    more = np.stack(
        [
            log_depth,
            _DEPARTURE_GAIN * (log_depth - filled),
            _RELIEF_GAIN * (log_depth - cv2.blur(log_depth, (_FINE, _FINE))),
            contours,
        ]
    )
    features = np.concatenate([features_of(filled, np.isfinite(depth)), np.clip(more, -_LIMIT, _LIMIT, out=more)])
    return features.astype(np.float32, copy=False), log_depth
