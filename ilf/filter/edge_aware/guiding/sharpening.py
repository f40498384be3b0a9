"""A guide's own noise and blur, taken off before it is fitted."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..trend import noise_of

Array = NDArray[np.float32]

_REACH = 10
"""A blurred step is wider to neither side [px]."""

_STEP = 0.04
"""Height, as a share of the guide's range, from which a step is one; twice that much is one for certain."""

_SIDE = 0.5
"""On a scale from -1, the nearest around, to 1, the farthest: what lies beyond is of one side of the step."""

_SURE = 0.98
"""The same scale: what lies beyond is on its side, and stays as it is."""

_BETWEEN, _CERTAIN = 0.35, 0.25
"""Where so large a share of what is around lies between the sides, it is a slope; where no more than that, a step."""

_QUIET = 1e-4
"""Noise, as a share of the guide's range, below which there is none to take off."""

_WINDOW, _WIDTH, _STEPS = 9, 3.0, 4
"""Noise is taken off by a bilateral filter of such a window and deviation [px], and so many deviations of noise."""

_TINY = np.float32(1e-6)

_FARTHEST = np.float32(1e6)
"""Values that are so many times the range off it are taken to be no farther."""


def sharpened(values: Array) -> Array:
    """A guide's values without noise from pixel to pixel, and with steps where steps were blurred.

    Parameters
    ----------
    values : ndarray of float32, shape (H, W)
        Finite everywhere.
    """
    low, high = np.percentile(values[::4, ::4], (2, 98))
    scale = np.float32(max(float(high - low), 1e-12))
    with np.errstate(over="ignore"):
        unit = np.clip((values - np.float32(low)) / scale, -_FARTHEST, _FARTHEST)
    noise = noise_of(unit, np.ones(unit.shape, bool))
    if noise > _QUIET:
        unit = np.asarray(cv2.bilateralFilter(unit, _WINDOW, _STEPS * noise, _WIDTH), np.float32)
    return _stepped(unit) * scale + np.float32(low)


def _stepped(unit: Array) -> Array:
    """Pixels inside a blurred step take the mean of the side of it that they are nearer to."""
    window = (2 * _REACH + 1, 2 * _REACH + 1)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, window)
    far, near = cv2.dilate(unit, disk), cv2.erode(unit, disk)
    lean = (2 * unit - far - near) / (far - near + _TINY)
    means = []
    for side in (lean > _SIDE, lean < -_SIDE):
        share = cv2.blur(side.astype(np.float32), window) + _TINY
        means.append(cv2.blur(np.where(side, unit, np.float32(0)), window) / share)
    between = cv2.blur((np.abs(lean) < _SIDE / 2).astype(np.float32), window)
    change = np.clip((means[0] - means[1] - _STEP) / _STEP, 0, 1)
    change *= np.clip((_BETWEEN - between) / (_BETWEEN - _CERTAIN), 0, 1) * (np.abs(lean) < _SURE)
    stepped = unit + change * (np.where(lean > 0, means[0], means[1]) - unit)
    return stepped.astype(np.float32)
