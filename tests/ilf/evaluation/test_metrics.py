"""Measures against numbers worked out by hand."""

import numpy as np
import pytest

from ilf.evaluation.evaluation import evaluate

GROUND_TRUTH = np.array([[1.0, 2.0, 4.0], [2.0, 9.0, 9.0]], np.float32)
DEPTH = np.array([[1.0, 3.0, 3.0], [4.0, np.nan, -1.0]], np.float32)


def test_measures_by_hand():
    # errors 0, 1, -1, 2; ratios 1, 1.5, 4/3, 2; the last two pixels have no depth
    found = evaluate(DEPTH, GROUND_TRUTH)
    assert found.pixels == 4
    assert found.rmse == pytest.approx(np.sqrt(6 / 4))
    assert found.mae == pytest.approx(1.0)
    assert found.median == pytest.approx(1.0)
    assert found.rel == pytest.approx((0 + 1 / 2 + 1 / 4 + 1) / 4)
    assert found.delta == (0.25, 0.75, 0.75)
    assert found.bias == pytest.approx(0.5)
    assert found.deviation == pytest.approx(np.sqrt(6 / 4 - 0.5**2))
