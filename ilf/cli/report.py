"""What the commands print: tables of blocks and summaries, as plain text."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ..frame import RGBDFrame
from ..outcomes import BlockOutcome, Completion, Status
from ..run import Run


def completion_report(
    run: Run,
    completion: Completion,
    seconds: float,
    folder: Path,
    files: Sequence[Path],
) -> str:
    """What came out of a run, and where it lies."""
    outcomes = completion.outcomes.values()
    return "\n".join([
        *outcome_lines(outcomes),
        "",
        f"{run.frame.name}: {len(outcomes)} blocks cover {np.count_nonzero(run.blocks) / run.blocks.size:.1%} of the "
        "frame.",
        _recovered_line(run.frame, completion, seconds),
        f"Written to {folder}: {', '.join(file.name for file in files)}",
    ])  # fmt: skip


def outcome_lines(outcomes: Iterable[BlockOutcome]) -> list[str]:
    """Table of the blocks that were run, and below it what there is to say about single ones."""
    outcomes = list(outcomes)
    rows = [
        (
            str(outcome.label),
            str(outcome.pixels),
            f"{outcome.defect_rate:.1%}",
            str(outcome.recovered),
            outcome.status.value,
            str(outcome.iterations),
            str(outcome.stages),
            "-" if math.isnan(outcome.sigma_i) else f"{outcome.sigma_i * 1000:.3g}",
        )
        for outcome in outcomes
    ]
    head = ("block", "pixels", "missing", "recovered", "status", "iterations", "stages", "sigma [mm]")
    remarks = [
        f"Block {outcome.label}: {outcome.message}"
        for outcome in outcomes
        if outcome.message and outcome.status is not Status.NOTHING_MISSING
    ]
    return [*table(head, rows), *([""] if remarks else []), *remarks]


def warn(notes: Iterable[str]) -> None:
    """Print what there is to tell the user on stderr, a line each and each once."""
    for note in dict.fromkeys(notes):
        print("ilf: warning:", " ".join(note.split()), file=sys.stderr)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table; columns of words are set left, those of numbers right."""
    columns = list(zip(head, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    left = [any(cell[:1].isalpha() for cell in column[1:]) for column in columns]
    return [
        "  ".join(
            cell.ljust(width) if at_left else cell.rjust(width)
            for cell, width, at_left in zip(row, widths, left, strict=True)
        ).rstrip()
        for row in (head, *rows)
    ]


def _recovered_line(frame: RGBDFrame, completion: Completion, seconds: float) -> str:
    missing = int(np.count_nonzero(~frame.known))
    iterations = sum(outcome.iterations for outcome in completion.outcomes.values())
    effort = f"{iterations} iterations in {seconds:.1f} s."
    if missing == 0:
        return f"No pixel was missing. {effort}"
    recovered = int(np.count_nonzero(completion.filled))
    return f"{recovered} of {missing} missing pixels recovered ({recovered / missing:.1%}). {effort}"
