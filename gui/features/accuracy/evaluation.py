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
from ilf.data.label_map import Box
from ilf.data.results import Completion
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors
from ilf.evaluation.ground_truth import shared_pixels
from ilf.evaluation.ties import Ties, find_ties

from ...widgets.row_table import Row

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

Area = tuple[int, ...] | Box | None
"""A part of a frame: labels of blocks, a rectangle, or None for all of it."""


class EvaluatedResult(NamedTuple):
    """A result to evaluate: name and completion, and the colour of its run, None for the current one."""

    name: str
    completion: Completion
    colour: tuple[int, int, int] | None = None


class AreaErrors(NamedTuple):
    """Errors of several results over a part of the frame, and those with the smallest error."""

    evaluated: tuple[Evaluation, ...]
    best: Ties | None

    def rank(self, number: int) -> tuple[bool, str]:
        """Return whether a result is marked as one of the best of several, and a sentence on it, "" for the others; if
        all are equal, none is marked."""
        best, count = self.best, len(self.evaluated)
        if best is None or count < 2 or number not in best.equal:
            return False, ""
        if not best:
            return True, " Smallest RMSE of all."
        others = "All" if len(best.equal) == count else f"{len(best.equal)} of them, with the smallest RMSE,"
        return len(best.equal) < count, f" {others} are equal within {millimetres(best.within)} mm."

    def texts(self, number: int) -> tuple[str, str, str]:
        """Return the errors of a result as texts, in the order of `COLUMNS`."""
        one = self.evaluated[number]
        return millimetres(one.rmse), millimetres(one.mae), millimetres(one.median)


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
    areas: Mapping[str, Area],
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
    areas : mapping of str to Area
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
        places = np.flatnonzero(shared & np.isfinite(ground_truth) & _inside(area, labels))
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


def _inside(area: Area, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    if area is None:
        return np.ones(labels.shape, bool)
    if not isinstance(area[0], slice):
        return np.isin(labels, area)
    inside = np.zeros(labels.shape, bool)
    inside[area] = True
    return inside


def ground_truth_rows(found: Mapping[str, AreaErrors], entries: Sequence[EvaluatedResult]) -> list[Row]:
    """Rows for the parts of the frame, each with a row per result; for a single result, a row per part."""
    rows = []
    alone = len(entries) == 1
    for name, area in found.items():
        rows += [] if alone else [Row(name)]
        for number, (entry, one) in enumerate(zip(entries, area.evaluated, strict=True)):
            is_best, sentence = area.rank(number)
            title, what = (name, name) if alone else (entry.name, f"{name}, {entry.name}")
            hint = f"{what}: no pixel has both a result and ground truth."
            if one.pixels:
                hint = f"{what}: {one.pixels:,} pixels, mean error {1000 * one.bias:+.2f} mm.{sentence}"
            known = one.within is not None and math.isfinite(one.within)
            within = f"{one.within:.0%}" if known else UNKNOWN
            rows.append(Row(title, (*area.texts(number), within), hint, entry.colour, is_best))
    return rows
