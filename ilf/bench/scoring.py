"""The score of completed depth on a task."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..confidence import DEFAULT_MODEL, depth_error
from ..judgement import share_within, sparsification_error
from ..metrics import ErrorMeasures, fill_rate, measure_errors
from .patterns import Task
from .peers.interpolation import nearest


@dataclass(frozen=True)
class Score:
    """How good completed depth is.

    Attributes
    ----------
    errors : ErrorMeasures
        Over all scored pixels.
    coverage : float
        Share of them (0-1) that the method filled itself.
    within : float or None
        Share of those that it filled whose error is at most the expected error; None if it filled none.
    within_twice : float or None
        The same for twice the expected error.
    sparsification : float or None
        Of those: `ilf.judgement.sparsification_error`.
    """

    errors: ErrorMeasures
    coverage: float
    within: float | None = None
    within_twice: float | None = None
    sparsification: float | None = None


def score(depth: NDArray[np.floating], task: Task, error_model: str = DEFAULT_MODEL) -> Score:
    """Score completed depth [m], shape (H, W), NaN = not filled.

    What the method left open counts with the nearest depth that it was given, so refusing pixels does not help.
    `error_model`, one of `ilf.confidence.MODELS`, says how the expected error is worked out.
    """
    covered = np.isfinite(depth) & (depth > 0)
    dense = np.where(covered, depth, nearest(task.frame))
    errors, coverage = measure_errors(dense, task.truth, task.scored), fill_rate(depth, task.scored)
    filled = task.scored & covered
    if not filled.any():
        return Score(errors, coverage)
    error = depth[filled] - task.truth[filled]
    expected = depth_error(task.frame, depth, error_model)[filled]
    return Score(
        errors,
        coverage,
        share_within(error, expected),
        share_within(error, expected, 2),
        sparsification_error(error, expected),
    )
