"""The evaluations of a frame's depth: against ground truth and on hold-out, for the frame and per block."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..data.results import Completion
from ..evaluation.evaluation import Evaluated, PixelErrors
from ..evaluation.hold_out import HoldOutResult
from ..run.run import Run


def against_ground_truth(
    run: Run, completion: Completion, filled: NDArray[np.bool_], expected: NDArray[np.float32]
) -> Evaluated | None:
    """Evaluate some of the filled pixels against the frame's ground truth; None without it, or if no block was run.

    Parameters
    ----------
    run : Run
    completion : Completion
    filled : ndarray of bool, shape (H, W)
        The pixels to evaluate; the other missing ones count as not filled.
    expected : ndarray of float32, shape (H, W)
        `expected_error` of the completion [m].
    """
    ground_truth = run.frame.ground_truth
    if ground_truth is None or not completion.results:
        return None
    wanted = run.frame.missing & np.isfinite(ground_truth)
    depth = np.where(filled, completion.depth, np.float32(np.nan))
    errors = PixelErrors.at(wanted, depth, ground_truth, expected)
    return Evaluated(run.blocks.labels, (errors,))


def on_hold_out(hidden: HoldOutResult) -> dict[str, Evaluated]:
    """Name the evaluation over all seeds of a hold-out test, and, if there are several, that of each."""
    test = hidden.test
    seeds = ", ".join(map(str, test.seeds))
    named: dict[str, Evaluated] = {f"On hold-out ({test.pattern}; seed{'s' * (len(test.seeds) > 1)} {seeds})": hidden}
    if len(test.seeds) > 1:
        for seed, part in zip(test.seeds, hidden.parts, strict=True):
            named[f"seed {seed} alone"] = Evaluated(hidden.labels, (part,))
    return named


def p95(evaluated: Evaluated) -> float:
    """Return the 95th percentile of the absolute errors [m]; NaN if there are none."""
    errors = np.abs(np.concatenate([part.error[part.filled] for part in evaluated.parts]))
    known = errors[np.isfinite(errors)]
    return float(np.percentile(known, 95)) if known.size else math.nan
