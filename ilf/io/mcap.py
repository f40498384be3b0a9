"""MCAP files of ROS 2: written so that they are readable after every write, and read without their end."""

from __future__ import annotations

import io
import os
import struct
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from .._runtime.cancellation import check_cancelled
from .._runtime.closing import Closeable
from .._runtime.files import open_file
from .._runtime.installation import optional
from ..errors import ExportError, cause

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _DATA_END = 0x02, 0x0F


def _record(code: int, content: bytes) -> bytes:
    return struct.pack("<BQ", code, len(content)) + content


_FOOTER_AND_MAGIC = _record(_FOOTER, bytes(20)) + _MAGIC
_END = _record(_DATA_END, bytes(4)) + _FOOTER_AND_MAGIC
"""The end of a file without summary: readers scan the chunks."""


class McapFile(Closeable):
    """Writes messages into an MCAP file, one chunk per moment, followed by the end of the file, which the next chunk
    replaces: the file is complete between any two moments.

    Parameters
    ----------
    path : path-like
        It must not exist.

    Raises
    ------
    ExportError
        If the file exists or cannot be written.
    InputError
        If the package mcap is not installed (extra `sensors`).
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        writer = optional("mcap.writer", "ilf-studio[sensors]", "Writing an MCAP file")
        self.path = Path(path)
        self._content = io.BytesIO()
        self._writer = writer.Writer(
            self._content,
            chunk_size=sys.maxsize,
            compression=writer.CompressionType.NONE,
            index_types=writer.IndexType.NONE,
            repeat_channels=False,
            repeat_schemas=False,
            use_statistics=False,
            use_summary_offsets=False,
            enable_crcs=False,
        )
        self._writer.start("ros2", "ilf")
        self._channels: dict[str, int] = {}
        self._end = 0
        try:
            self._file = open(self.path, "xb", buffering=0)  # noqa: SIM115 - closed by `close`
            self.finish_moment()
        except FileExistsError as error:
            raise ExportError(f"{self.path} already exists. Choose another name.") from error
        except OSError as error:
            raise ExportError(f"{self.path} could not be written: {cause(error)}.") from error

    def add(self, topic: str, kind: str, definition: str, data: bytes, stamp: int) -> None:
        """Add a message of this moment: its type, the definition of that, and its content in CDR."""
        if topic not in self._channels:
            schema = self._writer.register_schema(kind, "ros2msg", definition.encode())
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
        self._writer.add_message(self._channels[topic], stamp, data, stamp)

    def finish_moment(self) -> None:
        """Write the messages that were added; all of them or, after an error, none, and no more afterwards.

        Raises
        ------
        ExportError
            If they cannot be written, for example on a full disk; the file then ends with the messages before.
        """
        self._writer.flush()
        size = self._content.tell()
        self._writer.finish()
        try:
            self._write_at(self._end, self._content.getvalue())
        except OSError as error:
            self._file.truncate(self._end)
            if self._end:
                self._write_at(self._end, _END)  # there is room: it was there before
            self._file.close()
            raise ExportError(f"{self.path} could not be written: {cause(error)}. It has the frames so far.") from error
        self._end += size
        self._content.seek(0)
        self._content.truncate()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write_at(self, place: int, content: bytes) -> None:
        self._file.seek(place)
        left = memoryview(content)
        while left:
            left = left[self._file.write(left) :]


# Reading a file whose writer was killed or had no more room, so that its end is missing.

_HEAD = struct.Struct("<BQ")
"""Kind of a record and length of its content [bytes]."""


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
    """The path of an MCAP file without its end, for `rosbags`: it opens its whole records, followed by an end.

    Parameters
    ----------
    path : Path
    whole : int
        Size [bytes] of its whole records, from `whole_size`.
    """

    def __init__(self, path: Path, whole: int) -> None:
        self._path, self._whole = path, whole
        self.suffix = path.suffix

    def __str__(self) -> str:
        return str(self._path)

    def exists(self) -> bool:
        """Whether the file exists."""
        return self._path.exists()

    def is_dir(self) -> bool:
        """False: it is a file."""
        return False

    def open(self, _mode: str) -> io.BufferedReader:
        """Open it for reading bytes."""
        return io.BufferedReader(_Ended(self._path, self._whole))


class _Ended(io.RawIOBase):
    """The first bytes of a file, followed by the end of an MCAP file."""

    def __init__(self, path: Path, whole: int) -> None:
        self._file = open_file(path)
        self._whole, self._place = whole, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        starts = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._whole + len(_END)}
        self._place = starts[whence] + offset
        return self._place

    def readinto(self, buffer: WriteableBuffer) -> int:
        target = memoryview(buffer).cast("B")
        beyond = self._place - self._whole
        if beyond < 0:
            self._file.seek(self._place)
            found = self._file.read(min(len(target), -beyond)) or b""
        else:
            found = _END[beyond : beyond + len(target)]
        target[: len(found)] = found
        self._place += len(found)
        return len(found)

    def close(self) -> None:
        self._file.close()
        super().close()
