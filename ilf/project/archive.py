"""The project file: a zip whose members are the parts, stored uncompressed since their content is compressed."""

from __future__ import annotations

import io
import os
import re
import stat
import struct
import threading
import weakref
import zipfile
import zlib
from collections.abc import Collection, Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol

from .._runtime.files import MAX_FILE_BYTES, open_file
from .._runtime.formatting import counted
from .._runtime.writing import atomic_path
from ..errors import FormatError, InputError, told_as

MAX_INFLATED = 2**28
"""Maximum inflated size of a member that another program has compressed [bytes]."""

_PART = re.compile(r"project\.json|(?:frames|arrays|thumbnails|sources)/[\w.-]+")
_FIRST = "project.json"
_LOCAL = struct.Struct("<4s5H3L2H")
_UNREADABLE = (zipfile.BadZipFile, OSError, LookupError, RuntimeError, ValueError, EOFError, struct.error, zlib.error)


@dataclass(frozen=True)
class StoredPart:
    """A part to write. A checksum that does not match the content keeps the part marked as damaged."""

    name: str
    content: bytes
    checksum: int | None = None


class Archive(AbstractContextManager["Archive"]):
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
        self._open()

    def _open(self) -> None:
        self._stream: BinaryIO = open_file(self.path)
        self._identity = file_identity(self._stream.fileno())
        self._members, self.problems = _members_of(self._stream), ()
        if _FIRST not in self._members:
            with self._stream as damaged:
                self._stream = _rescued(damaged)
            self._members = _members_of(self._stream)
            if not self._members:
                raise FormatError(f"{self.path} is not a project file, or none of its parts can be read.")
            count = counted(len(self._members), "part")
            self.problems = (f"{self.path.name} is damaged or truncated; {count} recovered.",)
        weakref.finalize(self, self._stream.close)  # one that nobody takes any more, as at the window's end

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; parts can no longer be read."""
        with self._lock:
            self._stream.close()

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

    def read_raw(self, name: str) -> StoredPart:
        """Read a part for copying, with its checksum if it does not match; raises as `read` if it cannot be copied."""
        with self._lock:
            if name not in self._members:
                raise InputError(f"{self.path.name} has no part {name:.40}.")
            member = self._members[name]
            packed = self._packed(name, member)
        content = self._inflated(name, member, packed)
        return StoredPart(name, content, None if zlib.crc32(content) == member.CRC else member.CRC)

    def _packed(self, name: str, member: zipfile.ZipInfo) -> bytes:
        """Read a member as it stands in the file: `zipfile` gives no content whose checksum does not match."""
        with told_as(InputError, f"{self.path}: cannot be read ({{error}}).", (OSError, ValueError)):
            self._stream.seek(member.header_offset)
            header = self._stream.read(_LOCAL.size)
            if len(header) < _LOCAL.size or not header.startswith(b"PK\3\4"):
                raise FormatError(f"The part {name:.40} of {self.path.name} is not at its listed position.")
            self._stream.seek(sum(_LOCAL.unpack(header)[-2:]), os.SEEK_CUR)
            packed = self._stream.read(min(member.compress_size, MAX_FILE_BYTES))
        if len(packed) < member.compress_size:
            raise FormatError(f"The part {name:.40} of {self.path.name} is truncated.")
        return packed

    def _inflated(self, name: str, member: zipfile.ZipInfo, packed: bytes) -> bytes:
        if member.compress_type == zipfile.ZIP_STORED:
            return packed
        if member.compress_type != zipfile.ZIP_DEFLATED or member.file_size > MAX_INFLATED:
            raise FormatError(f"The part {name:.40} of {self.path.name} has an unsupported compression.")
        with told_as(FormatError, f"The part {name:.40} of {self.path.name} is damaged ({{error}}).", zlib.error):
            return zlib.decompressobj(-zlib.MAX_WBITS).decompress(packed, member.file_size + 1)

    def replaced(self) -> bool:
        """Return whether the opened file was replaced by another one."""
        return file_identity(self.path) != self._identity

    @contextmanager
    def closed_for_replacement(self) -> Iterator[None]:
        """Close the file while it is replaced, as some systems require, and reopen it afterwards."""
        with self._lock:
            self.close()
            try:
                yield
            finally:
                self._open()


def write_archive(
    path: str | os.PathLike[str], parts: Iterable[StoredPart], replacing: Collection[Archive] = ()
) -> None:
    """Write a project file. If that fails, an existing file stays unchanged.

    A link is kept: its target is replaced. An existing file keeps its permissions.

    Parameters
    ----------
    path : path-like
    parts : iterable of StoredPart
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


def _members_of(stream: BinaryIO) -> dict[str, zipfile.ZipInfo]:
    """Read the members from the directory at the file's end; empty if it cannot be read. In a truncated file it may be
    the directory of a part, since parts are zips themselves."""
    try:
        with zipfile.ZipFile(stream) as directory:
            return {entry.filename: entry for entry in directory.infolist() if _PART.fullmatch(entry.filename)}
    except _UNREADABLE:
        return {}


def _rescued(stream: BinaryIO) -> io.BytesIO:
    """Copy the whole members of a file whose directory cannot be read; they are found by their local headers."""
    stream.seek(0)
    data, found = stream.read(), io.BytesIO()
    with zipfile.ZipFile(found, "w", zipfile.ZIP_STORED) as archive:
        for match in re.finditer(rb"PK\x03\x04.{26}", data, re.DOTALL):
            checksum, packed, _, name_length, extra_length = _LOCAL.unpack(match[0])[-5:]
            name = data[match.end() : match.end() + name_length].decode("ascii", "replace")
            start = match.end() + name_length + extra_length
            content = data[start : start + packed]
            if _PART.fullmatch(name) and zlib.crc32(content) == checksum and name not in archive.NameToInfo:
                archive.writestr(name, content)
    return found


def file_identity(file: Path | int) -> tuple[int, ...] | None:
    """Return what changes as another program replaces a file, given by path or descriptor; None if there is none."""
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


# Stores of a project's parts: bytes by name, in a project file or an autosave.


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
