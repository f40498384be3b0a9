"""What the commands print: tables of blocks and summaries, as plain text."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from tqdm import tqdm

from .._runtime.formatting import counted, covered
from ..completion.confidence.expected_error import expected_error, unvouched
from ..completion.edge_aware.fitted_guide import fit_guide
from ..data.frame import RGBDFrame
from ..data.results import BlockOutcome, Completion, Progress, Status, blocks_by_message
from ..errors import one_line
from ..evaluation.evaluation import Judgement, Step, judge_blocks, judge_completion
from ..run.run import GUESS, Run, RunSteps

_MOST = 0.5
"""The larger part of a whole, from this share on."""


def completion_report(
    run: Run,
    completion: Completion,
    seconds: float,
    folder: Path,
    files: Sequence[Path],
) -> str:
    """What came out of a run, and where it lies."""
    outcomes, frame = completion.outcomes.values(), run.frame
    judged: list[str] = []
    guide = fit_guide(frame)
    errors: dict[int, Judgement] = {}
    if frame.truth is not None:
        expected = expected_error(completion)
        whole = judge_completion(frame, completion, expected=expected)
        errors = judge_blocks(frame, completion, run.blocks)
        judged = [_judgement_line(whole), *_source_of_error(run, completion, largest_share(whole, errors))]
    return "\n".join([
        *outcome_lines(outcomes, errors),
        "",
        f"{frame.name}: {covered(len(outcomes), np.count_nonzero(run.blocks) / run.blocks.size)}.",
        _recovered_line(frame, completion, seconds),
        *([] if guide is None else [f"Guide: {guide.in_words()}."]),
        *judged,
        f"Written to {folder}: {', '.join(file.name for file in files)}",
    ])  # fmt: skip


def outcome_lines(outcomes: Iterable[BlockOutcome], errors: Mapping[int, Judgement] | None = None) -> list[str]:
    """Table of the blocks that were run, with their errors if any are known, and below it what there is to say about
    single ones."""
    outcomes = list(outcomes)
    rows = [
        [
            str(outcome.label),
            str(outcome.pixels),
            f"{outcome.defect_rate:.1%}",
            str(outcome.recovered),
            outcome.status.value,
            str(outcome.iterations),
            str(outcome.stages),
            "-" if math.isnan(outcome.sigma_i) else f"{outcome.sigma_i * 1000:.3g}",
        ]
        for outcome in outcomes
    ]
    head = ["block", "pixels", "missing", "recovered", "status", "iterations", "stages", "sigma [mm]"]
    if errors:
        head.append("RMSE [mm]")
        for row, outcome in zip(rows, outcomes, strict=True):
            row.append(f"{1000 * errors[outcome.label].rmse:.2f}" if outcome.label in errors else "-")
    told = blocks_by_message(outcome for outcome in outcomes if outcome.status is not Status.NOTHING_MISSING)
    remarks = [f"{_blocks_text(labels)}: {message}" for message, labels in told.items()]
    return [*table(head, rows), *([""] if remarks else []), *remarks]


def _blocks_text(labels: Sequence[int]) -> str:
    if len(labels) == 1:
        return f"Block {labels[0]}"
    return f"{counted(len(labels), 'block')} ({', '.join(map(str, labels))})"


def largest_share(whole: Judgement, blocks: Mapping[int, Judgement]) -> tuple[int, float] | None:
    """The block that has at least half of the squared error of the whole in less than half of its pixels, and its
    share of the error, 0-1; None if no block has."""
    for label, one in blocks.items():
        if 0 < one.pixels < _MOST * whole.pixels and one.rmse > 0:
            share = one.pixels * one.rmse**2 / (whole.pixels * whole.rmse**2)
            if share >= _MOST:
                return label, share
    return None


def warn(notes: Iterable[str]) -> None:
    """Print what there is to tell the user on stderr, a line each and each once."""
    for note in dict.fromkeys(notes):
        print("ilf: warning:", one_line(note), file=sys.stderr)


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


def _judgement_line(judgement: Judgement) -> str:
    """How far the filled depth is from the truth, in words."""
    if not judgement.pixels:
        return "Against the truth: it is not known where depth was filled."
    within = "" if judgement.within is None else f"; {judgement.within:.0%} within the expected error"
    return (
        f"Against the truth, over {judgement.pixels} filled pixels: median error {1000 * judgement.median:.2f} mm, "
        f"MAE {1000 * judgement.mae:.2f} mm, RMSE {1000 * judgement.rmse:.2f} mm{within}."
    )


def _source_of_error(run: Run, completion: Completion, largest: tuple[int, float] | None) -> list[str]:
    """Where most of the error comes from, as a line; none if it comes from all over the frame."""
    if largest is None:
        return []
    label, share = largest
    doubtful = unvouched(completion)[completion.filled & (run.blocks == label)].mean()
    why = f"; nothing measured vouches for {doubtful:.0%} of its filled pixels" if doubtful >= _MOST else ""
    return [f"Block {label} has {share:.0%} of the squared error{why}."]


def _recovered_line(frame: RGBDFrame, completion: Completion, seconds: float) -> str:
    missing = int(np.count_nonzero(frame.missing))
    iterations = sum(outcome.iterations for outcome in completion.outcomes.values())
    effort = f"{iterations} iterations in {seconds:.1f} s."
    outside = _outside_sentence(frame, completion)
    if missing == 0:
        return f"No pixel was missing. {outside}{effort}"
    recovered = int(np.count_nonzero(completion.filled & frame.missing))
    return f"{recovered} of {missing} missing pixels recovered ({recovered / missing:.1%}). {outside}{effort}"


def _outside_sentence(frame: RGBDFrame, completion: Completion) -> str:
    if frame.outside_view is None:
        return ""
    pixels, filled = (
        int(np.count_nonzero(mask)) for mask in (frame.outside_view, frame.outside_view & completion.filled)
    )
    left = "left missing" if not filled else f"{filled} of them filled, though nothing could be measured there"
    return f"{pixels} pixels outside the depth camera's view, {left}. "


# Progress bars: of a run, and of judging several.


class Bar(tqdm):
    """tqdm without its monitor thread."""

    # otherwise the first bar starts a thread that outlives it
    monitor_interval = 0


class FramesBar(Bar):
    """A bar of a batch's frames on stderr, as long as the context lasts. The time left follows from the frames
    completed in this time: those that failed, or were there before, took hardly any.

    Parameters
    ----------
    total, done, failed : int
        Frames in all; those that come to nothing new, and how many of these failed before.
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, total: int, done: int, failed: int, *, shown: bool) -> None:
        self.completed, self.failed = 0, failed
        super().__init__(
            total=total,
            initial=done,
            disable=not shown,
            mininterval=0,
            leave=False,
            dynamic_ncols=True,
            bar_format="{n_fmt}/{total_fmt} frames |{bar:30}| {elapsed}, {left} left{postfix}",
        )

    def add(self, *, completed: bool) -> None:
        """One frame more is completed, or has failed."""
        self.completed += completed
        self.failed += not completed
        self.set_postfix_str(f"{self.failed} failed" if self.failed else "", refresh=False)
        self.update(1)

    @property
    def format_dict(self) -> dict[str, Any]:
        """What there is for the bar to show."""
        known: dict[str, Any] = super().format_dict
        left = self.total - self.n
        known["left"] = self.format_interval(known["elapsed"] * left / self.completed) if self.completed else "?"
        return known


class _Shown:
    """A bar on stderr, as long as the context lasts; none at all unless it is shown."""

    def __init__(self, total: float, count: str, shown: bool) -> None:
        self._bar = Bar(
            total=total,
            disable=not shown,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=count + " |{bar:30}| {elapsed}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()


class RunProgress(_Shown):
    """A bar on stderr: blocks done, and the last iteration of a block that runs.

    Parameters
    ----------
    run : RunSteps
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, run: RunSteps, *, shown: bool) -> None:
        super().__init__(len(run.blocks), "{n_fmt}/{total_fmt} blocks", shown)

    def update(self, step: Progress) -> None:
        """Show a step of the run."""
        record = step.record
        if record is None:
            self._bar.update(step.result is not None)
            return
        what = "guessing the rest" if step.label == GUESS else f"block {step.label}"
        self._bar.set_postfix_str(
            f"{what}: iteration {record.i}, stage {record.stage}, sigma {record.sigma_i * 1000:.3g} mm",
            refresh=False,
        )
        self._bar.update(0)


class ShareProgress(_Shown):
    """A bar on stderr for what tells the share that is done and what is under way.

    Parameters
    ----------
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, *, shown: bool) -> None:
        super().__init__(1.0, "{percentage:3.0f} %", shown)

    def update(self, step: Step) -> None:
        """Show a step."""
        self._bar.set_postfix_str(step.text, refresh=False)
        self._bar.update(max(min(step.share, 1.0) - self._bar.n, 0.0))


# What the benches print: progress, tables in which the best of every column is marked, and what was left out.

_NAMES_LISTED = 6


@dataclass(frozen=True)
class Column:
    """A column of a table: heading, value (a number or text, None for a dash), how it is written, and what is best of
    several (None: nothing is)."""

    heading: str
    value: Callable[[Any], Any]
    form: str
    best: Callable[[Sequence[float]], float] | None = min


def comparison_table(columns: Sequence[Column], lines: Sequence[Any], heading: str = "method") -> list[str]:
    """A table of summaries, each with a `method`, whose column is headed so; * marks the best of a column."""
    cells = [_cells(column, lines) for column in columns]
    rows = [(line.method, *texts) for line, *texts in zip(lines, *cells, strict=True)]
    return table((heading, *(f"{column.heading} " for column in columns)), rows)


def unit_bar(arguments: argparse.Namespace, total: int, what: str) -> Bar:
    """A progress bar on stderr, if the arguments or a terminal ask for one; `advance` moves it on."""
    shown = sys.stderr.isatty() if arguments.progress is None else arguments.progress
    return Bar(
        total=total,
        disable=not shown,
        mininterval=0,
        leave=False,
        dynamic_ncols=True,
        bar_format=f"{{n_fmt}}/{{total_fmt}} {what} |{{bar:30}}| {{elapsed}}{{postfix}}",
    )


def advance(bar: Bar, name: str) -> None:
    """Count one unit, and show its name."""
    bar.set_postfix_str(name, refresh=False)
    bar.update(1)


def skipped_lines(skipped: Iterable[tuple[str, str, str]]) -> list[str]:
    """What was left out, one line per reason, from (frame, pattern or "" for all, reason)."""
    by_reason: dict[tuple[str, str], list[str]] = {}
    for frame, pattern, reason in skipped:
        by_reason.setdefault((pattern, reason), []).append(frame)
    return [
        f"skipped{f' for pattern {pattern}' if pattern else ''}: {_listed(frames)}. {reason}"
        for (pattern, reason), frames in by_reason.items()
    ]


def _cells(column: Column, lines: Sequence[Any]) -> list[str]:
    values = [column.value(line) for line in lines]
    texts = ["-" if value is None else format(value, column.form) for value in values]
    numbers = [value for value in values if value is not None]
    if column.best is None or not numbers:
        return [f"{text} " for text in texts]
    # what looks equal is equally good
    best = format(column.best(numbers), column.form)
    return [f"{text}{'*' if text == best else ' '}" for text in texts]


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMES_LISTED
    return ", ".join(names[:_NAMES_LISTED]) + (f" and {more} more" if more > 0 else "")
