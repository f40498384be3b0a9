"""MCAP files whose writer was killed or had no more room, so that their end is missing."""

from __future__ import annotations

import io
import os
import struct
from pathlib import Path
from typing import Any

from .._runtime.files import open_file
from .._runtime.long_work import check_cancelled

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _DATA_END = 0x02, 0x0F
_HEAD = struct.Struct("<BQ")
"""Kind of a record and length of its content [bytes]."""

_FOOTER_AND_MAGIC = _HEAD.pack(_FOOTER, 20) + bytes(20) + _MAGIC
END = _HEAD.pack(_DATA_END, 4) + bytes(4) + _FOOTER_AND_MAGIC
"""The end of a file without summary: readers scan the chunks."""


def whole_size(path: Path) -> int | None:
    """Return the size [bytes] of a file's whole records, if its end is missing; None if it has an end, or is no MCAP
    file. Raises OSError."""
    size = path.stat().st_size
    with open_file(path) as file:
        if file.read(len(_MAGIC)) != _MAGIC:
            return None
        file.seek(max(size - len(_FOOTER_AND_MAGIC), 0))
        end = file.read()
        ends = end.endswith(_MAGIC)
        if ends and end[: _HEAD.size] == _FOOTER_AND_MAGIC[: _HEAD.size] and end != _FOOTER_AND_MAGIC:
            return None  # it has a summary
        whole = len(_MAGIC)
        while True:
            check_cancelled()
            file.seek(whole)
            head = file.read(_HEAD.size)
            code, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, 0)
            if code in (0, _FOOTER, _DATA_END) or whole + _HEAD.size + length > size:
                # the start of a chunk may lie over an end that is longer
                return None if ends and code == _DATA_END else whole
            whole += _HEAD.size + length


class EndedMcap:
    """A path, for `rosbags`, that is opened as the whole records of an MCAP file, followed by an end.

    Parameters
    ----------
    path : Path
    whole : int
        Size [bytes] of its whole records, from `whole_size`.
    """

    def __init__(self, path: Path, whole: int) -> None:
        self._path, self._whole = path, whole

    def __getattr__(self, name: str) -> Any:
        return getattr(self._path, name)

    def __str__(self) -> str:
        return str(self._path)

    def open(self, _mode: str) -> _Ended:
        """Open it for reading bytes."""
        return _Ended(open_file(self._path), self._whole)


class _Ended:
    """The first bytes of a file, followed by the end of an MCAP file."""

    def __init__(self, file: io.BufferedReader, whole: int) -> None:
        self._file, self._whole, self._place = file, whole, 0
        self.close = file.close

    def tell(self) -> int:
        return self._place

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self._place = offset + (0, self._place, self._whole + len(END))[whence]
        return self._place

    def read(self, size: int = -1) -> bytes:
        start, stop = self._place, self._whole + len(END)
        stop = min(start + size, stop) if size >= 0 else stop
        self._file.seek(start)
        found = self._file.read(max(min(stop, self._whole) - start, 0))
        found += END[max(start - self._whole, 0) : max(stop - self._whole, 0)]
        self._place += len(found)
        return found
