"""The project file: a zip whose members are the parts, stored uncompressed since their content is compressed."""

from __future__ import annotations

import mmap
import os
import re
import stat
import struct
import threading
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol

from .._runtime.closing import Closeable
from .._runtime.files import open_file
from .._runtime.formatting import counted
from .._runtime.writing import atomic_path
from ..errors import FormatError, InputError, cause

MAX_INFLATED = 2**28
"""Maximum inflated size of a member that another program has compressed [bytes]."""

_PART = re.compile(r"project\.json|(?:frames|arrays|thumbnails|sources)/[\w.-]+")
_FIRST = "project.json"
_LOCAL = struct.Struct("<4s5H3L2H")
_DIRECTORY_ERRORS = (zipfile.BadZipFile, OSError, LookupError, RuntimeError, ValueError, struct.error)


@dataclass(frozen=True)
class Part:
    """A part to write. A checksum that does not match the content keeps the part marked as damaged."""

    name: str
    content: bytes
    checksum: int | None = None


@dataclass(frozen=True)
class _Member:
    """Offset of a member's local header, and its entry in the directory."""

    header: int
    size: int
    checksum: int
    packed: int
    method: int


class Archive(Closeable):
    """The parts of a project file, each read on demand. Thread-safe.

    Parameters
    ----------
    path : path-like

    Attributes
    ----------
    path : Path
        Absolute.
    problems : tuple of str
        Problems of the file as a whole, with the consequence; one sentence each.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read.
    FormatError
        If it is not a project file.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        self.problems: tuple[str, ...] = ()
        self._lock = threading.RLock()
        self._stream: BinaryIO | None = None
        self._members: dict[str, _Member] = {}
        self._identity: tuple[int, ...] = ()
        self._open()

    def close(self) -> None:
        """Close the file; parts can no longer be read."""
        with self._lock:
            if self._stream is not None:
                self._stream.close()
            self._stream = None

    def names(self) -> Collection[str]:
        """Return the names of all parts."""
        return self._members.keys()

    def read(self, name: str) -> bytes:
        """Read the bytes of a part.

        Raises
        ------
        InputError
            If there is no such part, or the file cannot be read.
        FormatError
            If the part is damaged.
        """
        part = self.read_raw(name)
        if part.checksum is not None:
            raise FormatError(f"The part {name:.40} of {self.path.name} is damaged: its checksum does not match.")
        return part.content

    def read_raw(self, name: str) -> Part:
        """Read a part for copying, with its checksum if it does not match; raises as `read` if it cannot be copied."""
        with self._lock:
            if name not in self._members:
                raise InputError(f"{self.path.name} has no part {name:.40}.")
            member = self._members[name]
            content = self._content(name, member)
        return Part(name, content, None if zlib.crc32(content) == member.checksum else member.checksum)

    def replaced(self) -> bool:
        """Return whether the opened file was replaced by another one."""
        try:
            return _identity(os.stat(self.path)) != self._identity
        except OSError:
            return True

    @contextmanager
    def closed_for_replacement(self) -> Iterator[None]:
        """Close the file while it is replaced, as some systems require, and reopen it afterwards."""
        with self._lock:
            self.close()
            try:
                yield
            finally:
                self._open()

    def _open(self) -> None:
        self._stream = stream = open_file(self.path)
        self._identity = _identity(os.fstat(stream.fileno()))
        self._members, self.problems = _read_directory(stream), ()
        if _FIRST not in self._members:
            self._members = _scan_members(stream)
            if not self._members:
                self.close()
                raise FormatError(f"{self.path} is not a project file, or none of its parts can be read.")
            self.problems = (
                f"{self.path.name} is damaged or truncated; {counted(len(self._members), 'part')} recovered.",
            )

    def _content(self, name: str, member: _Member) -> bytes:
        if self._stream is None:
            raise InputError(f"{self.path} is closed.")
        try:
            self._stream.seek(member.header)
            header = self._stream.read(_LOCAL.size)
            if len(header) < _LOCAL.size or not header.startswith(b"PK\3\4"):
                raise FormatError(f"The part {name:.40} of {self.path.name} is not at its listed position.")
            *_, name_length, extra_length = _LOCAL.unpack(header)
            start = member.header + _LOCAL.size + name_length + extra_length
            if start + member.packed > os.fstat(self._stream.fileno()).st_size:
                raise FormatError(f"The part {name:.40} of {self.path.name} is truncated.")
            self._stream.seek(start)
            packed = self._stream.read(member.packed)
        except (OSError, ValueError) as error:
            raise InputError(f"{self.path}: cannot be read ({cause(error)}).") from error
        if member.method == zipfile.ZIP_STORED:
            return packed
        if member.method != zipfile.ZIP_DEFLATED or member.size > MAX_INFLATED:
            raise FormatError(f"The part {name:.40} of {self.path.name} has an unsupported compression.")
        try:
            return zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, member.size + 1)
        except zlib.error as error:
            raise FormatError(f"The part {name:.40} of {self.path.name} is damaged ({error}).") from error


def write_archive(path: str | os.PathLike[str], parts: Iterable[Part], replacing: Collection[Archive] = ()) -> None:
    """Write a project file. If that fails, an existing file stays unchanged.

    A link is kept: its target is replaced. An existing file keeps its permissions.

    Parameters
    ----------
    path : path-like
    parts : iterable of Part
        Consumed one at a time. If it raises, an existing file stays unchanged.
    replacing : collection of Archive
        Archives that may have this file open; they reopen it afterwards.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    target = Path(os.path.realpath(path))
    with ExitStack() as released, atomic_path(target) as temporary:
        with zipfile.ZipFile(temporary, "w", zipfile.ZIP_STORED) as archive:
            for part in parts:
                archive.writestr(zipfile.ZipInfo(part.name), part.content)
                if part.checksum is not None:
                    archive.getinfo(part.name).CRC = part.checksum
        if target.exists():
            with suppress(OSError):  # not every file system has permissions
                os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
        for opened in replacing:
            if os.path.realpath(opened.path) == str(target):
                released.enter_context(opened.closed_for_replacement())


def _read_directory(stream: BinaryIO) -> dict[str, _Member]:
    """Read the members from the directory at the file's end; empty if it cannot be read. In a truncated file it may be
    the directory of a part, since parts can be zips themselves."""
    try:
        with zipfile.ZipFile(stream) as directory:
            return {
                entry.filename: _Member(
                    entry.header_offset, entry.file_size, entry.CRC, entry.compress_size, entry.compress_type
                )
                for entry in directory.infolist()
                if _PART.fullmatch(entry.filename)
            }
    except _DIRECTORY_ERRORS:
        return {}


def _scan_members(stream: BinaryIO) -> dict[str, _Member]:
    """Find the members by their local headers, for a file whose directory cannot be read."""
    try:
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _members_in(data)
    except (OSError, ValueError):  # raised for an empty file, too
        return {}


def _members_in(data: mmap.mmap) -> dict[str, _Member]:
    found: dict[str, _Member] = {}
    place = data.find(b"PK\3\4")
    while place >= 0:
        after = place + 4
        header = data[place : place + _LOCAL.size]
        if len(header) == _LOCAL.size:
            _, _, flags, method, _, _, checksum, packed, size, name_length, extra_length = _LOCAL.unpack(header)
            start = place + _LOCAL.size + name_length + extra_length
            name = data[place + _LOCAL.size : place + _LOCAL.size + name_length].decode("ascii", "replace")
            if _PART.fullmatch(name) and not flags & 8 and start + packed <= len(data):
                found.setdefault(name, _Member(place, size, checksum, packed, method))
                if data[start + packed : start + packed + 2] == b"PK":
                    after = start + packed
        place = data.find(b"PK\3\4", after)
    return found


def _identity(status: os.stat_result) -> tuple[int, ...]:
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


# Stores of a project's parts: bytes by name, in a project file or a journal.


class Parts(Protocol):
    """A store of bytes by name. Thread-safe."""

    def names(self) -> Collection[str]:
        """Return all names."""
        ...

    def read(self, name: str) -> bytes:
        """Read the bytes of a part.

        Raises
        ------
        InputError
            If there is no such part, or it cannot be read or is damaged.
        """
        ...
