"""Painters of an EBS stage, selected in the title strip, and of a block's spectrum."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPointF, QRectF, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QButtonGroup, QComboBox, QHBoxLayout, QToolButton, QWidget

from ilf.drawing.blocks import STAGES, stage_count, stage_legend
from ilf.segmentation.extraction import Extraction

from ..base.theme import Colours
from .colours import strength_table
from .image_view import ImageView
from .painter import Material, Painter, Spectrum, number_at
from .pixel_items import packed
from .view_cell import ViewCell


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


class StagePainter(Painter):
    """Painter of the stage of a board, with the stage picker in the title strip."""

    uses = frozenset({"stage"})

    def __init__(self, content: str, cell: ViewCell, material: Material, board: StageModel) -> None:
        super().__init__(content, cell, material)
        self._board = board
        self._table = strength_table()
        self._drawn: NDArray[np.uint8] | None = None
        self._picker = StagePicker(cell.strip)
        self._picker.chosen.connect(board.set_stage)
        self._picker.setFont(cell.strip.font())
        cell.strip.set_title_widget(self._picker)
        cell.bar.set_table(self._table)
        # its blocks differ from those of the frame
        cell.view.has_lines = False

    def draw(self) -> None:
        board, cell = self._board, self.cell
        self._picker.show_stage(board.stage)
        self._picker.set_hints(board.hints)
        cell.set_legend([(QBrush(QColor(*colour)), text) for colour, text in board.legend])
        cell.strip.set_text(board.text)
        if board.picture is None:
            self._drawn = None
            self.show_placeholder(board.message)
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
        self.cell.strip.set_title_widget(None)
        self.cell.strip.set_text("")
        self.cell.view.has_lines = True


# The spectrum of the selected block, with the pass band of its filter.

_BAND, _HALO = QColor(90, 230, 255), QColor(0, 0, 0, 170)
_MARGIN = 8
_MIN_RADIUS = 3.0
"""Minimum radius of a drawn pass band [screen px]."""


class SpectrumPicture(QWidget):
    """Widget over a view: a spectrum has no pixels of the frame, so it has no pan, zoom or cursor."""

    def __init__(self, view: ImageView) -> None:
        super().__init__(view)
        self._spectrum: Spectrum | None = None
        self._message = ""
        self._image = QImage()
        self._background = self._text = QColor()
        self.setAccessibleName("Spectrum of the selected block")
        view.resized.connect(self._cover)
        self._cover()
        self.show()

    def set_colours(self, colours: Colours) -> None:
        """Apply the theme's colours."""
        self._background, self._text = colours.background, colours.muted
        self.update()

    def show_spectrum(self, spectrum: Spectrum | str) -> None:
        """Draw a spectrum, or show the reason why there is none."""
        self._spectrum = None if isinstance(spectrum, str) else spectrum
        self._message = spectrum if isinstance(spectrum, str) else ""
        if self._spectrum is not None:
            indices = 1 + np.round(254 * self._spectrum.magnitude).astype(np.uint8)
            pixels = packed(strength_table())[indices]
            height, width = pixels.shape
            self._image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
        self.update()

    def _cover(self) -> None:
        view = self.parentWidget()
        if view is not None:
            self.setGeometry(view.rect())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._background)
        painter.setPen(self._text)
        if self._spectrum is None:
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self._message)
            return
        height, width = self._spectrum.magnitude.shape
        room = QRectF(self.rect()).adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
        scale = min(room.width() / width, room.height() / height)
        place = QRectF(0, 0, width * scale, height * scale)
        place.moveCenter(room.center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale < 1)
        painter.drawImage(place, self._image)
        self._draw_band(painter, place, scale, self._spectrum)

    def _draw_band(self, painter: QPainter, place: QRectF, scale: float, spectrum: Spectrum) -> None:
        height, width = spectrum.magnitude.shape
        # k = 0 is the sample in the middle, as from `fftshift`
        centre = place.topLeft() + QPointF((width // 2 + 0.5) * scale, (height // 2 + 0.5) * scale)
        down, across = (max(radius * scale, _MIN_RADIUS) for radius in spectrum.radii)
        painter.setClipRect(place)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for colour, line in ((_HALO, 4.0), (_BAND, 2.0)):
            painter.setPen(QPen(colour, line))
            painter.drawEllipse(centre, across, down)


class SpectrumPainter(Painter):
    """Painter of the log magnitude of the block's depth, and of the last pass band."""

    uses = frozenset({"spectrum"})

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        super().__init__(content, cell, material)
        self._picture = SpectrumPicture(cell.view)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self._picture.set_colours(colours)
        self.cell.set_legend([])

    def draw(self) -> None:
        spectrum = self.material.spectrum
        self._picture.show_spectrum(spectrum)
        there = not isinstance(spectrum, str)
        self.cell.strip.set_text(spectrum.text if isinstance(spectrum, Spectrum) else "")
        self.cell.set_legend([(QBrush(_BAND), "pass band")] if there else [])

    def leave(self) -> None:
        self._picture.hide()
        self._picture.setParent(None)
        self._picture.deleteLater()
