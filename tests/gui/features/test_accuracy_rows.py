"""Rows of the panel Accuracy."""

import numpy as np
import pytest

from gui.features.accuracy.evaluation import AreaErrors, EvaluatedResult, area_errors, ground_truth_rows
from ilf.data.frame import RGBDFrame
from ilf.data.results import compose
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors
from ilf.evaluation.ties import Ties
from ilf.run.run import Run

PLACES = np.arange(64 * 64)


def evaluated(rmse: float, filled: int = PLACES.size) -> Evaluated:
    """Errors of alternating sign, in the first pixels."""
    truth = np.full(PLACES.shape, 2.0, np.float32)
    depth = np.where(filled > PLACES, truth + rmse * np.where(PLACES % 2, 1, -1), np.nan).astype(np.float32)
    return Evaluated(np.ones((64, 64), np.int32), (PixelErrors(PLACES, depth, truth, np.full_like(truth, np.nan)),))


def test_the_best_is_found_among_those_evaluated_on_as_many_pixels():
    worse, better, fewer = evaluated(0.2), evaluated(0.1), evaluated(0.05, filled=3000)
    assert area_errors([worse, better, fewer]).best.equal == {1}
    assert area_errors([better, worse, better]).best.equal == {0, 2}
    assert area_errors([evaluated(0.1, filled=0)] * 2).best is None
    assert area_errors([]).best is None


@pytest.mark.parametrize(
    ("equal", "marked", "said"),
    [
        ({1}, [False, True, False], "Smallest RMSE of all."),
        ({0, 1}, [True, True, False], "2 of them, with the smallest RMSE, are equal within 0.20 mm."),
        ({0, 1, 2}, [False] * 3, "All are equal within 0.20 mm."),
    ],
)
def test_ties_are_called_ties(equal, marked, said):
    frame = RGBDFrame(np.zeros((4, 4, 3), np.uint8), np.ones((4, 4)))
    entries = [
        EvaluatedResult(name, compose(Run(frame, np.zeros((4, 4), int)), {})) for name in ("Run 1", "Run 2", "Run 3")
    ]
    evaluations = tuple(Evaluation(9, rmse, rmse, rmse, 0.0) for rmse in (0.0122, 0.012, 0.02))
    rows = ground_truth_rows({"All": AreaErrors(evaluations, Ties(1, frozenset(equal), 0.0002))}, entries)
    assert [row.is_best for row in rows[1:]] == marked
    assert [said in row.hint for row in rows[1:]] == [number in equal for number in range(3)]
