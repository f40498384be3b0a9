"""The history of the present frame: every step that can be undone, the present state marked; a click goes there."""

from __future__ import annotations

from PySide6.QtGui import QUndoGroup
from PySide6.QtWidgets import QUndoView, QWidget


class HistoryView(QUndoView):
    """Steps of the frame's undo history, oldest first."""

    def __init__(self, history: QUndoGroup, parent: QWidget | None = None) -> None:
        super().__init__(history, parent)
        self.setEmptyLabel("As opened")
        self.setAccessibleName("History")
        self.setToolTip("Click a step to go back, or forward, to the state after it")
        self.setUniformItemSizes(True)
