"""The monotone curve from what a guide says to depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

_BINS = 32
"""Known depth is told apart by so many ranges of the guide, with as many samples in each."""

_LEAST_SAMPLES = 20
"""A range has at least so many, if there are as many."""

_PRIOR = 0.2
"""A range's own median weighs against the simple curve as its samples to this share of a mean range's."""

_ROUNDS = 8
"""Rounds of reweighting of a simple curve, in which outliers lose their pull."""

_BEYOND = 2.0
"""Depth is at most so many times farther, or nearer, than any known depth on the curve."""

_LEAST_OFF = 1e-3
"""Deviations below this share of the range of depth count alike."""

_SMALL = 1e-9


@dataclass(frozen=True, eq=False)
class Curve:
    """Logarithm of depth by a guide's value: through nodes, and beyond them on along a simple curve.

    Parameters
    ----------
    nodes, logarithms : ndarray
        Values of the guide, rising, and the logarithm of depth there.
    simple : SimpleCurve
    """

    nodes: Values
    logarithms: Values
    simple: SimpleCurve

    def __call__(self, values: NDArray[np.floating]) -> Values:
        """Logarithm of depth."""
        inside = np.interp(values, self.nodes, self.logarithms)
        first, last = self.nodes[0], self.nodes[-1]
        clipped = np.clip(values, first, last)
        low, high = self.logarithms.min() - np.log(_BEYOND), self.logarithms.max() + np.log(_BEYOND)
        return np.clip(inside + self.simple(values) - self.simple(clipped), low, high)


@dataclass(frozen=True)
class SimpleCurve:
    """Depth, its logarithm or its inverse as a straight line over the guide's values."""

    power: int
    offset: float
    slope: float

    def __call__(self, values: NDArray[np.floating]) -> Values:
        """Logarithm of depth."""
        line = self.offset + self.slope * np.asarray(values, np.float64)
        return line if self.power == 0 else np.log(np.maximum(line, _SMALL)) / self.power


def fit_curve(values: Values, logarithms: Values, weights: Values) -> Curve:
    """The monotone curve, rising or falling, that most samples lie on.

    Parameters
    ----------
    values : ndarray, shape (N,)
        What the guide says.
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
        # off the simple curve, so that its slope inside a range does not count
        off = logarithms[part] - simple(values[part])
        medians[number] = expected + weighted_median(off, weights[part]) * own / weight[number]
    nodes, places = np.unique(nodes, return_index=True)
    rising = simple.slope * (simple.power or 1) >= 0
    fitted = _isotonic(medians[places] if rising else -medians[places], weight[places])
    return Curve(nodes, fitted if rising else -fitted, simple)


def weighted_median(values: Values, weights: Values) -> float:
    """The value that half of the weight lies below."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, below[-1] / 2)])


def _simple_curve(power: int, values: Values, logarithms: Values, weights: Values) -> tuple[float, SimpleCurve]:
    """A simple curve, by least absolute deviations, and the mean absolute deviation of the samples from it."""
    target = logarithms if power == 0 else np.exp(power * logarithms)
    # a deviation of the target is one of the logarithm times this
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
    """The rising sequence nearest to values, by pooling neighbours that fall."""
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
