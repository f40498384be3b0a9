"""MCAP files of ROS 2 that are readable after every write, whatever ends the program."""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Self

from ..errors import ExportError, cause

_MAGIC = b"\x89MCAP0\r\n"
_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F


class McapMessage(NamedTuple):
    """A message.

    Attributes
    ----------
    topic : str
    kind : str
        Its type, such as "sensor_msgs/msg/Image".
    definition : str
        The definition of its type, as in ROS 2 recordings.
    data : bytes
        Serialised as CDR.
    """

    topic: str
    kind: str
    definition: str
    data: bytes


def _record(code: int, content: bytes) -> bytes:
    return struct.pack("<BQ", code, len(content)) + content


def _text(text: str) -> bytes:
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


_END = _record(_DATA_END, bytes(4)) + _record(_FOOTER, bytes(20)) + _MAGIC
"""The end of a file without summary: readers scan the chunks."""


class McapFile:
    """Writes messages into an MCAP file, one chunk per call of `write`, followed by the end of the file, which the next
    chunk replaces: the file is complete between any two calls.

    Parameters
    ----------
    path : path-like
        It must not exist.

    Raises
    ------
    ExportError
        If the file exists or cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        start = _MAGIC + _record(_HEADER, _text("ros2") + _text("ilf"))
        self._end = len(start)
        try:
            self._file = open(self.path, "xb", buffering=0)  # noqa: SIM115 - closed by `close`
            self._write_at(0, start + _END)
        except FileExistsError as error:
            raise ExportError(f"{self.path} already exists. Choose another name.") from error
        except OSError as error:
            raise ExportError(f"{self.path} could not be written: {cause(error)}.") from error

    def write(self, stamp: int, messages: Sequence[McapMessage]) -> None:
        """Write the messages of one moment [ns]; all of them or, after an error, none.

        Raises
        ------
        ExportError
            If they cannot be written, for example on a full disk; the file then ends with the messages before.
        """
        schemas, channels, records = dict(self._schemas), dict(self._channels), []
        for message in messages:
            if message.kind not in schemas:
                schemas[message.kind] = len(schemas) + 1
                content = struct.pack("<H", schemas[message.kind]) + _text(message.kind) + _text("ros2msg")
                records.append(_record(_SCHEMA, content + _text(message.definition)))
            if message.topic not in channels:
                channels[message.topic] = len(channels) + 1
                content = struct.pack("<HH", channels[message.topic], schemas[message.kind]) + _text(message.topic)
                records.append(_record(_CHANNEL, content + _text("cdr") + struct.pack("<I", 0)))
            head = struct.pack("<HIQQ", channels[message.topic], 0, stamp, stamp)
            records.append(_record(_MESSAGE, head + message.data))
        content = b"".join(records)
        about = struct.pack("<QQQI", stamp, stamp, len(content), 0) + _text("") + struct.pack("<Q", len(content))
        chunk = _record(_CHUNK, about + content)
        try:
            self._write_at(self._end, chunk + _END)
        except OSError as error:
            self._file.truncate(self._end)
            self._write_at(self._end, _END)  # there is room: it was there before
            raise ExportError(
                f"{self.path} could not be written: {cause(error)}. It contains the frames up to here."
            ) from error
        self._end += len(chunk)
        self._schemas, self._channels = schemas, channels

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write_at(self, place: int, content: bytes) -> None:
        self._file.seek(place)
        left = memoryview(content)
        while left:
            left = left[self._file.write(left) :]
