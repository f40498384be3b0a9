"""Errors as rows of the tables of the panel Accuracy, in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.evaluation.evaluation import Evaluation
from ilf.evaluation.ties import Ties

from ...widgets.tables import Row
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

_Rank = tuple[bool, str]
"""Whether a row is marked as one of the best, and a sentence on it; "" for the others."""


def ground_truth_rows(found: Mapping[str, AreaErrors], entries: Sequence[EvaluatedResult]) -> list[Row]:
    """Rows for the parts of the frame, each with a row per result; for a single result, a row per part."""
    rows = []
    for name, area in found.items():
        if len(entries) == 1:
            rows.append(_ground_truth_row(name, area.evaluated[0], (False, ""), None, name))
            continue
        rows.append(Row(name))
        for number, (entry, one) in enumerate(zip(entries, area.evaluated, strict=True)):
            rank, what = _rank(area.best, number, len(entries)), f"{name}, {entry.name}"
            rows.append(_ground_truth_row(entry.name, one, rank, entry.colour, what))
    return rows


def _ground_truth_row(
    name: str, evaluated: Evaluation, rank: _Rank, colour: tuple[int, int, int] | None, what: str
) -> Row:
    is_best, sentence = rank
    hint = f"{what}: no pixel has both a result and ground truth."
    if evaluated.pixels:
        hint = f"{what}: {evaluated.pixels:,} pixels, mean error {1000 * evaluated.bias:+.2f} mm.{sentence}"
    known = evaluated.within is not None and math.isfinite(evaluated.within)
    within = f"{evaluated.within:.0%}" if known else UNKNOWN
    return Row(name, (*_errors(evaluated), within), hint, colour, is_best)


def hold_out_rows(outcome: HoldOutOutcome, label: int) -> list[Row]:
    """Rows of the tested candidates, over all blocks or over one."""
    rows, best = [], outcome.best.get(label)
    for number, tested in enumerate(outcome.tested):
        candidate = tested.candidate
        evaluated = tested.blocks.get(label, Evaluation()) if label else tested.whole
        is_best, sentence = _rank(best, number, len(outcome.tested))
        hint = f"{candidate.name}: {evaluated.pixels:,} pixels. {tested.coverage:.1%} of the held-out depth was filled."
        hint += sentence
        if evaluated.within is not None:
            hint += f" {evaluated.within:.0%} of the errors are within the expected error."
        colour = None if candidate.kept is None else candidate.kept.colour
        rows.append(Row(candidate.name, (*_errors(evaluated), _count(evaluated.pixels)), hint, colour, is_best))
    return rows


def _rank(best: Ties | None, number: int, count: int) -> _Rank:
    """Rank a row of several: if all are equal, none is marked."""
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
