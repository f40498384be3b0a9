"""Which frames the common values are of: all, or the present one."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QToolButton, QWidget


class Sharing(StrEnum):
    """Which frames have the common values of the present one."""

    EACH = "Each has its own"
    ALL = "All frames"
    ALONE = "This frame alone"


_HINTS = {
    Sharing.EACH: "Every frame has values of its own; the next one that is opened begins with those of this one",
    Sharing.ALL: "What is set here goes for all frames of the list, but for those with values of their own",
    Sharing.ALONE: "This frame has values of its own, while the others have those of all frames",
}


class FramesRow(QWidget):
    """Says which frames the values are of, and lets it be chosen.

    Parameters
    ----------
    actions : iterable of QAction
        What can be done beside while a frame has its own values.

    Signals
    -------
    chosen(object)
        The user wants this `Sharing`.
    """

    chosen = Signal(object)

    def __init__(self, actions: Iterable[QAction]) -> None:
        super().__init__()
        self.box = QComboBox()
        self.box.setAccessibleName("Frames that the values are of")
        for number, sharing in enumerate(Sharing):
            self.box.addItem(sharing.value, sharing)
            self.box.setItemData(number, _HINTS[sharing], Qt.ItemDataRole.ToolTipRole)
        self.box.activated.connect(lambda _: self.chosen.emit(Sharing(self.box.currentData())))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        row.addWidget(self.box, 1)
        self._buttons = []
        for action in actions:
            button = QToolButton(autoRaise=True)
            button.setDefaultAction(action)
            row.addWidget(button)
            self._buttons.append(button)
        self.show_sharing(Sharing.EACH)

    def show_sharing(self, sharing: Sharing) -> None:
        """Which frames the values are of."""
        self.box.setCurrentIndex(self.box.findData(sharing))
        self.box.setToolTip(_HINTS[sharing])
        model = self.box.model()
        if isinstance(model, QStandardItemModel):
            model.item(self.box.findData(Sharing.ALONE)).setEnabled(sharing is not Sharing.EACH)
        for button in self._buttons:
            button.setVisible(sharing is Sharing.ALONE)
