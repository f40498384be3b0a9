"""Output of the commands: tables, warnings, the progress bar, JSON. Quick to import."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from tqdm import tqdm

from .._runtime.schema import plain
from ..errors import one_line, without_credentials


def print_json(document: object) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json.dumps(plain(document), indent=2, allow_nan=False))


def warn(notes: Iterable[str]) -> None:
    """Print warnings on stderr, one line each and without repetition."""
    for note in dict.fromkeys(notes):
        print("ilf: warning:", one_line(without_credentials(note)), file=sys.stderr)


@dataclass(frozen=True)
class Column:
    """A column of a table: heading, value of an item (None or NaN for a dash), its format, and the function that
    selects the best of several values, which are marked by * (None: no best value)."""

    heading: str
    value: Callable[[Any], Any]
    form: str = ""
    best: Callable[[Sequence[float]], float] | None = None


def table(columns: Sequence[Column], items: Sequence[Any]) -> list[str]:
    """Format the lines of a table; text is left-aligned, numbers are right-aligned."""
    cells = [_cells(column, items) for column in columns]
    lefts = [any(cell[:1].isalpha() for cell in column[1:]) for column in cells]
    padded = [
        [cell.ljust(width) if left else cell.rjust(width) for cell in column]
        for column, left, width in zip(cells, lefts, (max(map(len, column)) for column in cells), strict=True)
    ]
    return ["  ".join(row).rstrip() for row in zip(*padded, strict=True)]


def _cells(column: Column, items: Sequence[Any]) -> list[str]:
    """The heading and the texts of a column; where the best is marked, with room for the mark."""
    values = [column.value(item) for item in items]
    known = [value is not None and value == value for value in values]
    texts = [format(value, column.form) if there else "-" for value, there in zip(values, known, strict=True)]
    if column.best is None:
        return [column.heading, *texts]
    numbers = [value for value, there in zip(values, known, strict=True) if there]
    # values that are printed equally are equally good
    best = format(column.best(numbers), column.form) if numbers else None
    return [f"{column.heading} ", *(f"{text}{'*' if text == best else ' '}" for text in texts)]


_NAMES_WIDTH = 13
"""Minimum width of the names of facts [characters]."""


def fact_lines(facts: Sequence[tuple[str, str]]) -> list[str]:
    """Format facts, each a name and a text, one below the other."""
    width = max([_NAMES_WIDTH, *(len(name) + 1 for name, _ in facts)])
    return [f"{name + ':':{width}} {text}" for name, text in facts]


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
        What there is to do; with the default it is shown in per cent.
    unit : str
        What is counted.
    shown : bool
        Whether to show the bar.
    done : float
        What was done before.
    """

    # otherwise the first bar starts a thread that keeps running
    monitor_interval = 0

    def __init__(self, total: float = 1.0, unit: str = "", *, shown: bool, done: float = 0) -> None:
        count = f"{{n_fmt}}/{{total_fmt}} {unit}" if unit else "{percentage:3.0f} %"
        super().__init__(
            total=total,
            initial=done,
            disable=not shown,
            mininterval=0.1,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=f"{count} |{{bar:30}}| {{elapsed}}, {{remaining}} left{{postfix}}",
        )

    def show(self, done: float, text: str) -> None:
        """Show what has been done so far, and a text."""
        self.set_postfix_str(text, refresh=False)
        self.update(max(min(done, self.total) - self.n, 0))

    def advance(self, text: str) -> None:
        """Count one more, and show a text at once."""
        self.n += 1
        self.set_postfix_str(text)
