"""Ties: errors on the same pixels that cannot be told apart."""

import math

import numpy as np
import pytest

from ilf.evaluation.evaluation import Evaluated, PixelErrors, margin_of_mean
from ilf.evaluation.ties import find_ties

SHAPE = 120, 160
PLACES = np.arange(0, SHAPE[0] * SHAPE[1], 3)


def smooth_noise(seed: int) -> np.ndarray:
    """Noise that is alike in squares of 16 px, as errors are."""
    coarse = np.random.default_rng(seed).normal(size=(SHAPE[0] // 16 + 1, SHAPE[1] // 16 + 1))
    return np.kron(coarse, np.ones((16, 16)))[: SHAPE[0], : SHAPE[1]].ravel()[PLACES]


def evaluated(errors: np.ndarray, labels: np.ndarray | None = None) -> Evaluated:
    truth = np.full(PLACES.shape, 2.0, np.float32)
    part = PixelErrors(PLACES, (truth + errors).astype(np.float32), truth, np.full_like(truth, np.nan))
    return Evaluated(np.ones(SHAPE, np.int32) if labels is None else labels, (part,))


def test_the_margin_covers_the_mean_in_most_cases():
    covered = [
        abs(values.mean()) <= margin_of_mean([values], [PLACES], SHAPE[1]) for values in map(smooth_noise, range(200))
    ]
    assert 0.9 <= np.mean(covered) <= 0.99
    independent = 1.96 * smooth_noise(0).std() / math.sqrt(PLACES.size)
    assert margin_of_mean([smooth_noise(0)], [PLACES], SHAPE[1]) > 5 * independent, "neighbours are alike"
    assert margin_of_mean([np.ones(9)], [np.arange(9)], SHAPE[1]) == math.inf
    twice = margin_of_mean([smooth_noise(0), smooth_noise(1)], [PLACES, PLACES], SHAPE[1])
    assert twice < margin_of_mean([smooth_noise(0)], [PLACES], SHAPE[1])


def test_equal_results_tie_and_better_ones_do_not():
    noise = 0.02 * smooth_noise(0)
    least = evaluated(noise)
    alike = evaluated(noise + 0.003 * smooth_noise(1))
    worse = evaluated(1.3 * noise)
    ties = find_ties([worse, alike, least])
    assert (ties.best, ties.equal, bool(ties)) == (2, {1, 2}, True)
    assert ties.within == pytest.approx(alike.whole.rmse - least.whole.rmse)
    alone = find_ties([worse, least])
    assert (alone.best, alone.equal, bool(alone)) == (1, {1}, False)
    assert find_ties([worse, least], able=[0]).best == 0
    assert find_ties([worse, least], able=[]) is None


def test_what_is_shown_as_the_same_number_ties():
    noise = 0.02 * smooth_noise(0)
    assert find_ties([evaluated(noise), evaluated(1.0001 * noise)]).equal == {0, 1}
    assert find_ties([evaluated(noise), evaluated(1.1 * noise)]).equal == {0}


def test_blocks_are_compared_on_their_own_pixels():
    labels = np.ones(SHAPE, np.int32)
    labels[:, 80:] = 2
    right = labels.ravel()[PLACES] == 2
    noise = 0.02 * smooth_noise(0)
    several = [evaluated(noise, labels), evaluated(np.where(right, 2 * noise, noise), labels)]
    assert find_ties([one.of_block(1) for one in several]).equal == {0, 1}
    assert find_ties([one.of_block(2) for one in several]).equal == {0}
