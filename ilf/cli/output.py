"""Output of the commands: tables, warnings, progress bars, JSON. Quick to import."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from .._runtime.schema import plain
from ..errors import one_line, without_credentials

if TYPE_CHECKING:
    from ..evaluation.evaluation import Progress


def print_json(document: object) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json.dumps(plain(document), indent=2, allow_nan=False))


def warn(notes: Iterable[str]) -> None:
    """Print warnings on stderr, one line each and without repetition."""
    for note in dict.fromkeys(notes):
        print("ilf: warning:", one_line(without_credentials(note)), file=sys.stderr)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Format the lines of a table; text is left-aligned, numbers are right-aligned."""
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


# Progress bars of runs, batches and evaluations.


def shows_progress(arguments: argparse.Namespace) -> bool:
    """Whether a command shows its progress: as --progress says, or on a terminal, but not with --quiet."""
    if getattr(arguments, "quiet", False):
        return False
    return bool(sys.stderr.isatty() if arguments.progress is None else arguments.progress)


class Bar(tqdm):
    """A progress bar on stderr, without the monitor thread of tqdm; a context manager.

    Parameters
    ----------
    total : float
    count : str
        Format of what is done, as for tqdm.
    shown : bool
        Whether to show the bar.
    left : str
        Format of the remaining time.
    initial : float
        What was done before.
    interval : float
        Minimum time between two drawings [s].
    """

    # otherwise the first bar starts a thread that keeps running
    monitor_interval = 0

    def __init__(
        self, total: float, count: str, shown: bool, left: str = "", initial: float = 0, interval: float = 0
    ) -> None:
        super().__init__(
            total=total,
            initial=initial,
            disable=not shown,
            mininterval=interval,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=f"{count} |{{bar:30}}| {{elapsed}}{left}{{postfix}}",
        )


class FramesBar(Bar):
    """A progress bar of a batch's frames on stderr; a context manager. The remaining time is estimated from completed
    frames only, because failed and earlier frames take hardly any time.

    Parameters
    ----------
    total, done, failed : int
        Number of all frames, of those done before, and of those of them that failed.
    shown : bool
        Whether to show the bar.
    """

    def __init__(self, total: int, done: int, failed: int, *, shown: bool) -> None:
        self.completed, self.failed = 0, failed
        super().__init__(total, "{n_fmt}/{total_fmt} frames", shown, ", {left} left", done)

    def add(self, *, completed: bool) -> None:
        """Count one more completed or failed frame."""
        self.completed += completed
        self.failed += not completed
        self.set_postfix_str(f"{self.failed} failed" if self.failed else "", refresh=False)
        self.update(1)

    @property
    def format_dict(self) -> dict[str, Any]:
        """Values of the bar's format, with the remaining time."""
        known: dict[str, Any] = super().format_dict
        left = self.total - self.n
        known["left"] = self.format_interval(known["elapsed"] * left / self.completed) if self.completed else "?"
        return known


class ShareProgress(Bar):
    """A progress bar on stderr for steps with a share and a text.

    Parameters
    ----------
    shown : bool
        Whether to show the bar.
    """

    def __init__(self, *, shown: bool) -> None:
        super().__init__(1.0, "{percentage:3.0f} %", shown, interval=0.1)

    def show(self, step: Progress) -> None:
        """Show a step."""
        self.set_postfix_str(step.text, refresh=False)
        self.update(max(min(step.share, 1.0) - self.n, 0.0))


# Output of the benchmarks: progress, tables with the best value of every column marked, and skipped frames.

_NAMES_LISTED = 6


@dataclass(frozen=True)
class Column:
    """A column of a table: heading, value (a number or text, None for a dash), number format, and the function that
    selects the best of several values (None: no best value)."""

    heading: str
    value: Callable[[Any], Any]
    form: str
    best: Callable[[Sequence[float]], float] | None = min


def comparison_table(
    columns: Sequence[Column], names: Sequence[str], lines: Sequence[Any], heading: str = "method"
) -> list[str]:
    """Format a table of lines, with their names in the first column; * marks the best of a column."""
    cells = [_cells(column, lines) for column in columns]
    rows = list(zip(names, *cells, strict=True))
    return table((heading, *(f"{column.heading} " for column in columns)), rows)


def unit_bar(arguments: argparse.Namespace, total: int, what: str) -> Bar:
    """Make a progress bar on stderr, shown by --progress or on a terminal; `advance` updates it."""
    return Bar(total, f"{{n_fmt}}/{{total_fmt}} {what}", shows_progress(arguments))


def advance(bar: Bar, name: str) -> None:
    """Count one unit, and show its name."""
    bar.set_postfix_str(name, refresh=False)
    bar.update(1)


def skipped_lines(skipped: Iterable[tuple[str, str, str]]) -> list[str]:
    """Format skipped frames, one line per reason, from (frame, pattern or "" for all, reason)."""
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
    # values that are printed equally are equally good
    best = format(column.best(numbers), column.form)
    return [f"{text}{'*' if text == best else ' '}" for text in texts]


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMES_LISTED
    return ", ".join(names[:_NAMES_LISTED]) + (f" and {more} more" if more > 0 else "")
