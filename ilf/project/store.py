"""The autosave of a window: a folder with the parts of a project as files, which survives a crash of the program."""

from __future__ import annotations

import json
import os
import shutil
import socket
import threading
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from zlib import crc32

from filelock import FileLock, Timeout

from .._runtime.files import parse_json, read_file
from .._runtime.installation import __version__
from .._runtime.schema import PlainName, check_schema, converted
from .._runtime.writing import remedy, restrict_to_owner, write_bytes
from ..errors import ExportError, FormatError, InputError

SCHEMA = 1
_INDEX = "index.json"
_LOCK = "lock"


class FolderInUse(InputError):
    """The folder is in use by another window."""


@dataclass(frozen=True)
class WorkHeader:
    """Origin and times of the work in a folder.

    Attributes
    ----------
    project : str
        Path of the project file; "" if there is none yet.
    unsaved : bool
        Whether the folder contains work that the project file does not.
    frames : tuple of str
        Ids of the frames with such work.
    host : str
        Name of the machine that the window runs on.
    changed : datetime
        Time of the last commit.
    """

    project: str = ""
    unsaved: bool = True
    frames: tuple[str, ...] = ()
    host: str = field(default_factory=socket.gethostname)
    changed: datetime = field(default_factory=partial(datetime.now, UTC))


@dataclass(frozen=True)
class _Index:
    """The file that names all others: written last, so that everything before it stays whole until then."""

    schema: int
    header: WorkHeader
    parts: dict[str, tuple[PlainName, int]]
    """Name of a part -> its file, and the CRC-32 of its content."""


class WorkFolder:
    """A window's folder with the parts of a project, each a file that is never changed; commits are atomic.

    The folder is locked while it is open; the lock ends with the process. Thread-safe.

    Parameters
    ----------
    path : path-like
        Created with its folders if missing. Only the user may read it.

    Raises
    ------
    FolderInUse
        If another window, of this process or another, has it open.
    InputError
        If its index is damaged, or has another schema.
    ExportError
        If it cannot be created or locked.

    Examples
    --------
    >>> folder = WorkFolder("work")
    >>> folder.commit({"frames/1.json": b"{}", "arrays/2.zip": b"..."})
    >>> folder.commit({"frames/1.json": b"[]"}, drop=["arrays/2.zip"])
    >>> sorted(folder.names()), folder.read("frames/1.json")
    (['frames/1.json'], b'[]')
    >>> folder.discard()
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        self.header = WorkHeader()
        self._parts: dict[str, tuple[str, int]] = {}
        self._guard = threading.RLock()
        self._file_lock = FileLock(self.path / _LOCK, timeout=0, thread_local=False)
        try:
            self.path.mkdir(0o700, parents=True, exist_ok=True)
            restrict_to_owner(self.path)
            self._file_lock.acquire()
            self._place = _identity(self.path)
        except Timeout as error:
            raise FolderInUse(f"Another window is using {self.path}.") from error
        except OSError as error:
            raise ExportError(f"Could not write {self.path}: {remedy(error)}.") from error
        try:
            if (self.path / _INDEX).exists():
                self._read_index()
            self._remove_unnamed()
        except BaseException:
            self.close()
            raise

    def _read_index(self) -> None:
        data = parse_json(read_file(self.path / _INDEX).data.tobytes(), self.path / _INDEX)
        if not isinstance(data, dict):
            raise FormatError(f"{self.path / _INDEX} is damaged.")
        check_schema(data, SCHEMA, f"autosave {self.path}")
        index = converted(data, _Index, "autosave")
        self.header, self._parts = index.header, dict(index.parts)

    def _remove_unnamed(self) -> None:
        """Remove the files of a commit that was not completed."""
        named = {file for file, _ in self._parts.values()} | {_INDEX, _LOCK}
        with suppress(OSError):
            for file in os.listdir(self.path):
                if file not in named:
                    (self.path / file).unlink()

    @property
    def is_there(self) -> bool:
        """Whether the path still leads to the open folder."""
        try:
            return _identity(self.path) == self._place and (self.path / _LOCK).exists()
        except OSError:
            return False

    def names(self) -> Collection[str]:
        """Return the names of all parts, as of now."""
        return self._parts.keys()  # the dict is replaced, not changed

    def read(self, name: str) -> bytes:
        """Read the bytes of a part; raises InputError if there is no such part, FormatError if it is damaged."""
        with self._guard:
            if name not in self._parts:
                raise InputError(f"{self.path} has no part {name:.40}.")
            file, checksum = self._parts[name]
            content = read_file(self.path / file).data.tobytes()
        if crc32(content) != checksum:
            raise FormatError(f"The part {name:.40} of {self.path} is damaged.")
        return content

    def commit(self, put: Mapping[str, bytes], drop: Collection[str] = (), header: WorkHeader | None = None) -> None:
        """Store and remove parts and update the header: all of it, or nothing if the program ends before.

        Raises
        ------
        ExportError
            If the folder cannot be written; its content is then unchanged.
        """
        if not self.is_there:
            raise ExportError(f"{self.path} no longer exists: it was moved or deleted, or its drive was removed.")
        header = replace(self.header if header is None else header, changed=datetime.now(UTC))
        new = {name: (_file_name(name), crc32(content)) for name, content in put.items()}
        kept = {name: stored for name, stored in self._parts.items() if name not in {*drop} - put.keys()}
        index = asdict(_Index(SCHEMA, header, kept | new)) | {"version": __version__}
        try:
            for name, content in put.items():
                write_bytes(self.path / new[name][0], content)
            write_bytes(self.path / _INDEX, json.dumps(index, default=datetime.isoformat).encode())
        except ExportError:
            self._remove_unnamed()
            raise
        with self._guard:
            former, self._parts, self.header = self._parts, kept | new, header
        for file in {file for file, _ in former.values()} - {file for file, _ in self._parts.values()}:
            with suppress(OSError):
                (self.path / file).unlink()

    def close(self) -> None:
        """Release the lock."""
        self._file_lock.release()

    def discard(self) -> None:
        """Close and delete the folder."""
        there = self.is_there
        if there:
            (self.path / _INDEX).unlink(missing_ok=True)
        self.close()
        if there:
            shutil.rmtree(self.path)


def _file_name(name: str) -> str:
    """Return a new name for the file of a part: that of its content for arrays, which never change."""
    stem, suffix = os.path.splitext(name.rpartition("/")[2])
    return f"{stem}{suffix}" if name.startswith("arrays/") else f"{stem}-{os.urandom(4).hex()}{suffix}"


def _identity(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_dev, status.st_ino


def lock_of(path: Path, folder: Path) -> FileLock | None:
    """Lock a project file for this window, by a file in a folder of the user; None if another window has it."""
    lock = FileLock(folder / f"{crc32(os.fsencode(os.path.realpath(path))):08x}.lock", timeout=0, thread_local=False)
    try:
        folder.mkdir(0o700, parents=True, exist_ok=True)
        lock.acquire()
    except Timeout:
        return None
    except OSError:  # without locks, a file that has changed is noticed when it is saved
        pass
    return lock
