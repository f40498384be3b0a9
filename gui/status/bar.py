"""The status bar: what a click would do now, what is under the cursor, how far the work is."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar, QWidget

from gui.widgets.plain_text import PlainLabel, as_it_is

_PROGRESS = 200


class StatusBar(QStatusBar):
    """Hint at the left, readout and progress at the right. What is said in passing has a place of its own."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hint = PlainLabel()
        self.readout = QLabel()
        self.progress = QProgressBar()
        # neither may keep the window from being made narrower than what they say
        for label in (self.hint, self.readout):
            label.setMinimumWidth(1)
        self.progress.setFixedWidth(_PROGRESS)
        self.progress.setAccessibleName("Progress")
        self.progress.setTextVisible(True)
        self.progress.hide()
        self.addWidget(self.hint, 1)
        self.addPermanentWidget(self.readout)
        self.addPermanentWidget(self.progress)

    def show_progress(self, text: str, share: float | None, left: str) -> None:
        """Say what is under way, how much of it is done, 0-1 or None if that is not known, and what time is left.

        "" for nothing under way.
        """
        progress = self.progress
        progress.setVisible(bool(text))
        said = ""
        if share is None:
            progress.setRange(0, 0)
        else:
            progress.setRange(0, 100)
            progress.setValue(round(100 * share))
            said = f" {round(100 * share)} %" + (f", {left}" if left else "")
        metrics = progress.fontMetrics()
        room = progress.width() - 2 * metrics.averageCharWidth() - metrics.horizontalAdvance(said)
        progress.setFormat(metrics.elidedText(text, Qt.TextElideMode.ElideRight, room) + said)
        progress.setToolTip(as_it_is(text + said))
