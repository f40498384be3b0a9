"""Errors as rows of the tables of the panel Accuracy, in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.evaluation.evaluation import Evaluation

from ...widgets.number_table import Row
from .evaluation import AreaErrors, EvaluatedResult
from .hold_out import HoldOutOutcome

_ERRORS = (
    ("RMSE", "Root mean square error in millimetres: large errors count most"),
    ("MAE", "Mean absolute error in millimetres"),
    ("Med.", "Median of the absolute errors in millimetres: half of the pixels are below"),
)
GROUND_TRUTH_COLUMNS = (
    *_ERRORS,
    ("Within", "Share of the filled pixels whose error is within their expected error; about 68 % is expected"),
)
HOLD_OUT_COLUMNS = (*_ERRORS, ("Pixels", "Number of evaluated pixels"))


def ground_truth_rows(found: Mapping[str, AreaErrors], entries: Sequence[EvaluatedResult]) -> list[Row]:
    """Rows for the parts of the frame, each with a row per result; for a single result, a row per part."""
    rows = []
    alone = len(entries) == 1
    for name, area in found.items():
        rows += [] if alone else [Row(name)]
        for number, (entry, one) in enumerate(zip(entries, area.evaluated, strict=True)):
            is_best, sentence = _rank(area, number)
            title, what = (name, name) if alone else (entry.name, f"{name}, {entry.name}")
            hint = f"{what}: no pixel has both a result and ground truth."
            if one.pixels:
                hint = f"{what}: {one.pixels:,} pixels, mean error {1000 * one.bias:+.2f} mm.{sentence}"
            known = one.within is not None and math.isfinite(one.within)
            within = f"{one.within:.0%}" if known else UNKNOWN
            rows.append(Row(title, (*_errors(one), within), hint, entry.colour, is_best))
    return rows


def hold_out_rows(outcome: HoldOutOutcome, label: int) -> list[Row]:
    """Rows of the tested candidates, over all blocks (0) or over one."""
    rows = []
    nothing = AreaErrors((Evaluation(),) * len(outcome.candidates), None)
    area = outcome.errors.get(label, nothing)
    for number, (candidate, one) in enumerate(zip(outcome.candidates, area.evaluated, strict=True)):
        is_best, sentence = _rank(area, number)
        filled = f"{outcome.coverage[number]:.1%} of the held-out depth was filled."
        hint = f"{candidate.name}: {one.pixels:,} pixels. {filled}{sentence}"
        if one.within is not None:
            hint += f" {one.within:.0%} of the errors are within the expected error."
        colour = None if candidate.kept is None else candidate.kept.colour
        rows.append(Row(candidate.name, (*_errors(one), _count(one.pixels)), hint, colour, is_best))
    return rows


def _rank(area: AreaErrors, number: int) -> tuple[bool, str]:
    """Return whether a result is marked as one of the best of several, and a sentence on it, "" for the others; if all
    are equal, none is marked."""
    best, count = area.best, len(area.evaluated)
    if best is None or count < 2 or number not in best.equal:
        return False, ""
    if not best:
        return True, " Smallest RMSE of all."
    others = "All" if len(best.equal) == count else f"{len(best.equal)} of them, with the smallest RMSE,"
    return len(best.equal) < count, f" {others} are equal within {millimetres(best.within)} mm."


def _errors(evaluation: Evaluation) -> tuple[str, str, str]:
    """RMSE, MAE and median."""
    return millimetres(evaluation.rmse), millimetres(evaluation.mae), millimetres(evaluation.median)


def _count(pixels: int) -> str:
    """Short text of a number of pixels, as "122k"."""
    return f"{pixels / 1000:.0f}k" if pixels >= 10_000 else str(pixels) if pixels else UNKNOWN
