"""Registry and cleanup of temporary files, so that a process that ends while writing leaves no partial files."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import socket
import stat
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from .cancellation import check_cancelled

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
    """Clean up before the process ends, whatever its threads are doing: wait for files being moved, remove all other
    files being written, and release semaphores shared with other processes. No files can be moved afterwards."""
    if (shared := sys.modules.get("multiprocessing.util")) is not None:
        shared._run_finalizers(0)  # as at interpreter exit; the resource tracker warns of leaked semaphores
    _moving.acquire(timeout=_MOVE_TIMEOUT_S)
    for path, folders in list(_paths.items()):
        remove(path)
        remove_empty(folders)


def remove(path: Path) -> None:
    """Remove a file or a folder as far as possible."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def remove_empty(folders: tuple[Path, ...]) -> None:
    """Remove those folders that exist and are empty, one after the other."""
    for folder in folders:
        if os.path.isdir(folder) and not any(folder.iterdir()):
            folder.rmdir()


# Files left by ended processes: the names of temporary files and folders identify the process that creates them, so
# that a later process can recognise them.

CREATOR_PATTERN = r"(?P<host>.+)-(?P<process>\d+)-[0-9a-f]{8}"
"""Regular expression for the result of `unique_tag`."""
_FILE = re.compile(rf"\.ilf-{CREATOR_PATTERN}(?:\..*)?")
_DAY_S = 24 * 3600.0
_cleared: set[Path] = set()


def unique_tag() -> str:
    """Return a part of a name that is unique among the temporary files of all processes."""
    return f"{_host()}-{os.getpid()}-{secrets.token_hex(4)}"


def creator_has_ended(match: re.Match[str]) -> bool:
    """Whether the process that created a name (`CREATOR_PATTERN`) has certainly ended. This can only be known of
    processes of this computer, since its start, and of this container."""
    return match["host"] == _host() and not _is_running(int(match["process"]))


def is_own(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to the user of this process; always true where files have no owners."""
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()


def remove_stale_files(temporary: Path) -> None:
    """Remove single temporary files that ended processes of this user have left in the folder of a new one.

    These are files whose process has certainly ended, and those unchanged for a day, by the clock of the folder's disk,
    which may be on another computer. A process checks each folder once.
    """
    folder = temporary.parent
    if folder in _cleared:
        return
    _cleared.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        now = temporary.stat().st_mtime
        for entry in entries:
            match = _FILE.fullmatch(entry.name)
            if match is not None and entry.is_file(follow_symlinks=False):
                with suppress(OSError):  # another program has removed it first
                    status = entry.stat()
                    dead = creator_has_ended(match) or now - status.st_mtime > _DAY_S
                    if dead and is_own(status):
                        os.unlink(entry)


@cache
def _host() -> str:
    """Return an identifier of this computer, since its start, and this container: equal ones share their processes."""
    name = re.sub(r"[^A-Za-z0-9.]+", "_", socket.gethostname()) or "host"
    facts = []
    with suppress(OSError):  # available only on Linux
        facts = [Path("/proc/sys/kernel/random/boot_id").read_text(), str(os.stat("/proc/self/ns/pid").st_ino)]
    return f"{name}.{hashlib.sha256(' '.join(facts).encode()).hexdigest()[:8]}" if facts else name


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


# Private files and folders, which no other user of the computer may read.


def private_file(path: Path) -> None:
    """Create an empty file, and its folder, readable by the user only; leave existing ones unchanged.

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
    with suppress(FileExistsError):
        path.touch(0o600, exist_ok=False)


def restrict_to_owner(path: Path) -> None:
    """Restrict a file or folder to its owner, if it exists and the file system supports it."""
    with suppress(OSError):
        mode = path.stat().st_mode
        if mode & 0o077 and (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            path.chmod(stat.S_IMODE(mode) & 0o700)
