"""What the list of kept runs shows: one row per run."""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence
from dataclasses import dataclass

from gui.state.run_names import title_of, values_text
from gui.state.session import Session
from ilf.project.kept_run import Colour, KeptRun

COMPARABLE = 0.9
"""Share of the pixels that any run has filled which a run must have filled to be called the best."""

ERRORS = ("truth_error", "hidden_error", "expected_error")
"""Attributes of `KeptRun` that say how good it is."""


@dataclass(frozen=True)
class RunRow:
    """What the list shows of one run, which identifies the row.

    Attributes
    ----------
    kept : KeptRun
    name, note : str
    title : str
        The name without the values, which have a place of their own.
    values : str
        What differs from the nearest preset, and what keeps it from being a whole run of all blocks.
    colour : tuple of int
    compared, present : bool
        Whether it is compared, and whether its results are the present ones.
    when : datetime
    seconds : float
    iterations : int
    errors : tuple of (float or None)
        Those of `ERRORS` [m].
    best : tuple of bool
        Which of them are the smallest of all runs.
    """

    kept: KeptRun
    name: str
    title: str
    note: str
    values: str
    colour: Colour
    compared: bool
    present: bool
    when: datetime.datetime
    seconds: float
    iterations: int
    errors: tuple[float | None, ...]
    best: tuple[bool, ...]


def run_rows(session: Session) -> list[RunRow]:
    """One row per kept run, the latest first."""
    present = session.valid_results()
    best = [best_of(session.kept_runs, error) for error in ERRORS]
    return [
        RunRow(
            kept=kept,
            name=kept.name,
            title=title_of(kept.name, session, kept.run),
            note=kept.note,
            values=" · ".join(text for text in (values_text(session, kept.run), lacks_of(kept)) if text),
            colour=kept.colour,
            compared=kept in session.compared,
            present=kept.is_of(present),
            when=kept.when,
            seconds=kept.seconds,
            iterations=kept.iterations,
            errors=tuple(getattr(kept, error) for error in ERRORS),
            best=tuple(kept in those for those in best),
        )
        for kept in reversed(session.kept_runs)
    ]


def lacks_of(kept: KeptRun) -> str:
    """What keeps a run from being a whole one, whose results are all of its own values; "" if nothing does."""
    texts = [] if kept.how == "finished" else [kept.how]
    if missing := kept.block_count - len(kept.results):
        texts.append(f"{missing} of {kept.block_count} blocks without result")
    if outdated := len(kept.outdated):
        texts.append(f"{outdated} of {kept.block_count} blocks of other values")
    return ", ".join(texts)


def best_of(runs: Sequence[KeptRun], error: str) -> list[KeptRun]:
    """Runs with the smallest error of such a kind, of those that have filled about as much as any, and were tested in
    the same way as most; none if there are no two to choose from."""
    most = max((kept.recovered for kept in runs), default=0)
    values = [(kept, getattr(kept, error)) for kept in runs if kept.recovered >= COMPARABLE * most]
    judged = [(kept, value) for kept, value in values if value is not None and math.isfinite(value)]
    if error == "hidden_error" and judged:
        tests = [kept.hidden_test for kept, _ in judged]
        usual = max(reversed(tests), key=tests.count)
        judged = [(kept, value) for kept, value in judged if kept.hidden_test == usual]
    smallest = min((value for _, value in judged), default=math.nan)
    return [kept for kept, value in judged if value == smallest] if len(judged) > 1 else []
