"""Measures against numbers worked out by hand."""

import numpy as np
import pytest

from ilf.errors import InputError
from ilf.evaluation.metrics import fill_rate, measure_errors

GROUND_TRUTH = np.array([[1.0, 2.0, 4.0], [2.0, 9.0, 9.0]], np.float32)
DEPTH = np.array([[1.0, 3.0, 3.0], [4.0, np.nan, -1.0]], np.float32)
MASK = np.array([[True, True, True], [True, False, False]])


def test_measures_by_hand():
    # errors 0, 1, -1, 2; ratios 1, 1.5, 4/3, 2
    found = measure_errors(DEPTH, GROUND_TRUTH, MASK)
    assert found.pixels == 4
    assert found.rmse == pytest.approx(np.sqrt(6 / 4))
    assert found.mae == pytest.approx(1.0)
    assert found.median == pytest.approx(1.0)
    assert found.rel == pytest.approx((0 + 1 / 2 + 1 / 4 + 1) / 4)
    assert found.delta == (0.25, 0.75, 0.75)
    assert found.acc == pytest.approx(0.5)
    assert found.prs == pytest.approx(np.sqrt(6 / 4 - 0.5**2))


def test_fill_rate_counts_depth_only():
    assert fill_rate(DEPTH, ~MASK) == 0.0
    assert fill_rate(DEPTH, np.ones_like(MASK)) == pytest.approx(4 / 6)


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(InputError, match=r"depth is missing at 2 of 6"):
        measure_errors(DEPTH, GROUND_TRUTH, np.ones_like(MASK))
    with pytest.raises(InputError, match="No pixel is selected"):
        measure_errors(DEPTH, GROUND_TRUTH, np.zeros_like(MASK))
    with pytest.raises(InputError, match="same shape"):
        measure_errors(DEPTH[:1], GROUND_TRUTH, MASK)
    with pytest.raises(InputError, match="No pixel is wanted"):
        fill_rate(DEPTH, np.zeros_like(MASK))
    with pytest.raises(InputError, match="same shape"):
        fill_rate(DEPTH[:1], MASK)
