"""What is being written: known, so that a process that ends in the middle of it leaves nothing half done behind."""

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

from .cancellation import check_stopped

_MOVING_LIMIT_S = 5.0
"""Moving files within a folder takes milliseconds; a disk that does not answer is not waited for longer."""

_paths: dict[Path, tuple[Path, ...]] = {}
_moving = threading.Lock()


@contextmanager
def unfinished(path: Path, *made_for_it: Path) -> Iterator[None]:
    """As long as the block lasts, a temporary file or folder is of no use to anybody.

    Parameters
    ----------
    path : Path
    *made_for_it : Path
        Folders that were not there before, innermost first; they go, too, if they are empty.
    """
    _paths[path] = made_for_it
    try:
        yield
    finally:
        _paths.pop(path, None)


@contextmanager
def moving() -> Iterator[None]:
    """Files are put into their places in the block, which is the point of no return.

    Raises
    ------
    Cancelled
        If the work is to stop: then nothing has been moved.
    """
    with _moving:
        check_stopped()
        yield


def discard_unfinished() -> None:
    """For a process that ends now, whatever its threads are doing: what is being moved is finished, all else that is
    being written is taken away, and semaphores that other processes share are given back. Nothing is moved any more
    after that."""
    if (shared := sys.modules.get("multiprocessing.util")) is not None:
        shared._run_finalizers(0)  # as at the interpreter's end; whoever tracks semaphores warns of those that are left
    _moving.acquire(timeout=_MOVING_LIMIT_S)
    for path, folders in list(_paths.items()):
        remove(path)
        remove_empty(folders)


def remove(path: Path) -> None:
    """Take a file or a folder away, as far as that can be done."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def remove_empty(folders: tuple[Path, ...]) -> None:
    """Take those folders away that are there and empty, one after the other."""
    for folder in folders:
        if os.path.isdir(folder) and not any(folder.iterdir()):
            folder.rmdir()


# What dead writers have left: temporary files and folders have in their names who makes them, so that the next who
# writes there can tell.

MADE_BY = r"(?P<host>.+)-(?P<process>\d+)-[0-9a-f]{8}"
"""What `made_by` gives, as a regular expression."""
_FILE = re.compile(rf"\.ilf-{MADE_BY}(?:\..*)?")
_DAY_S = 24 * 3600.0
_cleared: set[Path] = set()


def made_by() -> str:
    """A part of a name that no other temporary file has, of this process or another."""
    return f"{_host()}-{os.getpid()}-{secrets.token_hex(4)}"


def is_dead(match: re.Match[str]) -> bool:
    """Whether who made what a name says (`MADE_BY`) has surely ended. Nothing is known of others than processes of
    this computer, since it was started, and of this container."""
    return match["host"] == _host() and not _runs(int(match["process"]))


def is_own(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to the user of this process; where files have no owners, all do."""
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()


def clear_left_files(temporary: Path) -> None:
    """Take away what this user's writers of single files have left in the folder of one that has just been made.

    That is files whose writer is dead for sure, and those that have lain untouched for a day, by the time of the
    folder's own disk, which may be another computer's. A process looks once into each folder.
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
                with suppress(OSError):  # another program has been quicker
                    status = entry.stat()
                    dead = is_dead(match) or now - status.st_mtime > _DAY_S
                    if dead and is_own(status):
                        os.unlink(entry)


@cache
def _host() -> str:
    """This computer, since it was started, and this container: who has the same sees the same processes."""
    name = re.sub(r"[^A-Za-z0-9.]+", "_", socket.gethostname()) or "host"
    facts = []
    with suppress(OSError):  # what only Linux tells
        facts = [Path("/proc/sys/kernel/random/boot_id").read_text(), str(os.stat("/proc/self/ns/pid").st_ino)]
    return f"{name}.{hashlib.sha256(' '.join(facts).encode()).hexdigest()[:8]}" if facts else name


def _runs(process: int) -> bool:
    if process >= 2**31:  # there is no such number
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


# The user's own files and folders, which no other user of the computer may read.


def private_file(path: Path) -> None:
    """Make an empty file, and its folder, for the user alone; what is there already stays as it is.

    Raises
    ------
    OSError
        If it cannot be made.

    Examples
    --------
    >>> private_file(Path("notes/own.txt"))
    >>> Path("notes/own.txt").read_text()
    ''
    """
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    with suppress(FileExistsError):
        path.touch(0o600, exist_ok=False)


def tighten(path: Path) -> None:
    """Leave a file or folder to its owner alone, if it is there and the file system can."""
    with suppress(OSError):
        mode = path.stat().st_mode
        if mode & 0o077 and (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            path.chmod(stat.S_IMODE(mode) & 0o700)
