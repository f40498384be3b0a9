"""A line under the views while blocks are carried: to which frame, how far it is, and a button that ends it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QWidget

from gui.widgets.plain_text import PlainLabel
from gui.widgets.work_row import WorkRow

_LEAST_TEXT = 120


class CarryStrip(QWidget):
    """Hidden while nothing is carried."""

    def __init__(self) -> None:
        super().__init__()
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setMinimumWidth(_LEAST_TEXT)
        self.work = WorkRow("carrying of blocks")
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 8, 2)
        layout.addWidget(self.label, 1)
        layout.addWidget(self.work, 1)
        self.hide()

    def show_progress(self, name: str, done: int, total: int) -> None:
        """Blocks are on their way to a frame, after so many of all."""
        if self.isHidden():
            self.work.begin()
            self.show()
        self.label.setText(f"Carrying blocks to {name} ({done + 1} of {total})")
        self.work.show_share(done / total)

    def end(self) -> None:
        """Nothing is carried any more."""
        self.work.end()
        self.hide()
