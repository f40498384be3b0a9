"""Tables as CSV, safe to open in a spreadsheet whatever the names of files, runs and blocks in them."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable

from .._runtime.files import write_bytes

_FORMULA = re.compile(r"(^|[;\t\n])(?=\s*[=+\-@＝＋－＠]|[\t\n])")
"""Where a spreadsheet would take up a formula: at the beginning of a cell, or behind what divides cells in some
countries."""


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """A table as CSV, None as an empty cell.

    An apostrophe stands before what a spreadsheet would take for a formula; numbers stay as they are. Lines within a
    cell end with a line feed.

    Parameters
    ----------
    rows : iterable of iterables
        The names of the columns first.

    Examples
    --------
    >>> print(csv_text([["frame", "mean_m"], ["=1+1", -0.25], ["-5", None]]), end="")
    frame,mean_m
    '=1+1,-0.25
    -5,
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def write_csv(path: str | os.PathLike[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table as `csv_text` gives it, atomically; raises ExportError if that fails."""
    write_bytes(path, csv_text(rows).encode(errors="backslashreplace"))  # names of files may be no text


def _cell(value: object) -> str:
    text = "" if value is None else str(value).replace("\r\n", "\n").replace("\r", "\n")
    if _FORMULA.search(text) is None:
        return text
    try:
        float(text)
    except ValueError:
        return _FORMULA.sub(r"\1'", text)
    return text
