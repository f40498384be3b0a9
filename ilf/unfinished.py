"""What is being written: known, so that a process that ends in the middle of it leaves nothing half done behind."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .stopping import check_stopped

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
