"""Safe reading of untrusted SQLite files: plain tables only, with limits on time and size of statements."""

from __future__ import annotations

import re
import time
from collections.abc import Iterable
from pathlib import Path

from ..errors import FormatError

LONGEST = 2**28
"""Maximum size of a value [bytes]: larger than any supported image."""

STEPS = 10_000
"""Steps of SQLite's virtual machine between checks of the time limit (`TimeLimit.is_exceeded`)."""

DEFINITIONS = "SELECT ifnull(CAST(name AS TEXT), ''), CAST(sql AS TEXT) FROM sqlite_master WHERE sql IS NOT NULL"
"""Query for the argument of `check_plain`; it includes definitions stored as bytes."""

_SECONDS, _SECONDS_PER_BYTE = 3.0, 2e-8

# every view, virtual table, generated column or trigger is defined with one of these words
_COMPUTED = re.compile(r"\b(as|virtual|trigger)\b", re.IGNORECASE)


class TimeLimit:
    """Limit of the processor time of each statement on a file: three seconds, and more for a large file.

    Processor time, because an intact file may be on a slow disk. A damaged file whose pages refer to one another in a
    loop can keep SQLite busy forever.
    """

    def __init__(self, size: int) -> None:
        self._seconds = _SECONDS + _SECONDS_PER_BYTE * size
        self.begin()

    def begin(self, *_: object) -> bool:
        """Start the time of a statement in this thread; always return True."""
        self._began = time.thread_time()
        return True

    def is_exceeded(self) -> bool:
        """Whether the statement has exceeded its time."""
        return time.thread_time() - self._began > self._seconds


def check_plain(path: Path, schema: Iterable[tuple[str, str]]) -> list[str]:
    """Check that a file contains only plain tables with stored content; return the names of tables and indexes.

    Parameters
    ----------
    path : Path
        For the message.
    schema : iterable of (str, str)
        Result of `DEFINITIONS`: name and definition of each.

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
                "tables are supported: record or export it again."
            )
        names.append(name)
    return names
