"""How far some work in the background is, how long it still takes, and a button that ends it."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QProgressBar, QPushButton, QSizePolicy, QWidget

from ..work.jobs import Pace


class WorkRow(QWidget):
    """A bar with share and time left, and *Cancel*; hidden while nothing is under way. `left` says what stays then.

    Signals
    -------
    cancelled()
        The user wants it to end.
    """

    cancelled = Signal()

    def __init__(self, what: str, left: str = "what has come so far stays") -> None:
        super().__init__()
        self._pace = Pace()
        self.bar = QProgressBar()
        self.bar.setRange(0, 1000)
        self.bar.setAccessibleName(f"Progress of the {what}")
        self.bar.setToolTip(f"How far the {what} is, and how long it still takes")
        self.cancel_button = QPushButton("Cancel", autoDefault=False)
        self.cancel_button.setToolTip(f"End the {what}; {left}")
        self.cancel_button.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.cancel_button.clicked.connect(self._cancel)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(6)
        row.addWidget(self.bar, 1)
        row.addWidget(self.cancel_button)
        self.hide()

    def begin(self) -> None:
        """Work has begun."""
        self._pace.forget()
        self.cancel_button.setEnabled(True)
        self.show_share(0.0)
        self.show()

    def show_share(self, share: float, worked: float | None = None) -> None:
        """So much is done, 0-1; `worked` is the share of the work since `begin`, where `share` also counts what was
        done before, or took no time."""
        self.bar.setValue(round(1000 * share))
        self._pace.note(share if worked is None else worked)
        left = self._pace.text()
        self.bar.setFormat(f"{share:.0%}, {left}" if left else f"{share:.0%}")

    def end(self) -> None:
        """Nothing is under way any more."""
        self.hide()

    def _cancel(self) -> None:
        self.cancel_button.setEnabled(False)
        self.bar.setFormat("Stopping…")
        self.cancelled.emit()
