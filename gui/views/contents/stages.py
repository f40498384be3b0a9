"""The content "extraction": a stage of EBS, and in the title strip the choice of the stage."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QBrush, QColor
from PySide6.QtWidgets import QButtonGroup, QComboBox, QHBoxLayout, QToolButton, QWidget

from gui.views.colour_maps import strength_table
from gui.views.view_cell import ViewCell
from ilf.drawing.stages import STAGES, stage_count, stage_legend
from ilf.ebs import Extraction

from .material import Material
from .painter import Painter, number_at


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
        self._box.setAccessibleName("Stage of the extraction")
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


class StageBoard(QObject):
    """Which stage is shown in all cells of the extraction, and its picture.

    Signals
    -------
    stageChanged(str)
        Another of `STAGES` is to be shown, by the user's choice or by `set_stage`.
    changed()
        There is something else to draw.
    """

    stageChanged = Signal(str)
    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.stage = "blocks"
        self.hints: Mapping[str, str] = {}
        """What tooltips say of the stages."""
        self.picture: NDArray[np.uint8] | None = None
        """As `stage_picture` gives it; None while there is only `message`."""
        self.message = ""
        self.text = ""
        """What there is to say of the picture."""
        self.legend: list[tuple[tuple[int, int, int], str]] = []

    def set_stage(self, name: str) -> None:
        """Choose the stage; the picture shown stays until that of the stage is given."""
        if name not in STAGES:
            raise ValueError(f"stage must be one of {', '.join(STAGES)}, not {name!r}")
        if name != self.stage:
            self.stage = name
            self.changed.emit()
            self.stageChanged.emit(name)

    def set_hints(self, hints: Mapping[str, str]) -> None:
        """What tooltips say of the stages."""
        self.hints = hints
        self.changed.emit()

    def show_picture(self, stage: str, picture: NDArray[np.uint8], extraction: Extraction) -> None:
        """Show what `stages.stage_picture` gives for a stage of an extraction."""
        self.picture, self.legend = picture, stage_legend(stage, extraction)
        self.show_text(stage_count(stage, extraction))

    def show_message(self, message: str) -> None:
        """Show no picture, but why there is none."""
        self.message, self.picture, self.legend = message, None, []
        self.show_text("")

    def show_text(self, text: str) -> None:
        """Say something else of the picture."""
        self.text = text
        self.changed.emit()


class StagePainter(Painter):
    """The stage of a board, and in the title strip the choice of the stage."""

    uses = frozenset({"stage"})

    def __init__(self, content: str, cell: ViewCell, material: Material, board: StageBoard) -> None:
        super().__init__(content, cell, material)
        self._board = board
        self._table = strength_table()
        self._drawn: NDArray[np.uint8] | None = None
        self._picker = StagePicker(cell.strip)
        self._picker.chosen.connect(board.set_stage)
        self._picker.setFont(cell.strip.font())
        cell.strip.set_guest(self._picker)
        cell.bar.set_table(self._table)
        # its blocks are others than those of the frame
        cell.view.has_lines = False

    def draw(self) -> None:
        board, cell = self._board, self.cell
        self._picker.show_stage(board.stage)
        self._picker.set_hints(board.hints)
        cell.set_legend([(QBrush(QColor(*colour)), text) for colour, text in board.legend])
        cell.strip.set_text(board.text)
        if board.picture is None:
            self._drawn = None
            self.show_nothing(board.message)
        elif board.picture is not self._drawn:
            self._drawn = board.picture
            indexed = board.picture.ndim == 2
            cell.view.set_picture(board.picture, self._table if indexed else None)
            cell.bar.set_levels((0.0, 1.0) if indexed else None)

    def value_at(self, x: int, y: int) -> float | None:
        if self._drawn is None or self._drawn.ndim != 2:
            return None
        index = number_at(self._drawn, x, y)
        return None if index is None else (index - 1) / 254

    def leave(self) -> None:
        self.cell.strip.set_guest(None)
        self.cell.strip.set_text("")
        self.cell.view.has_lines = True
