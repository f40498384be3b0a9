"""Writing a file as a whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import ExportError, cause
from ..stopping import check_stopped
from ..unfinished import moving, unfinished
from .left_over import clear_left_files, made_by

_WAYS_OUT = {
    errno.ENOENT: "the folder does not exist. Create it first",
    errno.ENOTDIR: "the folder does not exist. Create it first",
    errno.EACCES: "writing is not permitted there. Choose another folder",
    errno.EPERM: "writing is not permitted there. Choose another folder",
    errno.EROFS: "the folder is read-only. Choose another folder",
    errno.ENOSPC: "the disk is full. Free some space or choose another folder",
    errno.EDQUOT: "the disk quota is used up. Free some space or choose another folder",
    errno.EEXIST: "there is a file of that name in the way. Move it, or choose another folder",
    errno.EFBIG: "the file would be too large for its drive or a limit (ulimit -f). Choose another folder",
    errno.ELOOP: "symbolic links lead in a circle. Choose another folder",
    errno.ENAMETOOLONG: "the name is too long. Choose a shorter one",
    errno.EISDIR: "there is a folder of that name. Choose another name",
}


def way_out(error: OSError) -> str:
    """Why a file could not be written, and what to do about it."""
    return _WAYS_OUT.get(error.errno or 0) or cause(error)


@contextmanager
def atomic_path(target: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `target` that takes its place when the block ends without an error.

    The temporary file exists (empty) when the block starts, has the suffix of `target`, and is gone
    afterwards. What the block wrote is on the disk before it replaces what was there.

    Raises
    ------
    ExportError
        For every OSError, in the block or here: missing or read-only folder, full disk. A file that was there
        before is as it was.
    Cancelled
        If the work was to stop before the file was whole; likewise.

    Examples
    --------
    >>> with atomic_path("notes.txt") as temporary:
    ...     _ = temporary.write_text("all or nothing")
    >>> Path("notes.txt").read_text()
    'all or nothing'
    """
    final = Path(target).absolute()
    temporary = final.with_name(f".ilf-{made_by()}{final.suffix}")
    try:
        with unfinished(temporary):
            temporary.touch(exist_ok=False)
            clear_left_files(temporary)
            try:
                yield temporary
                with open(temporary, "rb+") as written:
                    os.fsync(written.fileno())
                with moving():
                    os.replace(temporary, final)
            finally:
                temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ExportError(f"Could not write {target}: {way_out(error)}.") from error


def write_bytes(target: str | os.PathLike[str], content: bytes) -> None:
    """Write a whole file atomically; raises ExportError as `atomic_path` does."""
    with atomic_path(target) as temporary:
        temporary.write_bytes(content)


def write_parts(target: str | os.PathLike[str], parts: Iterable[bytes]) -> None:
    """The same of a file that comes in parts, one after the other, and is never held as a whole."""
    with atomic_path(target) as temporary, open(temporary, "wb") as file:
        for part in parts:
            check_stopped()
            file.write(part)
