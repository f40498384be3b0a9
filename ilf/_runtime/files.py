"""Reading whole files, with a clear message for everything that can be wrong with a path."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import stat
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

from ..errors import FormatError, InputError, cause, told_as

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MAX_FILE_BYTES = 2**30
"""Larger files cannot be frames of a supported size."""

_PIECE = 2**22
"""Number of bytes that are read before the limits are looked at again."""

_ADDRESS = re.compile(r"\s*(?:[A-Za-z][A-Za-z0-9+.-]*::)*[A-Za-z][A-Za-z0-9+.-]+://")

_WITH_NAME = re.compile(r"(.+\.(?:hdf5|h5|mat)):[/\\](.+)", re.IGNORECASE | re.DOTALL)

_before_reading: ContextVar[Callable[[Path], None] | None] = ContextVar("_before_reading", default=None)


@contextmanager
def reading_through(prepare: Callable[[Path], None]) -> Iterator[None]:
    """Within the block, call a function with the absolute path of each file before it is read by this module."""
    token = _before_reading.set(prepare)
    try:
        yield
    finally:
        _before_reading.reset(token)


def is_address(path: object) -> TypeGuard[str]:
    """Whether a path is an address, such as s3://bucket/folder, valid or not.

    Examples
    --------
    >>> is_address("s3://bucket/rgb"), is_address("zip::HTTP://host"), is_address("rgb"), is_address("C:/rgb")
    (True, True, False, False)
    """
    return isinstance(path, str) and _ADDRESS.match(path) is not None


def absolute(path: str) -> str:
    """The absolute path; an address is absolute."""
    return path if is_address(path) else os.path.abspath(path)


def split_dataset(path: str) -> tuple[str, str | None]:
    r"""A path or address without the dataset that it names behind a colon, and the name; None if it names none.

    Examples
    --------
    >>> split_dataset("C:/take.h5:/left/depth"), split_dataset("zip://depth.h5::/all.zip")
    (('C:/take.h5', '/left/depth'), ('zip://depth.h5::/all.zip', None))
    """
    found = _WITH_NAME.fullmatch(path)
    if found is None or os.path.lexists(path):
        return path, None
    return found[1], "/" + found[2].replace("\\", "/")  # as Windows' paths write it


def with_dataset(path: object, dataset: str | None) -> str:
    """A path with the name of its dataset, if it is known, as `split_dataset` takes it."""
    return f"{path}:/{dataset.lstrip('/')}" if dataset else str(path)


def existing_file(path: str | os.PathLike[str]) -> Path:
    """Return the absolute path of a regular file that exists, is not empty and is not implausibly large.

    Raises
    ------
    InputError
        If it is not.
    """
    with open_file(path) as file:
        _plausible_size(file)
        return Path(file.name)


def _plausible_size(file: LimitedReader) -> int:
    """Size of a file [bytes]; raises FormatError if it is empty or implausibly large."""
    size = os.fstat(file.fileno()).st_size
    if size == 0:
        raise FormatError(f"{file.name} is empty (0 bytes). Copy or export it again.")
    if size > MAX_FILE_BYTES:
        raise FormatError(f"{file.name} has {size / 2**30:.1f} GiB; at most 1 GiB is read. Is this the right file?")
    return size


def open_file(path: str | os.PathLike[str]) -> LimitedReader:
    """Open a regular file for reading. What cannot be a stranger's file is refused: a pipe, which would be waited for,
    and a device, which may have no end.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read.
    """
    try:
        found = Path(path).absolute()
        if prepare := _before_reading.get():
            prepare(found)
        if found.is_dir():
            raise InputError(f"{found} is a folder, not a file. Give the path of a file in it.")
        file = LimitedReader(io.FileIO(found, opener=_opened_without_waiting))
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(f"{os.path.abspath(path)}: there is no such file. Check the name.") from error
    except (OSError, ValueError) as error:
        raise InputError(f"{path!s:.200}: cannot be read ({cause(error)}). Check its name and permissions.") from error
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise InputError(f"{found} is a device or a pipe, not a file. Copy its content into a file first.")
    return file


def _opened_without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))  # there are no pipes in Windows' folders


class LimitedReader(io.BufferedReader):
    """A stream of any length, of which at most `MAX_FILE_BYTES` are read at a time; more is a FormatError."""

    def read(self, size: int | None = -1, /) -> bytes:
        wanted = -1 if size is None else size
        if wanted > MAX_FILE_BYTES:
            raise self._too_large()
        parts, left = [], wanted if wanted >= 0 else MAX_FILE_BYTES + 1
        while left and (part := self.read1(min(left, _PIECE))):
            parts.append(part)
            left -= len(part)
        if wanted < 0 and not left:
            raise self._too_large()
        return b"".join(parts)

    def _too_large(self) -> FormatError:
        return FormatError(f"{self.name} has more than {MAX_FILE_BYTES / 2**30:.3g} GiB. Is this the right file?")


@dataclass(frozen=True, eq=False)
class FileContent:
    """A file as it was when it was read.

    Attributes
    ----------
    path : Path
        Absolute.
    data : ndarray of uint8, shape (N,)
    """

    path: Path
    data: NDArray[np.uint8]

    @property
    def sha256(self) -> str:
        """SHA-256 of the content."""
        return hashlib.sha256(self.data.data).hexdigest()

    def __str__(self) -> str:
        return str(self.path)


FileSource = str | os.PathLike[str] | FileContent
"""A path, or the content read from one."""


def read_file(source: FileSource) -> FileContent:
    """Read the whole content of a file; return content that was read before unchanged.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read or is empty.
    """
    if isinstance(source, FileContent):
        return source
    import numpy as np  # not before: `ilf --version` and `ilf --help` import this file

    with open_file(source) as file:
        size = _plausible_size(file)
        with told_as(InputError, f"{file.name}: cannot be read ({{error}}). Check its permissions.", OSError):
            return FileContent(Path(file.name), np.fromfile(file, np.uint8, size))


def read_json(source: FileSource) -> Any:
    """Parse a JSON file, or the content of one that was read before.

    Raises
    ------
    InputError
        If the file does not exist or cannot be read.
    FormatError
        If it is not JSON.
    """
    content = read_file(source)
    return parse_json(content.data.tobytes(), content)


def parse_json(content: str | bytes, name: object, remedy: str = "Correct or re-export it.") -> Any:
    """Parse JSON, whatever a stranger has written into it.

    Parameters
    ----------
    content : str or bytes
    name : object
        What contains it, for messages.
    remedy : str
        What to do if it is damaged; a sentence.

    Raises
    ------
    FormatError
        If it is not JSON, or is nested too deeply.
    """
    with told_as(FormatError, f"{name} is not valid JSON ({{error}}). {remedy}", (ValueError, RecursionError)):
        return json.loads(content)


def file_sha256(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file's content, of any size; raise InputError if it cannot be read."""
    refused = told_as(InputError, f"{path}: cannot be read ({{error}}). Check its permissions.", OSError)
    with open_file(path) as stream, refused:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def zip_member(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, at_most: int) -> bytes:
    """Read a file of a zip, of which no more is unpacked than its entry states.

    Raises
    ------
    ValueError
        If it is larger than `at_most` bytes, or compressed by what unpacks everything at once; and other exceptions of
        `zipfile`.
    """
    if entry.file_size > at_most:
        raise ValueError(f"{entry.filename} is too large ({entry.file_size} bytes)")
    if entry.compress_type not in {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
        raise ValueError(f"{entry.filename} is compressed by another method than deflate")
    with archive.open(entry) as stream:
        return stream.read(entry.file_size + 1)
