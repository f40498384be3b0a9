"""Where unexpected errors are written down in full, so that one line can tell of them."""

from __future__ import annotations

import faulthandler
import os
import platform
import time
import traceback
from contextlib import suppress
from pathlib import Path
from typing import TextIO

import platformdirs

from .errors import cause
from .private import private_file, tighten
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
    said = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return f"Memory has run out{f' ({said:.200})' if said else ''}. Close other programs, or take a smaller frame."
    what = f"{type(error).__name__}: {said}"
    try:
        with _opened() as file:
            file.write(f"{_head()}\n{''.join(traceback.format_exception(error))}\n")
    except OSError as unwritable:
        kept = f"its log could not be written ({cause(unwritable)})"
        return f"An error that is a fault of the program ({what:.200}); {kept}."
    return f"An error that is a fault of the program ({what:.200}). To report it, add {fault_log()}"


def note_crashes() -> None:
    """Have a crash of native code write down there where all threads were; if something else looks after crashes, or
    the log cannot be written, nothing is done."""
    if not faulthandler.is_enabled():
        with suppress(OSError):
            faulthandler.enable(_opened())


def _head() -> str:
    now = time.strftime("%Y-%m-%d %H:%M:%S")
    return f"{now} ILF Studio {__version__}, Python {platform.python_version()}, {platform.platform()}"


def _opened() -> TextIO:
    path = fault_log()
    if path.exists() and path.stat().st_size > _LARGEST:
        os.replace(path, path.with_name(f"{path.name}.1"))
    private_file(path)
    tighten(path)
    return open(path, "a", encoding="utf-8", errors="backslashreplace")
