"""Rows of the panel Accuracy."""

from __future__ import annotations

import numpy as np

from gui.features.accuracy.rows import best_of
from ilf.evaluation.evaluation import Evaluation


def test_the_best_is_marked_among_those_evaluated_on_as_many_pixels_if_they_differ() -> None:
    worse, better, fewer = Evaluation(9, rmse=0.2), Evaluation(9, rmse=0.1), Evaluation(3, rmse=0.05)
    assert best_of([worse, better, fewer]) == {1}
    assert best_of([better, worse, better]) == {0, 2}
    assert best_of([better, better]) == set()
    assert best_of([Evaluation(0, rmse=np.nan)] * 2) == set()
    assert best_of([]) == set()
