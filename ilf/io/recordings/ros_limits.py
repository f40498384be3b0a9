"""What opening a recording of ROS may take: rosbags itself takes whatever a file asks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import FormatError
from ...extras import optional
from ..sqlite_files import DEFINITIONS, LONGEST, STEPS, Allowance, check_plain

METADATA = "metadata.yaml"
MOST_TOPICS = 4000
MOST_SETTINGS = 2**21
"""Bytes of text about the topics, which rosbags takes some 20 s for each megabyte of."""
MOST_DEFINITIONS = 2**23
"""The same of the definitions of their messages, of each topic anew: some 4 s for each megabyte."""

_LISTS = {"topics": MOST_SETTINGS, "message_definitions": MOST_DEFINITIONS}
"""Tables of an SQLite file that rosbags reads as a whole, and how much text they may have [bytes]."""


@contextmanager
def limited(path: Path, reader: Any) -> Iterator[None]:
    """Hold the opening of a recording by rosbags to what a sound one needs, and what is then read of its SQLite files.

    Parameters
    ----------
    path : Path
        Of the recording, for messages.
    reader : AnyReader
        What opens it, not open yet.

    Raises
    ------
    FormatError
        If there are too many topics, too long texts about them, or an SQLite file that `check_plain` refuses.
    """
    apsw = optional("apsw", "sequences", "A ROS bag")

    def guard(connection: Any) -> None:
        allowance = Allowance(Path(connection.filename).stat().st_size)

        def is_over() -> bool:
            if allowance.is_spent():
                raise FormatError(f"{path} is damaged: reading it takes too long. Copy or export it again.")
            return False

        connection.limit(apsw.SQLITE_LIMIT_LENGTH, LONGEST)
        connection.set_exec_trace(allowance.begin)
        connection.set_progress_handler(is_over, STEPS)
        for name in check_plain(path, connection.execute(DEFINITIONS)):
            if (most := _LISTS.get(name.lower())) is not None:
                _check_list(path, connection.execute(f"SELECT * FROM {name} LIMIT {MOST_TOPICS + 1}"), most)

    if path.is_dir():
        _check(path, 0, (path / METADATA).stat().st_size, MOST_SETTINGS)
    for one in reader.readers:
        _check_when_open(path, one)
    apsw.connection_hooks.append(guard)
    try:
        yield
    finally:
        apsw.connection_hooks.remove(guard)


def _check_list(path: Path, rows: Iterator[Sequence[object]], most: int) -> None:
    """The rows of one of `_LISTS`."""
    count = size = 0
    for count, row in enumerate(rows, 1):
        size += sum(len(value) for value in row if isinstance(value, str | bytes))
        _check(path, count, size, most)


def _check_when_open(path: Path, reader: Any) -> None:
    """Check a reader's topics once it has opened its file, before all their definitions are read."""
    open_file = reader.open

    def open_and_check() -> None:
        open_file()
        size = sum(len(one.msgdef.data) for one in reader.connections)
        try:
            _check(path, len(reader.connections), size, MOST_DEFINITIONS)
        except FormatError:
            reader.close()
            raise

    reader.open = open_and_check


def _check(path: Path, count: int, size: int, most: int) -> None:
    if count > MOST_TOPICS:
        raise FormatError(f"{path} has more than {MOST_TOPICS} topics. Record the ones of the camera alone.")
    if size > most:
        raise FormatError(
            f"{path} has more than {most / 2**20:g} MiB of text about its topics. Record the ones of the camera alone."
        )
