"""Known depth that is hidden in training: holes in which a network has to find the depth and the edges."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scenes.view import smooth_noise

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]
Pattern = Callable[[Array, NDArray[np.int32], np.random.Generator], Mask]

UNCHANGED_SHARE = 0.12
"""Share of the pictures whose depth is not hidden."""

PATTERN_COUNTS = (0.55, 0.35, 0.1)
"""Probabilities of one, two or three combined patterns."""

MIN_KNOWN = 0.02
"""Minimum share of the picture with known depth; patterns that would leave less are skipped."""

AREA_SEMI_AXES = (0.03, 0.12)
"""Shortest and longest semi-axis of the ellipses, in widths of the picture, as in `ilf.evaluation.hold_out`."""

_SHARE = (0.05, 0.5)
"""Range of the share of the known depth that ellipses, blobs and distance hide."""


def hide(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """Select pixels whose depth is hidden in a training sample.

    Parameters
    ----------
    measured : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    part : ndarray of int32, shape (H, W)
        Number of the visible smooth surface; some are hidden as a whole.
    rng : numpy.random.Generator
        Random generator for patterns, their combination and their extent.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Known pixels only.
    """
    known = np.isfinite(measured)
    hidden = np.zeros(known.shape, bool)
    if rng.random() < UNCHANGED_SHARE or not known.any():
        return hidden
    patterns, weights = list(PATTERNS), np.array(list(PATTERNS.values()))
    count = 1 + int(rng.choice(len(PATTERN_COUNTS), p=PATTERN_COUNTS))
    for k in rng.choice(len(patterns), count, replace=False, p=weights / weights.sum()):
        more = hidden | (known & patterns[k](measured, part, rng))
        if (known & ~more).mean() >= MIN_KNOWN:
            hidden = more
    return hidden


def ellipses(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """Ellipses around known pixels, as large as in the hold-outs or twice that, as in a detail of a larger frame."""
    known = np.isfinite(measured)
    covered = np.zeros(known.shape, np.uint8)
    places, width = np.argwhere(known), known.shape[1]
    shortest, longest = rng.choice([1, 2]) * np.array(AREA_SEMI_AXES)
    enough = rng.uniform(*_SHARE) * len(places)
    while np.count_nonzero(known & (covered > 0)) < enough:
        row, column = (int(value) for value in rng.choice(places))
        axes = tuple(int(max(value * width, 1)) for value in rng.uniform(shortest, longest, 2))
        cv2.ellipse(covered, (column, row), axes, rng.uniform(0, 180), 0, 360, 1, -1)
    return covered > 0


def blobs(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """Large patches with irregular outlines."""
    grain = math.exp(rng.uniform(math.log(12), math.log(130)))
    return _lowest(smooth_noise(measured.shape, grain, rng) + 0.15 * smooth_noise(measured.shape, 5, rng), rng)


def surfaces(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """One or several surfaces, whole or except for a remnant, with a margin around them."""
    known = np.isfinite(measured)
    ids, sizes = np.unique(part[known], return_counts=True)
    large = ids[sizes > 0.003 * known.size]
    if large.size == 0:
        return np.zeros(known.shape, bool)
    chosen = np.isin(part, rng.choice(large, min(int(rng.integers(1, 6)), large.size), replace=False))
    side = int(rng.choice([1, 3, 5, 9]))
    grown = cv2.dilate(chosen.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))) > 0
    if rng.random() < 0.5:
        return grown
    field = smooth_noise(measured.shape, rng.uniform(8, 50), rng)
    return grown & ~(chosen & (field > np.quantile(field[chosen], rng.uniform(0.7, 0.97))))


def far_or_near(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """All depth beyond a range, sometimes all nearer depth, with a smooth or ragged limit."""
    depth = np.where(np.isfinite(measured), measured, np.float32(np.nanmedian(measured)))
    ragged = rng.choice([0.0, 0.03, 0.1]) * smooth_noise(depth.shape, rng.uniform(3, 20), rng)
    return _lowest((depth if rng.random() < 0.2 else -depth) * (1 + ragged), rng)


def bands(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """A strip of any direction, mostly at a side of the picture, otherwise across it."""
    height, width = measured.shape
    angle = rng.choice([0.0, 0.5, 1.0, 1.5, rng.uniform(0, 2)]) * math.pi
    rows, columns = np.indices(measured.shape, np.float32)
    along = (columns - width / 2) * np.float32(math.cos(angle)) + (rows - height / 2) * np.float32(math.sin(angle))
    reach = float(along.max())
    start = reach * (1 - rng.uniform(0.1, 0.9) if rng.random() < 0.7 else rng.uniform(-0.7, 0.5))
    end = reach if rng.random() < 0.7 else start + reach * rng.uniform(0.05, 0.5)
    return (along >= start) & (along <= end)


def sparse(measured: Array, part: NDArray[np.int32], rng: np.random.Generator) -> Mask:
    """All but some single pixels."""
    return rng.random(measured.shape, np.float32) < rng.uniform(0.3, 0.97)


PATTERNS: dict[Pattern, float] = {
    ellipses: 0.34,
    blobs: 0.16,
    surfaces: 0.2,
    far_or_near: 0.08,
    bands: 0.06,
    sparse: 0.16,
}
"""Pattern -> relative frequency."""


def _lowest(values: Array, rng: np.random.Generator) -> Mask:
    """Select the pixels with the lowest values, a random share."""
    return values < np.quantile(values, rng.uniform(*_SHARE))
