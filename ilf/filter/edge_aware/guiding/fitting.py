"""A guide fitted to known depth: a monotone curve for the frame, and a factor that varies slowly over it."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from ..smoothness import SmoothnessEnergy, make_weights
from .curve import fit_curve

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

_SAMPLES = 20_000
"""The curve is fitted to about so many pixels."""

_CELLS = 1000
"""The slow factor is sought on a grid of about so many cells."""

_ROUNDS = 2
"""Curve and slow factor are fitted by turns, so many times; and so many times, outliers lose their pull on the
factor."""

_NEAR = 0.03
"""A sample whose logarithm of depth is off by so much has half of its pull."""

_HELD = 1e-6
"""Weight of 0 in every cell, so that a surface is certain without any sample, too."""

_SLOPE, _BENDING = 0.05, 2.0
"""Weights of the slow factor's smoothness, a cell full of known depth having weight 1."""


def fitted(values: Array, depth: Array, confidence: Array) -> Array:
    """Depth by a guide.

    Parameters
    ----------
    values : ndarray of float32, shape (H, W)
        What the guide says, NaN = nothing.
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing.
    confidence : ndarray of float32, shape (H, W)
        How far to believe the guide, in [0, 1].

    Returns
    -------
    ndarray of float32, shape (H, W)
        [m], NaN where the guide says nothing, or everywhere if it says nothing where depth is known.
    """
    said = np.isfinite(values)
    weights = np.where(said & np.isfinite(depth), confidence, np.float32(0))
    stride = max(1, round(math.sqrt(depth.size / _SAMPLES)))
    sparse = np.s_[stride // 2 :: stride, stride // 2 :: stride]
    at = weights[sparse] > 0
    if not at.any():
        return np.full(depth.shape, np.nan, np.float32)
    logarithms = np.log(np.where(weights > 0, depth, np.float32(1)))
    factor = by_curve = np.zeros_like(logarithms)
    samples = values[sparse][at].astype(np.float64), weights[sparse][at].astype(np.float64)
    for _ in range(_ROUNDS):
        curve = fit_curve(samples[0], (logarithms - factor)[sparse][at].astype(np.float64), samples[1])
        by_curve = curve(np.where(said, values, np.float32(0))).astype(np.float32)
        factor = slow(logarithms - by_curve, weights)
    return np.where(said, np.exp(by_curve + factor), np.float32(np.nan))


def slow(values: Array, weights: Array) -> Array:
    """The slowly varying field, float32 (H, W), that most of what has weight lies on."""
    cell = max(1, math.ceil(math.sqrt(values.size / _CELLS)))
    trust = weights
    field = np.zeros_like(values)
    for _ in range(_ROUNDS):
        counts, totals = (sums_of_cells(given, cell) / np.float32(cell**2) for given in (trust, trust * values))
        coarse = smoothest(counts, totals, _SLOPE, _BENDING)
        size = coarse.shape[1] * cell, coarse.shape[0] * cell
        whole = np.asarray(cv2.resize(coarse, size, interpolation=cv2.INTER_LINEAR), np.float32)
        field = whole[: values.shape[0], : values.shape[1]]
        trust = weights / (1 + ((values - field) / np.float32(_NEAR)) ** 2)
    return field


def smoothest(counts: Array, totals: Array, slope: float, bending: float) -> Array:
    """The surface of least energy where nothing parts neighbours, see `SmoothnessEnergy`."""
    height, width = counts.shape
    smooth = np.ones((height, width - 1), np.float32), np.ones((height - 1, width), np.float32)
    energy = SmoothnessEnergy(counts + np.float32(_HELD), totals, make_weights(*smooth, slope, bending))
    return energy.minimum()


def sums_of_cells(values: Array, cell: int) -> Array:
    """Sums over cells of cell x cell pixels."""
    padded = np.pad(values, [(0, -size % cell) for size in values.shape])
    shaped = padded.reshape(padded.shape[0] // cell, cell, padded.shape[1] // cell, cell)
    return shaped.sum(axis=(1, 3), dtype=np.float32)
