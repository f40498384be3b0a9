"""The smoothness energy against dense matrices built from its formula, and its link to the iteration."""

import itertools
import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from ilf.completion.edge_aware import smoothness as kernels
from ilf.completion.edge_aware.smoothness import SmoothnessEnergy, Weights, make_weights

SHAPES = [(1, 1), (1, 2), (1, 7), (6, 1), (2, 2), (2, 3), (3, 2), (4, 5), (7, 6)]


def _weights(rng: np.random.Generator, shape: tuple[int, int], top: float = 3.0) -> Weights:
    height, width = shape

    def some(rows: int, columns: int) -> np.ndarray:
        return rng.uniform(0.01, top, (max(rows, 0), max(columns, 0))).astype(np.float32)

    weights = Weights.none(shape)
    weights.slope_x[:] = some(height, width - 1)
    weights.slope_y[:] = some(height - 1, width)
    weights.bend_x[:] = some(height, width - 2)
    weights.bend_y[:] = some(height - 2, width)
    return weights


def _samples(rng: np.random.Generator, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Counts, two thirds of them 0 but one at least not, and samples."""
    counts = np.where(rng.random(shape) < 0.35, rng.uniform(0.2, 4.0, shape), 0.0)
    counts.flat[rng.integers(counts.size)] = 1.0
    return counts.astype(np.float32), rng.uniform(0.5, 3.0, shape).astype(np.float32)


def _descent(energy: SmoothnessEnergy, start: np.ndarray, limit: int = 1000) -> Iterator[np.ndarray]:
    """The steps of a descent that is never steady."""
    return (u for u, _ in energy.descend(start, (np.ones_like(start),) * 4, 0.0, limit))


def _differences(weights: Weights, shape: tuple[int, int]) -> Iterator[tuple[float, dict[tuple[int, int], int]]]:
    """Every term of the energy's smoothness: its weight, and the pixels in it with their factors."""
    height, width = shape
    for y, x in itertools.product(range(height), range(width)):
        if x + 1 < width:
            yield float(weights.slope_x[y, x]), {(y, x): -1, (y, x + 1): 1}
        if y + 1 < height:
            yield float(weights.slope_y[y, x]), {(y, x): -1, (y + 1, x): 1}
        if x + 2 < width:
            yield float(weights.bend_x[y, x]), {(y, x): 1, (y, x + 1): -2, (y, x + 2): 1}
        if y + 2 < height:
            yield float(weights.bend_y[y, x]), {(y, x): 1, (y + 1, x): -2, (y + 2, x): 1}


def _energy(u: np.ndarray, counts: np.ndarray, samples: np.ndarray, weights: Weights) -> float:
    """E(u), term by term."""
    total = float((counts.astype(float) * (u.astype(float) - samples) ** 2).sum())
    for weight, term in _differences(weights, u.shape):
        total += weight * sum(factor * float(u[pixel]) for pixel, factor in term.items()) ** 2
    return total


def _operator(weights: Weights, shape: tuple[int, int]) -> np.ndarray:
    """L as a dense matrix."""
    size = shape[0] * shape[1]
    result = np.zeros((size, size))
    for weight, term in _differences(weights, shape):
        row = np.zeros(size)
        for pixel, factor in term.items():
            row[np.ravel_multi_index(pixel, shape)] = factor
        result += weight * np.outer(row, row)
    return result


def _dense_minimum(counts: np.ndarray, samples: np.ndarray, weights: Weights) -> np.ndarray:
    matrix = _operator(weights, counts.shape) + np.diag(counts.ravel().astype(float))
    return np.linalg.solve(matrix, (counts.astype(float) * samples).ravel()).reshape(counts.shape)


@pytest.mark.parametrize("shape", SHAPES)
def test_both_ways_lead_to_the_minimum_of_the_formula(shape):
    rng = np.random.default_rng(shape)
    for _ in range(3):
        weights = _weights(rng, shape)
        counts, samples = _samples(rng, shape)
        energy = SmoothnessEnergy(counts, counts * samples, weights)
        expected = _dense_minimum(counts, samples, weights)
        found = energy.minimum()
        assert found.dtype == np.float32
        assert_allclose(found, expected, atol=1e-5)
        *_, last = _descent(energy, np.zeros(shape, np.float32), found.size + 2)
        assert_allclose(last, expected, atol=2e-5)


@given(st.integers(0, 2**32 - 1), st.sampled_from(SHAPES))
def test_the_operator_is_symmetric_and_gives_the_gradient(seed, shape):
    """Of a quadratic energy, central differences of any width are exact."""
    rng = np.random.default_rng(seed)
    weights, (counts, samples) = _weights(rng, shape), _samples(rng, shape)
    u, v = rng.normal(size=(2, *shape)).astype(np.float32)
    images = np.empty((2, *shape), np.float32)
    products = [
        kernels.pull(counts, weights.framed, kernels.framed(one), image)
        for one, image in zip((u, v), images, strict=True)
    ]
    close = {"rel": 1e-4, "abs": 1e-3}
    assert products == pytest.approx([np.vdot(u, images[0]), np.vdot(v, images[1])], **close)
    assert np.vdot(v, images[0]) == pytest.approx(np.vdot(u, images[1]), **close)
    slope = (_energy(u + v, counts, samples, weights) - _energy(u - v, counts, samples, weights)) / 2
    assert slope == pytest.approx(2 * np.vdot(v, images[0] - counts * samples), **close)


@given(st.integers(0, 2**32 - 1), st.sampled_from(SHAPES))
def test_no_step_of_the_descent_climbs(seed, shape):
    rng = np.random.default_rng(seed)
    weights = _weights(rng, shape)
    counts, samples = _samples(rng, shape)
    start = rng.uniform(0.5, 3.0, shape).astype(np.float32)
    before = first = _energy(start, counts, samples, weights)
    for u in _descent(SmoothnessEnergy(counts, counts * samples, weights), start, 2 * start.size):
        after = _energy(u, counts, samples, weights)
        assert after <= before + 1e-5 * first
        before = after


def test_the_start_is_left_as_it_was():
    rng = np.random.default_rng(2)
    counts, samples = _samples(rng, (4, 5))
    start = np.ones((4, 5), np.float32)
    steps = list(_descent(SmoothnessEnergy(counts, counts * samples, _weights(rng, (4, 5))), start, 4))
    assert (start == 1).all()
    assert len(steps) == 4
    assert not any(np.shares_memory(*pair) for pair in itertools.combinations([start, *steps], 2))
    assert not np.array_equal(steps[0], steps[-1])


def test_the_least_smooth_pixel_of_a_difference_makes_its_weight():
    smooth = np.array([[1.0, 1.0, 0.5, 0.25, 1.0, 1.0]], np.float32)
    weights = make_weights(smooth, 3.0, 10.0)
    assert_allclose(weights.slope_x, [[3.0, 1.5, 0.75, 0.75, 3.0]])
    assert_allclose(weights.bend_x, [[5.0, 2.5, 2.5, 2.5]])
    assert weights.slope_y.size == weights.bend_y.size == 0
    turned = make_weights(np.ascontiguousarray(smooth.T), 3.0, 10.0)
    assert_allclose(turned.slope_y, weights.slope_x.T)
    assert_allclose(turned.bend_y, weights.bend_x.T)
    creases = np.array([[0.9, 0.0, 0.8, 1.0, 0.7, 0.5]], np.float32)
    creased = make_weights(smooth, 3.0, 10.0, creases)
    assert_allclose(creased.slope_x, weights.slope_x)
    assert_allclose(creased.bend_x, [[5.0, 0.5, 0.0, 0.75]], rtol=1e-6)
    creased = make_weights(np.ascontiguousarray(smooth.T), 3.0, 10.0, np.ascontiguousarray(creases.T))
    assert_allclose(creased.bend_y, [[5.0], [0.5], [0.0], [0.75]], rtol=1e-6)


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (1, 6), (4, 5)])
def test_loosened_weights_are_cauchys(shape):
    rng = np.random.default_rng(shape)
    weights = _weights(rng, shape)
    u = rng.uniform(0, 2, shape).astype(np.float32)
    loose = weights.bent(np.float32(1))
    loose.weaken(u, np.full(shape, 0.3, np.float32), 4.0)
    for (before, term), (after, _) in zip(_differences(weights, shape), _differences(loose, shape), strict=True):
        halving = 0.3 if len(term) == 3 else 4.0 * 0.3
        difference = sum(factor * float(u[pixel]) for pixel, factor in term.items())
        assert after == pytest.approx(before / (1 + (difference / halving) ** 2), rel=1e-4)


def test_the_descent_ends_or_goes_on_but_never_breaks():
    """Past what float32 can tell apart, a step is of no length, and no reason to divide by it."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        counts, samples = _samples(rng, (4, 5))
        energy = SmoothnessEnergy(counts, counts * samples, _weights(rng, (4, 5), 100.0))
        expected = energy.minimum()
        *_, last = _descent(energy, np.zeros((4, 5), np.float32), 300)
        assert_allclose(last, expected, atol=1e-3)


def test_a_descent_tells_of_its_steps_and_ends_when_they_are_steady():
    rng = np.random.default_rng(4)
    shape = 6, 7
    counts, samples = _samples(rng, shape)
    energy = SmoothnessEnergy(counts, counts * samples, _weights(rng, shape))
    told = tuple(rng.random(shape, np.float32) for _ in range(4))
    inside, trend, weights, totals = told
    previous, changes = np.zeros(shape, np.float32), math.inf
    for u, sums in energy.descend(previous, told, 1e-3, 100):
        assert changes >= 1e-3
        changes = float((inside * (u - previous) ** 2).sum())
        assert sums.changes == pytest.approx(changes, rel=1e-4)
        assert sums.sizes == pytest.approx(float((inside * abs(u + trend)).sum()), rel=1e-5)
        misfits = (weights * (u - totals / weights) ** 2 - totals**2 / weights).sum()
        assert sums.misfits == pytest.approx(float(misfits), rel=1e-4)
        previous = u
    assert changes < 1e-3


@pytest.mark.parametrize("top", [1.0, 100.0, 1e5])
def test_the_minimum_is_as_exact_for_stiff_surfaces(top):
    """Of large weights in float32, what is left of a row's sum must still be the weight of its samples."""
    rng = np.random.default_rng(3)
    shape = 20, 15
    weights = _weights(rng, shape, top)
    counts, samples = _samples(rng, shape)
    totals = counts * samples
    assert_allclose(
        SmoothnessEnergy(counts, totals, weights).minimum(), _dense_minimum(counts, samples, weights), atol=1e-4
    )
