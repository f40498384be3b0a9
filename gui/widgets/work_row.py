"""Progress bar of background work with the remaining time and a cancel button."""

from __future__ import annotations

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QProgressBar, QPushButton, QSizePolicy, QWidget

from ..work.jobs import Pace
from ..work.latest_request import LatestRequest
from .basics import lay_out

_SOON_MS = 200
"""Time [ms] that requests take without progress being shown."""


class WorkRow(QWidget):
    """A progress bar with share and time left, and *Cancel*; hidden without work.

    `what` names the work; `left` is the part of the tooltip about the effect of cancelling.

    Signals
    -------
    cancelled()
        The user pressed *Cancel*.
    """

    cancelled = Signal()

    def __init__(self, what: str, left: str = "results so far are kept") -> None:
        super().__init__()
        self._pace = Pace()
        self.bar = QProgressBar()
        self.bar.setRange(0, 1000)
        self.bar.setAccessibleName(f"Progress of the {what}")
        self.bar.setToolTip(f"Progress and remaining time of the {what}")
        self.cancel_button = QPushButton("Cancel", autoDefault=False)
        self.cancel_button.setToolTip(f"Cancel the {what}; {left}")
        self.cancel_button.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.cancel_button.clicked.connect(self._cancel)
        lay_out(QHBoxLayout(self), self.bar, self.cancel_button, spacing=6, stretched=self.bar)
        self.hide()

    def follow(self, requests: LatestRequest) -> None:
        """Show the progress of requests, and cancel them by *Cancel*."""
        self.cancelled.connect(requests.cancel)
        soon = QTimer(self, singleShot=True, interval=_SOON_MS)
        soon.timeout.connect(lambda: self.begin() if self.isHidden() else None)
        requests.begun.connect(soon.start)
        requests.progressed.connect(soon.stop)
        requests.progressed.connect(self._take_share)
        requests.ended.connect(soon.stop)
        requests.ended.connect(self.hide)

    def _take_share(self, share: float) -> None:
        """Show a share."""
        if self.isHidden():
            self.begin()
        self.show_share(share)

    def begin(self) -> None:
        """Show the row at the start of work."""
        self._pace.forget()
        self.cancel_button.setEnabled(True)
        self.show_share(0.0)
        self.show()

    def show_share(self, share: float) -> None:
        """Show the share done, 0-1."""
        self.bar.setValue(round(1000 * share))
        self._pace.note(share)
        left = self._pace.text()
        self.bar.setFormat(f"{share:.0%}, {left}" if left else f"{share:.0%}")

    def _cancel(self) -> None:
        self.cancel_button.setEnabled(False)
        self.bar.setFormat("Cancelling…")
        self.cancelled.emit()
