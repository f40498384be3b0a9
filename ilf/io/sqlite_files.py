"""SQLite files that anyone may have made: none of their tables is computed, and a statement takes only so much."""

from __future__ import annotations

import re
import sqlite3
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import FormatError

LONGEST = 2**28
"""Bytes of the longest value that is read: more than any image that can be worked with."""

STEPS = 10_000
"""Of SQLite's machine, after which it is asked whether a statement may go on (`Allowance.is_spent`)."""

DEFINITIONS = "SELECT ifnull(CAST(name AS TEXT), ''), CAST(sql AS TEXT) FROM sqlite_master WHERE sql IS NOT NULL"
"""Asks for what `check_plain` takes; a definition that is stored as bytes counts, too."""

_SECONDS, _SECONDS_PER_BYTE = 3.0, 2e-8

# no view, virtual table, generated column or trigger can be made without one of these words
_COMPUTED = re.compile(r"\b(as|virtual|trigger)\b", re.IGNORECASE)


class Allowance:
    """Processor time that each statement on a file may take: three seconds, and more for a large file.

    Time on the processor, because a sound file may lie on a slow disk; a file can keep SQLite busy for ever, too, whose
    pages lead to one another in a circle.
    """

    def __init__(self, size: int) -> None:
        self._seconds = _SECONDS + _SECONDS_PER_BYTE * size
        self.begin()

    def begin(self, *_: object) -> bool:
        """A statement begins, in this thread; always True."""
        self._began = time.thread_time()
        return True

    def is_spent(self) -> bool:
        """Whether the statement has taken more."""
        return time.thread_time() - self._began > self._seconds


class LimitedConnection(sqlite3.Connection):
    """A connection of Python's own whose statements take no more than an `Allowance`, and whose values have no more
    than `LONGEST` bytes; for `sqlite3.connect(path, factory=LimitedConnection)`."""

    def __init__(self, database: Path, *args: Any, **options: Any) -> None:
        super().__init__(database, *args, **options)
        self._allowance = Allowance(database.stat().st_size)
        self.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST)
        self.set_progress_handler(self._allowance.is_spent, STEPS)

    def execute(self, *statement: Any) -> sqlite3.Cursor:
        self._allowance.begin()
        return super().execute(*statement)

    def executemany(self, statement: str, rows: Iterable[Any], /) -> sqlite3.Cursor:
        return super().executemany(statement, (row for row in rows if self._allowance.begin()))


def check_plain(path: Path, schema: Iterable[tuple[str, str]]) -> list[str]:
    """That a file has plain tables alone, whose content is what is stored; gives the names of tables and indexes.

    Parameters
    ----------
    path : Path
        For the message.
    schema : iterable of (str, str)
        What `DEFINITIONS` gives: name and definition of each.

    Raises
    ------
    FormatError
        If there is a view, a virtual table, a generated column or a trigger.

    Examples
    --------
    >>> check_plain(Path("a.db3"), [("topics", "CREATE TABLE topics(id INTEGER)")])
    ['topics']
    """
    names = []
    for name, sql in schema:
        if _COMPUTED.search(sql):
            raise FormatError(
                f"{path}: {name!s:.60} is a view, a virtual table or a trigger, or has generated columns. Only plain "
                "tables are read: record or export it again."
            )
        names.append(name)
    return names
