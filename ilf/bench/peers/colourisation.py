"""Colourisation: pixels of like colour have like depth."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from ...frame import RGBDFrame
from .sparse import solve

_NEIGHBOURS = tuple((row, column) for row in (0, 1, 2) for column in (0, 1, 2) if (row, column) != (1, 1))
_VARIANCE_SHARE = 0.6
_LEAST_WEIGHT = 0.01
_LEAST_VARIANCE = 2e-6


def colourisation(frame: RGBDFrame) -> NDArray[np.float64]:
    """Levin, Lischinski and Weiss, "Colorization using optimization", 2004, as the NYU Depth toolbox uses it on depth.

    Each pixel is the mean of its 3x3 neighbours, weighted by likeness of grey level relative to the window's
    variance; known depth is a soft constraint of weight 1 (alpha).
    """
    weights = _affinities(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float64) / 255.0)
    known = frame.known.ravel()
    pixel = np.arange(known.size).reshape(frame.shape)
    around = _shifted(np.pad(pixel, 1, mode="edge"), frame.shape)
    present = weights > 0
    entries = np.concatenate([-weights[present], 1.0 + known])
    rows = np.concatenate([np.broadcast_to(pixel, weights.shape)[present], pixel.ravel()])
    columns = np.concatenate([around[present], pixel.ravel()])
    matrix = csc_array((entries, (rows, columns)), shape=(known.size, known.size))
    return solve(matrix, np.nan_to_num(frame.depth.ravel().astype(np.float64))).reshape(frame.shape)


def _affinities(grey: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the eight neighbours, (8, H, W), of sum 1 per pixel; 0 beyond the image."""
    inside = _shifted(np.pad(np.ones(grey.shape, bool), 1), grey.shape)
    around = _shifted(np.pad(grey, 1), grey.shape)
    count = inside.sum(axis=0) + 1
    mean = (around.sum(axis=0) + grey) / count
    deviation = np.where(inside, around - mean, 0.0)
    variance = ((deviation**2).sum(axis=0) + (grey - mean) ** 2) / count
    difference = (around - grey) ** 2
    # the neighbour that is most alike keeps some weight whatever the variance
    nearest = np.where(inside, difference, np.inf).min(axis=0)
    spread = np.maximum.reduce(
        [_VARIANCE_SHARE * variance, nearest / -math.log(_LEAST_WEIGHT), np.full(grey.shape, _LEAST_VARIANCE)]
    )
    weights = np.where(inside, np.exp(-difference / spread), 0.0)
    return weights / weights.sum(axis=0)


def _shifted(padded: NDArray, shape: tuple[int, int]) -> NDArray:
    return np.stack([padded[row : row + shape[0], column : column + shape[1]] for row, column in _NEIGHBOURS])
