"""A guide fitted to known depth: a curve for the frame, by what its values are, and a slowly varying factor."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.guide import Gives
from ...data.pixel_grids import cells_of
from .shape import noise_of
from .smoothness import SmoothnessEnergy, make_weights

Values = NDArray[np.float64]
Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

# The monotone curve from guide values to depth.

_BINS = 32
"""Number of ranges of guide values, with equally many samples in each."""

_LEAST_SAMPLES = 20
"""Minimum number of samples of a range, if there are as many."""

_PRIOR = 0.2
"""Weight of the simple curve against a range's own median, as a share of the mean weight of a range's samples."""

_ROUNDS = 8
"""Rounds of reweighting of a simple curve, which reduce the weight of outliers."""

_BEYOND = 2.0
"""Maximum ratio of depth to the farthest, or of the nearest to it, among the known depth on the curve."""

_LEAST_OFF = 1e-3
"""Deviations below this share of the range of depth have equal weight."""

_SMALL = 1e-9


@dataclass(frozen=True)
class SimpleCurve:
    """Depth, its logarithm or its inverse as a linear function of the guide's values."""

    power: int
    offset: float
    slope: float

    def __call__(self, values: NDArray[np.floating]) -> Values:
        """Logarithm of depth."""
        line = self.offset + self.slope * np.asarray(values, np.float64)
        return line if self.power == 0 else np.log(np.maximum(line, _SMALL)) / self.power


def fit_curve(values: Values, logarithms: Values, weights: Values) -> Callable[[Array], Values]:
    """Fit the monotone curve, increasing or decreasing, that most samples lie on: through nodes, and beyond them as a
    simple curve. It returns the logarithm of depth at values of the guide.

    Parameters
    ----------
    values : ndarray, shape (N,)
        Values of the guide.
    logarithms : ndarray, shape (N,)
        Logarithm of the depth.
    weights : ndarray, shape (N,)
    """
    candidates = [_simple_curve(power, values, logarithms, weights) for power in (1, 0, -1)]
    simple = min(candidates, key=lambda found: found[0])[1]
    order = np.argsort(values, kind="stable")
    parts = np.array_split(order, min(_BINS, max(values.size // _LEAST_SAMPLES, 1)))
    nodes = np.array([np.median(values[part]) for part in parts])
    mean = weights.sum() / len(parts)
    medians, weight = np.empty(len(parts)), np.empty(len(parts))
    for number, part in enumerate(parts):
        own = weights[part].sum()
        weight[number] = own + _PRIOR * mean
        expected = simple(nodes[number])
        # relative to the simple curve, so that its slope inside a range has no effect
        off = logarithms[part] - simple(values[part])
        medians[number] = expected + weighted_median(off, weights[part]) * own / weight[number]
    nodes, places = np.unique(nodes, return_index=True)
    rising = simple.slope * (simple.power or 1) >= 0
    fitted = _isotonic(medians[places] if rising else -medians[places], weight[places])
    heights = fitted if rising else -fitted
    low, high = heights.min() - np.log(_BEYOND), heights.max() + np.log(_BEYOND)

    def curve(asked: NDArray[np.floating]) -> Values:
        clipped = np.clip(asked, nodes[0], nodes[-1])
        return np.clip(np.interp(asked, nodes, heights) + simple(asked) - simple(clipped), low, high)

    return curve


_POWERS = {"affine": 1, "affine-inverse": -1}
"""What is a linear function of a guide's values: this power of depth."""


def fit_line(gives: Gives, values: Values, logarithms: Values, weights: Values) -> Callable[[Array], Values]:
    """Fit the scale of metric depth, or the two numbers of a linear function of depth or inverse depth, that most
    samples lie on.

    Parameters
    ----------
    gives : str
        What the values are: "metric", "affine" or "affine-inverse".
    values, logarithms, weights
        As for `fit_curve`.
    """
    if gives == "metric":
        scale = weighted_median(logarithms - np.log(np.maximum(values, _SMALL)), weights)
        return SimpleCurve(1, 0.0, math.exp(scale))
    line = _simple_curve(_POWERS[gives], values, logarithms, weights)[1]
    low, high = logarithms.min() - np.log(_BEYOND), logarithms.max() + np.log(_BEYOND)
    return lambda asked: np.clip(line(asked), low, high)


def weighted_median(values: Values, weights: Values) -> float:
    """The value below which half of the weight lies."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, below[-1] / 2)])


def _simple_curve(power: int, values: Values, logarithms: Values, weights: Values) -> tuple[float, SimpleCurve]:
    """The samples' mean absolute deviation from a simple curve, and this curve, fitted by least absolute deviations."""
    target = logarithms if power == 0 else np.exp(power * logarithms)
    # a deviation of the target is that of the logarithm times this
    steep = np.ones_like(target) if power == 0 else target
    least = _LEAST_OFF * (np.ptp(logarithms) + _SMALL)
    pull = weights / steep**2
    for _ in range(_ROUNDS):
        total = pull.sum()
        middle, level = (pull * values).sum() / total, (pull * target).sum() / total
        aside = values - middle
        slope = (pull * aside * (target - level)).sum() / ((pull * aside * aside).sum() + _SMALL * total)
        offset = level - slope * middle
        off = np.abs(target - offset - slope * values) / steep
        pull = weights / steep**2 / np.maximum(off, least)
    curve = SimpleCurve(power, float(offset), float(slope))
    return float(np.average(np.minimum(np.abs(curve(values) - logarithms), 1), weights=weights)), curve


def _isotonic(values: Values, weights: Values) -> Values:
    """The increasing sequence nearest to values, by pooling decreasing neighbours."""
    means: list[float] = []
    masses: list[float] = []
    sizes: list[int] = []
    for value, weight in zip(values, weights, strict=True):
        mean, mass, size = float(value), float(weight), 1
        while means and means[-1] > mean:
            other = masses.pop()
            mean = (mean * mass + means.pop() * other) / (mass + other)
            mass, size = mass + other, size + sizes.pop()
        means.append(mean)
        masses.append(mass)
        sizes.append(size)
    return np.repeat(means, sizes)


# A guide fitted to known depth: the curve, times a factor that varies slowly over the frame.

_SAMPLES = 20_000
"""Approximate number of pixels that the curve is fitted to."""

_CELLS = 1000
"""Approximate number of cells of the grid for the slow factor."""

_FITTING_ROUNDS = 2
"""Number of times that curve and slow factor are fitted alternately; also number of reweighting rounds for the
factor."""

_NEAR = 0.03
"""Deviation of the logarithm of depth at which a sample's weight is halved."""

_HELD = 1e-6
"""Weight of the value 0 in every cell, so that the surface is defined without any sample."""

_SLOPE, _BENDING = 0.05, 2.0
"""Smoothness weights of the slow factor, relative to a cell full of known depth."""


def fitted(values: Array, depth: Array, confidence: Array, gives: Gives | None = None) -> Array:
    """Fit a guide to known depth.

    Parameters
    ----------
    values : ndarray of float32, shape (H, W)
        Values of the guide, NaN = none.
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing.
    confidence : ndarray of float32, shape (H, W)
        Confidence of the guide, in [0, 1].
    gives : str, optional
        What its values are, see `Gives`; None for any monotone function of depth.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] of the guide, NaN where it has no value, or everywhere if it has none where depth is known.
    """
    has_value = np.isfinite(values)
    weights = np.where(has_value & np.isfinite(depth), confidence, np.float32(0))
    stride = max(1, round(math.sqrt(depth.size / _SAMPLES)))
    sparse = np.s_[stride // 2 :: stride, stride // 2 :: stride]
    at = weights[sparse] > 0
    if not at.any():
        return np.full(depth.shape, np.nan, np.float32)
    logarithms = np.log(np.where(weights > 0, depth, np.float32(1)))
    factor = by_curve = np.zeros_like(logarithms)
    samples = values[sparse][at].astype(np.float64), weights[sparse][at].astype(np.float64)
    for _ in range(_FITTING_ROUNDS):
        target = (logarithms - factor)[sparse][at].astype(np.float64)
        if gives is None or gives == "relative-inverse":
            curve = fit_curve(samples[0], target, samples[1])
        else:
            curve = fit_line(gives, samples[0], target, samples[1])
        by_curve = curve(np.where(has_value, values, np.float32(0))).astype(np.float32)
        factor = fit_slow_field(logarithms - by_curve, weights)
    return np.where(has_value, np.exp(by_curve + factor), np.float32(np.nan))


def fit_slow_field(values: Array, weights: Array) -> Array:
    """Fit a slowly varying field, float32 (H, W), robustly to weighted values."""
    cell = max(1, math.ceil(math.sqrt(values.size / _CELLS)))
    trust = weights
    field = np.zeros_like(values)
    for _ in range(_FITTING_ROUNDS):
        counts, totals = (sums_of_cells(given, cell) / np.float32(cell**2) for given in (trust, trust * values))
        coarse = smoothest_surface(counts, totals, _SLOPE, _BENDING)
        size = coarse.shape[1] * cell, coarse.shape[0] * cell
        whole = np.asarray(cv2.resize(coarse, size, interpolation=cv2.INTER_LINEAR), np.float32)
        field = whole[: values.shape[0], : values.shape[1]]
        trust = weights / (1 + ((values - field) / np.float32(_NEAR)) ** 2)
    return field


def smoothest_surface(counts: Array, totals: Array, slope: float, bending: float) -> Array:
    """The surface of minimum energy with all neighbours fully linked, see `SmoothnessEnergy`."""
    weights = make_weights(np.ones(counts.shape, np.float32), slope, bending)
    energy = SmoothnessEnergy(counts + np.float32(_HELD), totals, weights)
    return energy.minimum()


def sums_of_cells(values: Array, cell: int) -> Array:
    """Sums over cells of cell x cell pixels."""
    return cells_of(values, cell).sum(axis=(1, 3), dtype=np.float32)


# Removal of a guide's noise and blur before the fit.

_REACH = 10
"""Maximum half-width of a blurred step [px]."""

_STEP = 0.04
"""Height of a step, as a share of the guide's range, above which it is sharpened; in full at twice this height."""

_SIDE = 0.5
"""On a scale from -1, the nearest value around, to 1, the farthest: absolute values above this are on one side of the
step."""

_SURE = 0.98
"""On the same scale: absolute values above this stay unchanged."""

_BETWEEN, _CERTAIN = 0.35, 0.25
"""Share of the pixels around between the two sides: above the first it is a slope, below the second a step."""

_QUIET = 1e-4
"""Noise, as a share of the guide's range, below which it is not filtered."""

_WINDOW, _WIDTH, _STEPS = 9, 3.0, 4
"""Bilateral filter against noise: window and standard deviation [px], and range in deviations of noise."""

_TINY = np.float32(1e-6)

_FARTHEST = np.float32(1e6)
"""Maximum distance of values from the range, in ranges; values are clipped to it."""


def sharpen(values: Array) -> Array:
    """Remove pixel noise from a guide's values and sharpen blurred steps.

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
    """Set pixels inside a blurred step to the mean of the nearer side."""
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
