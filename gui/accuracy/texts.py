"""Judgements in words: millimetres and shares, for the tables of the panel."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ilf.judgement import Judgement
from ilf.number_words import UNKNOWN, millimetres

RMSE = ("RMSE", "Root mean square error in millimetres: large errors count most")
MAE = ("MAE", "Mean absolute error in millimetres")
MEDIAN = ("Med.", "Median of the absolute errors in millimetres: half of the pixels are closer")
WITHIN = (
    "Within",
    "Share of the filled pixels whose error is within their expected error; about 68 % is as it should be",
)
PIXELS = ("Pixels", "Over how many pixels the errors are")


def errors(judgement: Judgement) -> tuple[str, str, str]:
    """RMSE, MAE and median."""
    return millimetres(judgement.rmse), millimetres(judgement.mae), millimetres(judgement.median)


def within(judgement: Judgement) -> str:
    """The share within the expected error."""
    known = judgement.within is not None and math.isfinite(judgement.within)
    return f"{judgement.within:.0%}" if known else UNKNOWN


def thousands(count: int) -> str:
    """A number of pixels, in short.

    Examples
    --------
    >>> thousands(121573), thousands(430), thousands(0)
    ('122k', '430', '–')
    """
    return f"{count / 1000:.0f}k" if count >= 10_000 else str(count) if count else UNKNOWN


def best_of(judgements: Sequence[Judgement]) -> set[int]:
    """Which have the smallest RMSE, if there are others. Who fills less than the rest is judged on less, and is none.

    Examples
    --------
    >>> best_of([Judgement(9, rmse=0.2), Judgement(9, rmse=0.1), Judgement(3, rmse=0.05)])
    {1}
    """
    most = max((one.pixels for one in judgements), default=0)
    known = {number: one.rmse for number, one in enumerate(judgements) if one.pixels == most and most}
    best = {number for number, rmse in known.items() if rmse == min(known.values())}
    return best if len(best) < len(known) else set()
