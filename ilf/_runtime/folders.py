"""Folders of results on a disk or at an address, with the same few operations, none of which renames or appends."""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ..errors import ExportError, InputError, told_as
from .addresses import RemoteFiles, cache_folder
from .files import is_address, open_file
from .long_work import check_cancelled
from .writing import atomic_path, ensure_folder


class Folder:
    """A folder of files that are written once, on a disk.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    working : Path
        Folder on this machine for files that are not results yet.
    """

    def __init__(self, path: Path) -> None:
        self._root = self.working = path

    def __str__(self) -> str:
        """Its path or address."""
        return str(self._root)

    def sizes(self) -> dict[str, int]:
        """The names of the files with their sizes [bytes]; empty if there is no such folder."""
        found = {}
        with self._readable(""), suppress(FileNotFoundError), os.scandir(self._root) as entries:
            for entry in entries:
                with suppress(FileNotFoundError):  # a temporary file that another process has just moved
                    found[entry.name] = entry.stat().st_size
        return found

    def exists(self, name: str) -> bool:
        """Whether there is such a file; raises InputError if that cannot be known."""
        with self._readable(name), suppress(FileNotFoundError, NotADirectoryError):
            return not stat.S_ISDIR(os.stat(self._root / name).st_mode)
        return False

    def size(self, name: str) -> int:
        """The size of a file [bytes]; raises InputError if it cannot be read."""
        with self._readable(name):
            return (self._root / name).stat().st_size

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading; raises InputError if it cannot be read."""
        return open_file(self._root / name)

    def read(self, name: str) -> bytes:
        """Read a file; raises InputError if it cannot be read."""
        with self.open(name) as file:
            return file.read()

    def read_range(self, name: str, start: int, size: int) -> bytes:
        """Read a piece of a file; raises InputError if it cannot be read."""
        with self.open(name) as file, self._readable(name):
            file.seek(start)
            return file.read(size)

    def ends(self, sizes: dict[str, int], length: int) -> Iterator[tuple[str, bytes]]:
        """Yield the names of files of known sizes with their last bytes, at most `length`."""
        for name, size in sizes.items():
            start = max(size - length, 0)
            yield name, self.read_range(name, start, size - start)

    def sha256(self, name: str) -> str:
        """The SHA-256 of a file; raises InputError if it cannot be read."""
        with self.open(name) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()  # type: ignore[arg-type]

    def writing(self, name: str) -> AbstractContextManager[Path]:
        """Provide a file on this machine that becomes a file of the folder, once and whole, when the block ends without
        an error; raises ExportError if it cannot be written."""
        return atomic_path(ensure_folder(self._root) / name)

    def put(self, name: str, parts: Iterable[bytes]) -> None:
        """Write a file, once and whole; raises ExportError if that fails."""
        with self.writing(name) as path, open(path, "wb") as file:
            for part in parts:
                check_cancelled()
                file.write(part)

    def remove(self, name: str) -> None:
        """Remove a file; raises ExportError if that fails."""
        with told_as(ExportError, f"{self._root / name} cannot be removed ({{error}}).", OSError):
            (self._root / name).unlink()

    def forget_working(self) -> None:
        """Remove what waits on this machine for a folder at an address that no longer exists, before it is begun
        anew."""

    def _readable(self, name: str) -> AbstractContextManager[None]:
        """Within the block, an OSError says that a file cannot be read."""
        return told_as(InputError, f"{self._root / name}: cannot be read ({{error}}). Check the folder.", OSError)


_AT_ONCE = 64
"""Number of files of an address that are read at the same time."""

_DIGITS = 16


class RemoteFolder(RemoteFiles, Folder):
    """A folder at an address. A file is written on this machine first, in the cache, and then put there."""

    def __init__(self, address: str) -> None:
        super().__init__(address)
        digest = hashlib.sha256(self.address.encode()).hexdigest()[:_DIGITS]
        self.working = cache_folder() / "shards" / digest

    def __str__(self) -> str:
        return self.address

    def read_range(self, name: str, start: int, size: int) -> bytes:
        return self.read_ranges([name], [start], [start + size])[0]

    def ends(self, sizes: dict[str, int], length: int) -> Iterator[tuple[str, bytes]]:
        names = list(sizes)
        for first in range(0, len(names), _AT_ONCE):
            check_cancelled()
            own: Sequence[str] = names[first : first + _AT_ONCE]
            ends = [sizes[name] for name in own]
            yield from zip(own, self.read_ranges(own, [max(end - length, 0) for end in ends], ends), strict=True)

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        staged = ensure_folder(self.working) / name
        try:
            with atomic_path(staged) as path:
                yield path
            check_cancelled()
            self.upload(staged, name)
        finally:
            staged.unlink(missing_ok=True)

    def forget_working(self) -> None:
        shutil.rmtree(self.working, ignore_errors=True)


def folder_at(path: str | os.PathLike[str]) -> Folder:
    """The folder at a path or an address.

    Raises
    ------
    InputError
        If the address is not valid, or its driver is not installed.
    """
    return RemoteFolder(path) if is_address(path) else Folder(Path(path).absolute())
