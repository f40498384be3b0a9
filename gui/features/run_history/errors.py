"""Errors of stored runs, and which is best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import millimetres
from ilf.completion.confidence.expected_error import error_summary, expected_error
from ilf.data.results import BlockResult, compose
from ilf.evaluation.evaluation import evaluate
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

_COMPARABLE = 0.9
"""Minimum number of filled pixels of a best run, as a share of the largest number of any run."""

GroundTruth = NDArray[np.float32] | None


class RunErrors(NamedTuple):
    """Root mean square errors [m] over the pixels filled by a run's blocks; NaN if undefined."""

    ground_truth_error: float = math.nan
    expected_error: float = math.nan


def measure(run: Run, results: Mapping[int, BlockResult], ground_truth: GroundTruth) -> RunErrors:
    """Compute the errors of results of a run's blocks, with ground truth [m] if there is one."""
    completion = compose(run, results)
    if not completion.filled.any():
        return RunErrors()
    expected = error_summary(expected_error(completion), completion).rms
    if ground_truth is None:
        return RunErrors(expected_error=expected)
    return RunErrors(evaluate(completion.depth, ground_truth, completion.filled).rmse, expected)


def best_of(runs: Sequence[StoredRun], error: str) -> list[StoredRun]:
    """Return the runs with the smallest error of a kind, several if it is the same in the digits that are shown, of
    those that have filled about as many pixels as any, and for hold-out errors were tested like most; none if fewer
    than two are comparable, or if all of these are equal."""
    most = max((run.recovered for run in runs), default=0)
    values = [(run, getattr(run, error)) for run in runs if run.recovered >= _COMPARABLE * most]
    evaluated = [(run, value) for run, value in values if value is not None and math.isfinite(value)]
    if error == "hold_out_error" and evaluated:
        tests = [run.hold_out_test for run, _ in evaluated]
        usual = max(reversed(tests), key=tests.count)
        evaluated = [(run, value) for run, value in evaluated if run.hold_out_test == usual]
    smallest = millimetres(min((value for _, value in evaluated), default=math.nan))
    best = [run for run, value in evaluated if millimetres(value) == smallest]
    return best if len(best) < len(evaluated) else []
