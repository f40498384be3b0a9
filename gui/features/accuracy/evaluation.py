"""Errors of several results, and their evaluation against ground truth in a worker thread: for the frame, blocks and a
rectangle."""

from __future__ import annotations

import math
from collections.abc import Mapping, MutableMapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.completion.confidence.expected_error import expected_error
from ilf.data.results import Completion
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors
from ilf.evaluation.ground_truth import shared_pixels
from ilf.evaluation.ties import Ties, find_ties

from ...widgets.row_table import NumberRow

COLUMNS = (
    ("RMSE", "Root mean square error in millimetres: large errors count most"),
    ("MAE", "Mean absolute error in millimetres"),
    ("Med.", "Median of the absolute errors in millimetres: half of the pixels are below"),
)
"""Columns of all tables of errors."""
GROUND_TRUTH_COLUMNS = (
    *COLUMNS,
    ("Within", "Share of the filled pixels whose error is within their expected error; about 68 % is expected"),
)


class EvaluatedResult(NamedTuple):
    """A result to evaluate: name and completion, and the colour of its run, None for the current one."""

    name: str
    completion: Completion
    colour: tuple[int, int, int] | None = None


class AreaErrors(NamedTuple):
    """Errors of several results over a part of the frame, and those with the smallest error."""

    evaluated: tuple[Evaluation, ...]
    best: Ties | None

    def row(self, number: int, title: str, hint: str, last: str, colour: tuple[int, int, int] | None) -> NumberRow:
        """Return the row of a result, with its errors in the order of `COLUMNS` and a last cell. One of the best of
        several is marked, unless all are equal."""
        one, count, best = self.evaluated[number], len(self.evaluated), self.best
        is_best = best is not None and count > 1 and number in best.equal
        if best is not None and is_best:
            others = "All" if len(best.equal) == count else f"{len(best.equal)} of them, with the smallest RMSE,"
            hint += f" {others} are equal within {millimetres(best.within)} mm." if best else " Smallest RMSE of all."
            is_best = len(best.equal) < count
        cells = millimetres(one.rmse), millimetres(one.mae), millimetres(one.median), last
        return NumberRow(title, cells, hint, colour, is_best)


def area_errors(several: Sequence[Evaluated]) -> AreaErrors:
    """Return the errors of results; those with fewer evaluated pixels than others are not the best."""
    evaluations = tuple(one.whole for one in several)
    most = max((one.pixels for one in evaluations), default=0)
    return AreaErrors(
        evaluations, find_ties(several, [number for number, one in enumerate(evaluations) if one.pixels == most])
    )


ExpectedErrors = MutableMapping[Completion, NDArray[np.float32]]
"""The expected errors that were computed."""


def evaluate_areas(
    ground_truth: NDArray[np.float32],
    entries: Sequence[EvaluatedResult],
    labels: NDArray[np.int32],
    areas: Mapping[str, NDArray[np.bool_]],
    every: bool,
    expected: ExpectedErrors,
    with_expected: bool,
) -> dict[str, AreaErrors]:
    """Evaluate results of a frame over the pixels that all of them have filled; called in a worker thread.

    Parameters
    ----------
    ground_truth : ndarray of float32, shape (H, W)
        [m].
    entries : sequence of EvaluatedResult
    labels : ndarray of int32, shape (H, W)
        The current label map.
    areas : mapping of str to ndarray of bool, shape (H, W)
        Parts of the frame by name.
    every : bool
        Whether known pixels also count.
    expected : ExpectedErrors
        Gets what it lacks.
    with_expected : bool
        Whether to compute the share within the expected error also where `expected` lacks that, which takes longer.
    """
    shared = shared_pixels([entry.completion for entry in entries], every=every)
    found = {}
    for name, area in areas.items():
        places = np.flatnonzero(shared & np.isfinite(ground_truth) & area)
        evaluated = []
        for _, completion, _ in entries:
            if with_expected and completion not in expected:
                expected[completion] = expected_error(completion)
            depth = completion.depth.ravel()[places]
            if not every:
                depth[~(completion.filled & completion.run.frame.missing).ravel()[places]] = np.nan
            likely = expected[completion].ravel()[places] if completion in expected else np.full_like(depth, np.nan)
            errors = PixelErrors(places, depth, ground_truth.ravel()[places], likely)
            evaluated.append(Evaluated(labels, (errors,)))
        found[name] = area_errors(evaluated)
    return found


def ground_truth_rows(found: Mapping[str, AreaErrors], entries: Sequence[EvaluatedResult]) -> list[NumberRow]:
    """Rows for the parts of the frame, each with a row per result; for a single result, a row per part."""
    rows = []
    alone = len(entries) == 1
    for name, area in found.items():
        rows += [] if alone else [NumberRow(name)]
        for number, (entry, one) in enumerate(zip(entries, area.evaluated, strict=True)):
            title, what = (name, name) if alone else (entry.name, f"{name}, {entry.name}")
            hint = f"{what}: no pixel has both a result and ground truth."
            if one.pixels:
                hint = f"{what}: {one.pixels:,} pixels, mean error {1000 * one.bias:+.2f} mm."
            known = one.within is not None and math.isfinite(one.within)
            rows.append(area.row(number, title, hint, f"{one.within:.0%}" if known else UNKNOWN, entry.colour))
    return rows
