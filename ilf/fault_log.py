"""Where unexpected errors are written down in full, so that one line can tell of them."""

from __future__ import annotations

import os
import platform
import time
import traceback
from pathlib import Path

import platformdirs

from .version import __version__

_LARGEST = 1_000_000
"""Bytes from which on the log begins anew; the one before is kept beside it."""


def fault_log() -> Path:
    """The log's file: `ILF_LOG`, or one in the user's folder for logs."""
    chosen = os.environ.get("ILF_LOG")
    return Path(chosen) if chosen else platformdirs.user_log_path("ilf-studio", appauthor=False) / "faults.log"


def note_fault(error: BaseException) -> str:
    """Write an unexpected error down with its traceback.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
        One line for the user: what it was, and where to read more.
    """
    if isinstance(error, MemoryError):
        return "Memory has run out. Close other programs, or take a smaller frame."
    what = " ".join(f"{type(error).__name__}: {error}".split())
    try:
        return f"An error that is a fault of the program ({what:.200}). To report it, add {_written(error)}"
    except OSError as unwritable:
        return f"An error that is a fault of the program ({what:.200}); its log could not be written ({unwritable})."


def _written(error: BaseException) -> Path:
    path = fault_log()
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and path.stat().st_size > _LARGEST:
        os.replace(path, path.with_name(f"{path.name}.1"))
    head = f"{time.strftime('%Y-%m-%d %H:%M:%S')} ILF Studio {__version__}, Python {platform.python_version()}, "
    with open(path, "a", encoding="utf-8", errors="backslashreplace") as file:
        file.write(f"{head}{platform.platform()}\n{''.join(traceback.format_exception(error))}\n")
    return path
