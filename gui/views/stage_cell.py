"""The cell of the extraction: a stage of EBS, and in its title strip the choice of the stage."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QResizeEvent
from PySide6.QtWidgets import QButtonGroup, QComboBox, QHBoxLayout, QToolButton, QWidget

from gui.views.colour_maps import strength_table
from gui.views.view_cell import EventHandler, ViewCell
from ilf.drawing.stages import STAGES, stage_count, stage_legend
from ilf.ebs import Extraction

_FOR_TEXT = 110
"""Pixels that the buttons leave to the text at the right of the strip."""


class StagePicker(QWidget):
    """All stages side by side where there is room for them, else in a box to open.

    Signals
    -------
    chosen(str)
        The user chose a stage.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(1)
        self._buttons: dict[str, QToolButton] = {}
        group = QButtonGroup(self)
        self._box = QComboBox()
        self._box.setAccessibleName("Stage of the extraction")
        for name, text in STAGES.items():
            button = QToolButton()
            button.setText(text)
            button.setCheckable(True)
            button.setAutoRaise(True)
            button.clicked.connect(lambda _=False, name=name: self.chosen.emit(name))
            group.addButton(button)
            layout.addWidget(button)
            self._buttons[name] = button
            self._box.addItem(text, name)
        layout.addWidget(self._box)
        self._box.currentIndexChanged.connect(lambda _: self.chosen.emit(self._box.currentData()))
        self._box.setToolTip("Stage of the extraction")
        self.set_room(0)

    def show_stage(self, name: str) -> None:
        """Mark a stage as the present one, without a signal."""
        self._buttons[name].setChecked(True)
        with QSignalBlocker(self._box):
            self._box.setCurrentIndex(self._box.findData(name))

    def set_hints(self, hints: Mapping[str, str]) -> None:
        """What tooltips say of the stages."""
        for name, hint in hints.items():
            self._buttons[name].setToolTip(hint)
            self._box.setItemData(self._box.findData(name), hint, Qt.ItemDataRole.ToolTipRole)

    def set_room(self, width: int) -> None:
        """Pixels that there are for the buttons."""
        wide = width >= sum(button.sizeHint().width() + 1 for button in self._buttons.values())
        for button in self._buttons.values():
            button.setVisible(wide)
        self._box.setVisible(not wide)


class StageCell(ViewCell):
    """Shows one stage at a time.

    Signals
    -------
    stageChanged(str)
        Another of `STAGES` is to be shown, by the user's choice or by `set_stage`.
    """

    stageChanged = Signal(str)

    def __init__(self, on_event: EventHandler) -> None:
        super().__init__("Extraction", "", on_event)
        self._picker = StagePicker()
        self._picker.chosen.connect(self.set_stage)
        self._picker.setFont(self.strip.font())
        layout = QHBoxLayout(self.strip)
        layout.setContentsMargins(self.strip.caption_end, 1, 0, 1)
        layout.addWidget(self._picker, 0, Qt.AlignmentFlag.AlignLeft)
        # its blocks are others than those of the frame
        self.view.has_lines = False
        self._table = strength_table()
        self.bar.set_table(self._table)
        self.stage = "blocks"
        self._picker.show_stage(self.stage)

    def set_stage(self, name: str) -> None:
        """Choose the stage; the picture shown stays until that of the stage is given."""
        if name not in STAGES:
            raise ValueError(f"stage must be one of {', '.join(STAGES)}, not {name!r}")
        if name != self.stage:
            self.stage = name
            self._picker.show_stage(name)
            self.stageChanged.emit(name)

    def set_hints(self, hints: Mapping[str, str]) -> None:
        """What tooltips say of the stages."""
        self._picker.set_hints(hints)

    def show_picture(self, stage: str, picture: NDArray[np.uint8], extraction: Extraction) -> None:
        """Show what `stages.stage_picture` gives for a stage of an extraction."""
        self.set_legend([(QBrush(QColor(*colour)), text) for colour, text in stage_legend(stage, extraction)])
        self.strip.set_text(stage_count(stage, extraction))
        self.view.set_picture(picture, self._table if picture.ndim == 2 else None)
        self.bar.set_levels((0.0, 1.0) if stage == "strength" else None)

    def show_message(self, message: str) -> None:
        """Show no picture, but why there is none."""
        self.view.set_message(message)
        self.view.set_picture(None)
        self.bar.set_levels(None)
        self.set_legend([])
        self.strip.set_text("")

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._picker.set_room(event.size().width() - self.strip.caption_end - _FOR_TEXT)
        super().resizeEvent(event)
