"""Tables as CSV, safe to open in a spreadsheet with any names of files, runs and blocks."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable
from pathlib import Path

from .._runtime.writing import ensure_folder, write_bytes

_FORMULA = re.compile(r"(^|[;\t\n])(?=\s*[=+\-@＝＋－＠]|[\t\n])")
"""Places where a spreadsheet would start a formula: at the beginning of a cell, or after a character that separates
cells in some countries."""


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Format a table as CSV, None as an empty cell.

    Text that a spreadsheet would read as a formula gets an apostrophe; numbers stay unchanged. Lines within a cell end
    with a line feed.

    Parameters
    ----------
    rows : iterable of iterables
        The first row contains the column names.

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
    """Write a table in the format of `csv_text` atomically, in a folder that is created if missing; raise
    ExportError if that fails."""
    ensure_folder(Path(path).parent)
    write_bytes(path, csv_text(rows).encode(errors="backslashreplace"))  # file names may be invalid UTF-8


def _cell(value: object) -> str:
    text = "" if value is None else str(value).replace("\r\n", "\n").replace("\r", "\n")
    if _FORMULA.search(text) is None:
        return text
    try:
        float(text)
    except ValueError:
        return _FORMULA.sub(r"\1'", text)
    return text
