"""Fit a model of the expected error to errors that are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar
from scipy.sparse import csr_array, hstack

from ..confidence import FEATURES, FLOOR, WITHIN, WITHIN_TWICE, Curve, ErrorModel
from ..confidence.difficulty import difficulty_of
from ..confidence.model import unusual, wideness

Values = NDArray[np.float64]

_KNOTS = 6
"""Knots of every curve, at equal shares of the pixels."""

_OUTERMOST = 0.01
"""Share of the pixels that lies beyond the first knot, and beyond the last."""

_EITHER_WAY = {"depth", "edge", "edge near", "edges around"}
"""Features with which errors may grow or fall; with the others they grow."""

_STRAIGHT, _LEVEL = 1e-3, 1e-4
"""What it costs curves to bend, and to rise or fall."""

_SMOOTHINGS = (0.5, 0.1)
"""Widths over which the kink of the pinball loss is rounded, one after the other."""

_PROMISES = (1.0, WITHIN, 1.0), (2.0, WITHIN_TWICE, 0.3)
"""How many times the expected error, the share of errors that is to lie within that, and how much that matters."""

_DECIMALS = 3


@dataclass(frozen=True, eq=False)
class Sample:
    """Hidden pixels of one frame under one pattern, as a method has filled them.

    Attributes
    ----------
    sensor, pattern : str
        What measured the frame (`BenchFrame.sensor`), and how depth was hidden.
    features : ndarray of float, shape (N, 13)
        See `ilf.confidence.error_features`.
    depths : ndarray of float64, shape (N,)
        Completed depth [m].
    shares : ndarray of float64, shape (N,)
        |error| / completed depth.
    distances : ndarray of float32, shape (N,)
        To the nearest known depth [px].
    own_test : (ndarray, ndarray) or None
        See `ilf.confidence.difficulty.own_test`.
    weight : float
        How much it counts when a model is fitted.
    """

    sensor: str
    pattern: str
    features: NDArray[np.floating]
    depths: Values
    shares: Values
    distances: NDArray[np.float32]
    own_test: tuple[NDArray[np.floating], NDArray[np.floating]] | None = None
    weight: float = 1.0

    def expected(self, model: ErrorModel) -> Values:
        """The expected errors, as shares of depth."""
        difficulty = None if self.own_test is None else difficulty_of(*self.own_test, model)
        return model.shares(self.features, difficulty)


def fit(samples: Sequence[Sample]) -> ErrorModel:
    """The model of least loss.

    It is the pinball loss of the logarithm's 68 % quantile and, of the same number's double, of its 95 % quantile: one
    number for both of what one and two standard deviations promise, the first of which matters more. The curves come
    first, then what frames have of their own.
    """
    features = np.concatenate([sample.features for sample in samples]).astype(np.float64)
    logarithms = np.log(np.maximum(np.concatenate([sample.shares for sample in samples]), FLOOR))
    weights = np.concatenate([np.full(len(sample.shares), sample.weight / len(sample.shares)) for sample in samples])
    weights /= weights.sum()
    model = _fit_curves(features, logarithms, weights)
    above = [np.nan if sample.own_test is None else difficulty_of(*sample.own_test, model) for sample in samples]
    if not np.isfinite(above).any():
        return model
    usual = float(np.nanmedian(above))
    own = np.concatenate(
        [
            wideness(sample.features) * unusual(np.nan_to_num(value, nan=usual), usual)
            for sample, value in zip(samples, above, strict=True)
        ]
    )
    left = logarithms - model.logarithms(features)
    found = minimize_scalar(
        lambda factor: _loss(left - factor * own, weights, _SMOOTHINGS[-1])[0], bounds=(0.0, 1.5), method="bounded"
    )
    return replace(model, usual=round(usual, _DECIMALS), own=round(float(found.x), _DECIMALS))


def _loss(left: Values, weights: Values, width: float) -> tuple[float, Values]:
    """Loss of what the logarithms have above the expected ones, and how it changes with each of the latter."""
    value, slopes = 0.0, np.zeros_like(left)
    for times, share, matters in _PROMISES:
        miss = left - np.log(times)
        rounded = np.hypot(miss, width)
        value += matters * float(weights @ ((share - 0.5) * miss + rounded / 2))
        slopes -= matters * weights * (share - 0.5 + miss / rounded / 2)
    return value, slopes


def _fit_curves(features: Values, logarithms: Values, weights: Values) -> ErrorModel:
    """A curve is the running sum of its steps from knot to knot, the first value being 0."""
    columns = features.T
    knots = [np.unique(np.quantile(column, np.linspace(_OUTERMOST, 1 - _OUTERMOST, _KNOTS))) for column in columns]
    design = hstack([_hats(column, of_it) for column, of_it in zip(columns, knots, strict=True)]).tocsr()
    transposed = design.T.tocsr()
    parts = [slice(*ends) for ends in pairwise(np.cumsum([0, *map(len, knots)]).tolist())]

    def loss(constants: Values, width: float) -> tuple[float, Values]:
        steps = constants[1:]
        values = np.concatenate([np.cumsum(steps[part]) for part in parts])
        value, slopes = _loss(logarithms - constants[0] - design @ values, weights, width)
        of_values = transposed @ slopes
        gradient = np.concatenate([[slopes.sum()], *(np.cumsum(of_values[part][::-1])[::-1] for part in parts)])
        for part in parts:
            inner, of_steps = steps[part][1:], gradient[1:][part][1:]
            bends = np.diff(inner)
            value += _STRAIGHT * float(bends @ bends) + _LEVEL * float(inner @ inner)
            of_steps += 2 * _LEVEL * inner
            of_steps[:-1] -= 2 * _STRAIGHT * bends
            of_steps[1:] += 2 * _STRAIGHT * bends
        return value, gradient

    constants = np.zeros(1 + design.shape[1])
    constants[0] = np.quantile(logarithms, WITHIN)
    bounds: list[tuple[float | None, float | None]] = [(None, None)]
    for name, of_it in zip(FEATURES, knots, strict=True):
        bounds += [(0.0, 0.0), *[(None if name in _EITHER_WAY else 0.0, None)] * (len(of_it) - 1)]
    for width in _SMOOTHINGS:
        constants = minimize(
            loss, constants, (width,), "L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": 300, "maxfun": 600}
        ).x
    curves = tuple(
        Curve(_rounded(of_it), _rounded(np.cumsum(constants[1:][part])))
        for of_it, part in zip(knots, parts, strict=True)
    )
    return ErrorModel(round(float(constants[0]), _DECIMALS), curves)


def _hats(column: Values, knots: Values) -> csr_array:
    """How much every knot's value counts at every pixel, (N, knots)."""
    if len(knots) == 1:
        return csr_array(np.ones((len(column), 1)))
    place = np.clip(np.searchsorted(knots, column, side="right") - 1, 0, len(knots) - 2)
    beyond = np.clip((column - knots[place]) / np.diff(knots)[place], 0, 1)
    rows = np.arange(len(column))
    entries = np.concatenate([1 - beyond, beyond])
    return csr_array((entries, (np.tile(rows, 2), np.concatenate([place, place + 1]))), (len(column), len(knots)))


def _rounded(values: Values) -> tuple[float, ...]:
    return tuple(round(float(value), _DECIMALS) for value in values)
