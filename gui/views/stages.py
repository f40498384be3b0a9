"""The stage of the extraction that the views show, and its picker in the title strip."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QHBoxLayout, QToolButton, QWidget

from ilf.drawing.blocks import STAGES, stage_count, stage_legend
from ilf.segmentation.extraction import Extraction

from ..widgets.basics import combo, flat_button, lay_out


class StagePicker(QWidget):
    """Buttons for all stages side by side, or a combo box if there is too little room.

    Signals
    -------
    chosen(str)
        The user selected a stage.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        layout = lay_out(QHBoxLayout(self), spacing=1)
        self._buttons: dict[str, QToolButton] = {}
        group = QButtonGroup(self)
        self._box = combo(STAGES, "Stage of the extraction", "Stage of the extraction")
        for name, text in STAGES.items():
            button = flat_button("", text=text)
            button.clicked.connect(lambda _=False, name=name: self.chosen.emit(name))
            button.setCheckable(True)
            group.addButton(button)
            layout.addWidget(button)
            self._buttons[name] = button
        layout.addWidget(self._box)
        self._box.currentIndexChanged.connect(lambda _: self.chosen.emit(self._box.currentData()))
        self.set_available_width(0)

    def show_stage(self, name: str) -> None:
        """Mark a stage as the current one, without a signal."""
        self._buttons[name].setChecked(True)
        with QSignalBlocker(self._box):
            self._box.setCurrentIndex(self._box.findData(name))

    def set_hints(self, hints: Mapping[str, str]) -> None:
        """Set the tooltips of the stages."""
        for name, hint in hints.items():
            self._buttons[name].setToolTip(hint)
            self._box.setItemData(self._box.findData(name), hint, Qt.ItemDataRole.ToolTipRole)

    def set_available_width(self, width: int) -> None:
        """Set the width [px] available for the buttons."""
        wide = width >= sum(button.sizeHint().width() + 1 for button in self._buttons.values())
        for button in self._buttons.values():
            button.setVisible(wide)
        self._box.setVisible(not wide)


class StageModel(QObject):
    """The stage shown in all extraction cells, and its picture.

    Signals
    -------
    stageChanged(str)
        Another of `STAGES` was selected, by the user or by `set_stage`.
    changed()
        The picture, text or stage changed.
    """

    stageChanged = Signal(str)
    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.stage = "blocks"
        self.hints: Mapping[str, str] = {}
        """Tooltips of the stages."""
        self.picture: NDArray[np.uint8] | None = None
        """Picture from `stage_picture`; None while there is only `message`."""
        self.message = ""
        self.text = ""
        """Text about the picture."""
        self.legend: list[tuple[tuple[int, int, int], str]] = []

    def set_stage(self, name: str) -> None:
        """Select the stage; the picture stays until the stage's own is shown."""
        if name not in STAGES:
            raise ValueError(f"stage must be one of {', '.join(STAGES)}, not {name!r}")
        if name != self.stage:
            self.stage = name
            self.changed.emit()
            self.stageChanged.emit(name)

    def set_hints(self, hints: Mapping[str, str]) -> None:
        """Set the tooltips of the stages."""
        self.hints = hints
        self.changed.emit()

    def show_picture(self, stage: str, picture: NDArray[np.uint8], extraction: Extraction) -> None:
        """Show the picture of a stage of an extraction, from `stage_picture`."""
        self.picture, self.legend = picture, stage_legend(stage, extraction)
        self.show_text(stage_count(stage, extraction))

    def show_message(self, message: str) -> None:
        """Show a message in place of the picture."""
        self.message, self.picture, self.legend = message, None, []
        self.show_text("")

    def show_text(self, text: str) -> None:
        """Change the text about the picture."""
        self.text = text
        self.changed.emit()
