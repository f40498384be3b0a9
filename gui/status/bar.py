"""The status bar: what a click would do now, what is under the cursor, how far the work is."""

from __future__ import annotations

from PySide6.QtWidgets import QLabel, QProgressBar, QStatusBar, QWidget


class StatusBar(QStatusBar):
    """Hint at the left, readout and progress at the right. What is said in passing has a place of its own."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hint = QLabel()
        self.readout = QLabel()
        self.progress = QProgressBar()
        # neither may keep the window from being made narrower than what they say
        for label in (self.hint, self.readout):
            label.setMinimumWidth(1)
        self.progress.setFixedWidth(160)
        self.progress.setTextVisible(True)
        self.progress.hide()
        self.addWidget(self.hint, 1)
        self.addPermanentWidget(self.readout)
        self.addPermanentWidget(self.progress)
