"""Writing files and sets of files: whole or not at all, however the process ends.

A file is written under a temporary name beside its place and then renamed. A set is written into a temporary folder in
its target; the files that it replaces are put aside there, and the new ones renamed, the last of them, its seal, at the
end. What is not finished when the process ends is removed by it; what a killed process has left, by the next that
writes there.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import socket
import stat
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import ExportError, cause, told_as
from .long_work import check_cancelled

_MOVE_TIMEOUT_S = 5.0
"""Moving files within a folder takes milliseconds; a disk that does not respond is given up after this time [s]."""

_paths: dict[Path, tuple[Path, ...]] = {}
_moving = threading.Lock()


@contextmanager
def removed_on_exit(path: Path, *new_folders: Path) -> Iterator[None]:
    """Register a temporary file or folder for the duration of the block, to be removed if the process ends.

    Parameters
    ----------
    path : Path
    *new_folders : Path
        Folders that did not exist before, innermost first; they are removed, too, if they are empty.
    """
    _paths[path] = new_folders
    try:
        yield
    finally:
        _paths.pop(path, None)


@contextmanager
def moving_into_place() -> Iterator[None]:
    """Enclose the moving of files into their final places, which cannot be cancelled any more.

    Raises
    ------
    Cancelled
        If the work was cancelled: then nothing has been moved.
    """
    with _moving:
        check_cancelled()
        yield


def remove_temporary_files() -> None:
    """Clean up before the process ends, whatever its threads are doing: wait for files being moved, and remove all
    other files being written. No files can be moved afterwards."""
    _moving.acquire(timeout=_MOVE_TIMEOUT_S)
    for path, folders in list(_paths.items()):
        remove(path)
        remove_empty(folders)


def remove(path: Path) -> None:
    """Remove a file or a folder as far as possible."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()


def remove_empty(folders: tuple[Path, ...]) -> None:
    """Remove those folders that exist and are empty, one after the other."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()


# What killed processes have left.

_DAY_S = 24 * 3600.0


def temporary_name(prefix: str, suffix: str = "") -> str:
    """Return a new name of a temporary file or folder, with the computer and the process that create it."""
    return f"{prefix}{_computer()}-{os.getpid()}-{secrets.token_hex(4)}{suffix}"


def left_in(folder: Path, prefix: str, seconds: float = _DAY_S) -> list[Path]:
    """Return temporary files or folders of this user that were left in a folder: their process was on this computer and
    has ended, or they have been unchanged for so long [s]."""
    named = re.compile(rf"{re.escape(prefix)}(?P<computer>[^-]+)-(?P<process>\d+)-[0-9a-f]{{8}}(\..*)?")
    found = []
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if (name := named.fullmatch(entry.name)) is not None:
                with suppress(OSError):  # another program has removed it first
                    status = entry.stat(follow_symlinks=False)
                    has_ended = name["computer"] == _computer() and not _is_running(int(name["process"]))
                    is_own = not hasattr(os, "geteuid") or status.st_uid == os.geteuid()
                    if is_own and not entry.is_symlink() and (has_ended or time.time() - status.st_mtime > seconds):
                        found.append(Path(entry))
    return sorted(found)


def _computer() -> str:
    return re.sub(r"[^A-Za-z0-9.]+", "_", socket.gethostname()) or "host"


def _is_running(process: int) -> bool:
    if process >= 2**31:  # no valid process number
        return False
    if os.name == "nt":
        import ctypes

        handle = ctypes.windll.kernel32.OpenProcess(0x1000, False, process)  # type: ignore[attr-defined]
        if handle:
            ctypes.windll.kernel32.CloseHandle(handle)  # type: ignore[attr-defined]
        return bool(handle)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


# One file.

_FILE = ".ilf-"
_REMEDIES = {
    errno.EEXIST: "Move the file of that name, or choose another folder",
    errno.EFBIG: "Choose another folder, or raise the limit",
    errno.EISDIR: "Choose another name",
    errno.ENAMETOOLONG: "Choose a shorter one",
    errno.ENXIO: "Give the name of a file",
}
_cleared: set[Path] = set()
"""Folders in which this process has removed what others have left."""


def remedy(error: OSError) -> str:
    """Describe why a file could not be written, and what to do about it."""
    usual = "Check the folder and the space there, or choose another one"
    return f"{cause(error)}. {_REMEDIES.get(error.errno or 0, usual)}"


@contextmanager
def atomic_path(target: str | os.PathLike[str]) -> Iterator[Path]:
    """Provide a temporary path beside `target` that replaces it when the block ends without an error.

    The temporary file exists (empty) when the block starts, has the suffix of `target`, and is removed
    afterwards. Its content is on the disk before it replaces the old file.

    Raises
    ------
    ExportError
        For every OSError, in the block or here: missing or read-only folder, write-protected file, full disk. An
        existing file is unchanged.
    Cancelled
        If the work was cancelled before the file was complete; likewise.

    Examples
    --------
    >>> with atomic_path("notes.txt") as temporary:
    ...     _ = temporary.write_text("all or nothing")
    >>> Path("notes.txt").read_text()
    'all or nothing'
    """
    final = Path(target).absolute()
    temporary = final.with_name(temporary_name(_FILE, final.suffix))
    try:
        _check_not_protected(final)
        with removed_on_exit(temporary):
            temporary.touch(exist_ok=False)
            if final.parent not in _cleared:
                _cleared.add(final.parent)
                for left in left_in(final.parent, _FILE):
                    if left.is_file():
                        left.unlink(missing_ok=True)
            try:
                yield temporary
                with open(temporary, "rb+") as written:
                    os.fsync(written.fileno())
                with moving_into_place():
                    os.replace(temporary, final)
            finally:
                temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ExportError(f"Could not write {target}: {remedy(error)}.") from error


def _check_not_protected(path: Path) -> None:
    """Raise OSError for a file that may not be written, though its folder would let it be replaced, and for a device or
    a pipe: /dev/stdout may lead to a file, but is none."""
    if path.parent == Path("/dev") or (path.exists() and not path.is_file() and not path.is_dir()):
        raise OSError(errno.ENXIO, f"{path.name} is a device or a pipe, not a file")
    if path.is_file() and not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, f"{path.name} is write-protected")


def write_bytes(target: str | os.PathLike[str], content: bytes) -> None:
    """Write a whole file atomically; raise ExportError as `atomic_path` does."""
    with atomic_path(target) as temporary:
        temporary.write_bytes(content)


def write_parts(target: str | os.PathLike[str], parts: Iterable[bytes]) -> None:
    """Write a file atomically, part by part, without holding all of it in memory."""
    with atomic_path(target) as temporary, open(temporary, "wb") as file:
        for part in parts:
            check_cancelled()
            file.write(part)


def check_writable(folder: str | Path) -> None:
    """Raise ExportError, before long work, if nothing can be written into a folder, or where it is to be created."""
    path = Path(folder).absolute()
    there = next((place for place in (path, *path.parents) if os.path.exists(place)), path)  # a drive may be missing
    if os.path.exists(there) and not os.path.isdir(there):
        raise ExportError(f"{there} is a file, not a folder. Choose another folder.")
    try:
        tempfile.TemporaryFile(dir=there).close()
    except OSError as error:
        raise ExportError(f"Nothing can be written into {there}: {remedy(error)}.") from error


def ensure_folder(folder: str | Path) -> Path:
    """Return the folder, created if it does not exist; raise ExportError if that fails."""
    path = Path(folder)
    with told_as(ExportError, f"The folder {path} cannot be created: {{error}}. Choose another one.", OSError):
        path.mkdir(parents=True, exist_ok=True)
    return path


# A set of files. In its temporary folder, beside the new files, `.old-N-NAME` is the file that was at the place of the
# new file N, and `.new-N-NAME` says that there was none. The folder is renamed when the whole set is in place.

_SET, _DONE = ".ilf-export-", ".ilf-done-"
_REPLACED = re.compile(r"\.(?P<kind>old|new)-\d{3}-(?P<name>(?!\.{1,2}\Z).+)", re.DOTALL)


@contextmanager
def staging(target: Path) -> Iterator[Path]:
    """Provide a temporary folder inside `target`, which is created if needed and removed again if the block fails.

    Raises
    ------
    ExportError
        For every OSError, in the block or here.
    """
    missing = tuple(path for path in (target, *target.parents) if not os.path.exists(path))
    try:
        target.mkdir(parents=True, exist_ok=True)
        restore_interrupted(target)
        folder = target / temporary_name(_SET)
        folder.mkdir()
        try:
            with removed_on_exit(folder, *missing):
                yield folder
        finally:
            if not _replaced(folder):  # otherwise they could not be put back: kept for `restore_interrupted`
                shutil.rmtree(folder, ignore_errors=True)
    except BaseException as error:
        remove_empty(missing)
        if isinstance(error, ExportError):  # of a writer, about a file in the temporary folder
            raise ExportError(str(error).replace(str(folder), str(target))) from error
        if isinstance(error, FileExistsError | NotADirectoryError):
            raise ExportError(f"Could not write into {target}: it is not a folder, or lies inside a file.") from error
        if isinstance(error, OSError):
            raise ExportError(f"Could not write into {target}: {remedy(error)}.") from error
        raise


def move_into_place(folder: Path, target: Path, names: Sequence[str]) -> None:
    """Move staged files into place in this order; if a move fails, undo those before it.

    The old file of the last name is put aside first, so that an old seal never exists beside new files.

    Raises
    ------
    Cancelled
        If the work was cancelled before the first move.
    """
    for name in names:
        _check_not_protected(target / name)
    numbered = list(enumerate(names))
    with moving_into_place():
        try:
            for number, name in reversed(numbered):
                if (target / name).exists():
                    os.replace(target / name, folder / f".old-{number:03}-{name}")
                else:
                    (folder / f".new-{number:03}-{name}").touch()
            for name in names:
                os.replace(folder / name, target / name)
            done = folder.with_name(folder.name.replace(_SET, _DONE))
            os.replace(folder, done)
        except BaseException:
            _put_back(folder, target)
            raise
        shutil.rmtree(done, ignore_errors=True)


def interrupted(target: Path) -> list[Path]:
    """Return temporary folders in which ended processes of this user have left an unfinished set."""
    return [path for path in left_in(target, _SET) if path.is_dir()]


def restore_interrupted(target: Path) -> None:
    """Undo unfinished sets of ended processes in a folder: put back the files that they had replaced."""
    for folder in interrupted(target):
        _put_back(folder, target)
        shutil.rmtree(folder, ignore_errors=True)
    for folder in left_in(target, _DONE):
        shutil.rmtree(folder, ignore_errors=True)


def _put_back(folder: Path, target: Path) -> None:
    """Remove new files from their places, then put back the old ones, the seal last. If this is interrupted, the next
    process can continue it."""
    replaced = _replaced(folder)
    for name in {found["name"] for found in replaced.values()}:
        if (target / name).exists() and not (folder / name).exists():
            os.replace(target / name, folder / name)
    for path, found in sorted(replaced.items()):
        if found["kind"] == "old":
            os.replace(path, target / found["name"])
        else:
            path.unlink()


def _replaced(folder: Path) -> dict[Path, re.Match[str]]:
    """What stands for the files of the set at their places before."""
    with suppress(FileNotFoundError):
        return {path: found for path in folder.iterdir() if (found := _REPLACED.fullmatch(path.name))}
    return {}


# Private files and folders, which no other user of the computer may read.


def private_file(path: Path) -> None:
    """Make a file readable by the user only; it is created, and its folder, if it does not exist.

    Raises
    ------
    OSError
        If it cannot be created.

    Examples
    --------
    >>> private_file(Path("notes/own.txt"))
    >>> Path("notes/own.txt").read_text()
    ''
    """
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    path.touch(0o600)
    restrict_to_owner(path)


def restrict_to_owner(path: Path) -> None:
    """Restrict a file or folder to its owner, if it exists and the file system supports it."""
    with suppress(OSError):
        mode = path.stat().st_mode
        if mode & 0o077 and (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            path.chmod(stat.S_IMODE(mode) & 0o700)
