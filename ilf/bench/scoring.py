"""The score of completed depth on a task."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..metrics import ErrorMeasures, fill_rate, measure_errors
from .patterns import Task
from .peers.interpolation import nearest


@dataclass(frozen=True)
class Score:
    """Errors over all scored pixels, and the share of them (0-1) that the method filled itself."""

    errors: ErrorMeasures
    coverage: float


def score(depth: NDArray[np.floating], task: Task) -> Score:
    """Score completed depth [m], shape (H, W), NaN = not filled.

    What the method left open counts with the nearest depth that it was given, so refusing pixels does not help.
    """
    covered = np.isfinite(depth) & (depth > 0)
    dense = np.where(covered, depth, nearest(task.frame))
    return Score(measure_errors(dense, task.truth, task.scored), fill_rate(depth, task.scored))
