"""Whole files in, with one clear message for everything that can be wrong with a path."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, InputError, cause

MAX_FILE_BYTES = 2**30
"""Larger files cannot be frames of a size that this library takes."""


def existing_file(path: str | os.PathLike[str]) -> Path:
    """The absolute path of a plain file that is there, is not empty and is not absurdly large.

    Raises
    ------
    InputError
        If it is not.
    """
    try:
        found = Path(path).absolute()
        if not found.exists():
            raise InputError(f"{found}: there is no such file. Check the name.")
        if found.is_dir():
            raise InputError(f"{found} is a folder, not a file. Name the file in it.")
        if not found.is_file():
            raise InputError(f"{found} is a device or a pipe, not a file. Copy its content into a file first.")
        size = found.stat().st_size
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path!s:.200}: cannot be read ({cause(error)}). Check the name and its permissions."
        ) from error
    if size == 0:
        raise FormatError(f"{found} is empty (0 bytes). Copy or export it again.")
    if size > MAX_FILE_BYTES:
        raise FormatError(f"{found} has {size / 2**30:.1f} GiB; at most 1 GiB is read. Is this the right file?")
    return found


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
"""A path, or what was read from one."""


def read_file(source: FileSource) -> FileContent:
    """The whole content of a file; of what was read already, that.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read, or it is empty.
    """
    if isinstance(source, FileContent):
        return source
    found = existing_file(source)
    try:
        return FileContent(found, np.fromfile(found, np.uint8))
    except OSError as error:
        raise InputError(f"{found}: cannot be read ({cause(error)}). Check its permissions.") from error


def read_json(source: FileSource) -> Any:
    """The content of a JSON file, or of one that was read already.

    Raises
    ------
    InputError
        If there is no such file or it cannot be read.
    FormatError
        If it is not JSON.
    """
    content = read_file(source)
    try:
        return json.loads(content.data.tobytes())
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{content} is not valid JSON ({error}). Correct or re-export it.") from error


def file_sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a file's content, of whatever size; raises InputError if it cannot be read."""
    try:
        with open(path, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({cause(error)}). Check its permissions.") from error
