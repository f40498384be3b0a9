"""Unexpected errors anywhere in the window: logged, reported, and survived if possible; and a quick exit."""

from __future__ import annotations

import os
import sys
import threading
import time
import traceback
from types import TracebackType

from PySide6.QtCore import QObject, Qt, Signal

from ilf._runtime.writing import remove_temporary_files

from ..widgets.notes import Notes

_LEAVE_S = 0.3
"""Time [s] to wait for running threads after the window has closed."""


class ErrorReporter(QObject):
    """Reports uncaught errors of slots and threads from now on; then the program continues."""

    _met = Signal(object)

    def __init__(self, notes: Notes) -> None:
        super().__init__(notes)
        self._notes = notes
        # queued: errors may come from any thread
        self._met.connect(self._report, Qt.ConnectionType.QueuedConnection)
        sys.excepthook = self._take
        threading.excepthook = lambda met: self._take(met.exc_type, met.exc_value, met.exc_traceback)

    def _take(self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None) -> None:
        traceback.print_exception(kind, error, trace)
        if isinstance(error, Exception):
            self._met.emit(error)

    def _report(self, error: Exception) -> None:
        self._notes.report("Unexpected error", error)


def exit_soon(status: int) -> int:
    """End the program soon, even if a thread cannot be interrupted; files being written are then complete or absent.

    Returns the exit status if no such thread is left.
    """
    end = time.monotonic() + _LEAVE_S
    threads = [thread for thread in threading.enumerate() if thread.name.startswith("ilf")]
    for thread in threads:
        thread.join(max(end - time.monotonic(), 0))
    if any(thread.is_alive() for thread in threads):
        remove_temporary_files()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)
    return status
