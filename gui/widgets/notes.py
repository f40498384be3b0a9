"""The one way by which the window says something: in passing, in the log, and a box where it must not be missed."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from gui.widgets.log import LogPanel
from gui.widgets.problems import error_details, error_text, warn
from gui.widgets.toasts import Toasts
from ilf.fault_log import note_fault

_TOLD_MS = 6000
_GLIMPSE_MS = 4000
_OFFERED_MS = 15_000


class Notes(QObject):
    """Says things to the user, and keeps in the log what may be wanted later.

    Signals
    -------
    reported(str)
        Something went wrong; a sentence that says what.
    """

    reported = Signal(str)

    def __init__(self, window: QWidget, toasts: Toasts, log: LogPanel) -> None:
        super().__init__(window)
        self._window = window
        self._toasts = toasts
        self._log = log
        self._glimpsed = ""

    def tell(self, message: str) -> None:
        """Something that needs no answer."""
        self._toasts.tell(message, _TOLD_MS)
        self._log.add(message)

    def offer(self, message: str, action: QAction) -> None:
        """Something that a command could be given for; it stays for a good while."""
        self._toasts.tell(message, _OFFERED_MS, action)

    def glimpse(self, message: str) -> None:
        """Something that is of no interest any more when it has been read, as it comes at every move of a slider; nor
        while anything else is said."""
        if self._toasts.message in ("", self._glimpsed):
            self._glimpsed = message
            self._toasts.change(message, _GLIMPSE_MS)

    def warn(self, what: str, notes: Iterable[str], details: str = "") -> None:
        """Something that was done, but not quite as asked for; nothing is shown if there are no notes."""
        texts = list(notes)
        for text in texts:
            self._log.add(f"{what}: {text}")
        if texts:
            warn(self._window, what, "\n\n".join(texts), details)

    def report(self, what: str, error: Exception) -> None:
        """Something that went wrong."""
        details = error_details(error)
        text = note_fault(error) if details else error_text(error)
        self.warn(what, [text], details)
        self.reported.emit(f"{what}: {text}")
