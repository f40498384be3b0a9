"""What the benches print: progress, tables in which the best of every column is marked, and what was left out."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from .progress import Bar
from .report import table

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
