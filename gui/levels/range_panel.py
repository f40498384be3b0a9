"""The panel of the range: a histogram with levels to drag, ways to find them, numbers, the lock, the colour map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QStackedWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from gui import theme
from gui.levels.histogram import Histogram
from gui.views.colour_maps import DEPTH_MAPS
from gui.views.ranges import FIXED, KINDS, MODES, Levels, Range
from gui.widgets.plain_text import PlainLabel

_DECIMALS = {"depth": 3, "signed": 2, "expected": 2}
_LARGEST = 1e6


class RangePanel(QWidget):
    """Shows one range, and hands on what the user does with it.

    Signals
    -------
    modeChosen(str)
        One of `ranges.MODES`.
    levelsSet(float, float)
        Numbers were typed, or a level was dragged.
    mapChosen(str)
        One of `colour_maps.DEPTH_MAPS`.
    shown()
        The panel has come to be seen.
    """

    modeChosen = Signal(str)
    levelsSet = Signal(float, float)
    mapChosen = Signal(str)
    shown = Signal()

    def __init__(self, lock: QAction) -> None:
        super().__init__()
        self._kind = ""
        self.histogram = Histogram()
        self.histogram.levelsDragged.connect(self.levelsSet)
        self.title = PlainLabel()
        self.mode = self._box(MODES, "How the range is found: robust leaves out one value in a hundred at each end")
        self.mode.setAccessibleName("Way to the range")
        self.mode.activated.connect(lambda _: self.modeChosen.emit(self.mode.currentData()))
        self.low, self.high = self._number("Lower end of the colours"), self._number("Upper end of the colours")
        self.map = self._box({name: name.capitalize() for name in DEPTH_MAPS}, "Colours of depth")
        self.map.setAccessibleName("Colours of depth")
        self.map.activated.connect(lambda _: self.mapChosen.emit(self.map.currentData()))
        lock_button = QToolButton()
        lock_button.setAutoRaise(True)
        lock_button.setDefaultAction(lock)
        self._nothing = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        self._pages = QStackedWidget()
        self._pages.addWidget(self.histogram)
        self._pages.addWidget(self._nothing)
        top, bottom = QHBoxLayout(), QHBoxLayout()
        top.addWidget(self.title, 1)
        top.addWidget(self.map)
        top.addWidget(lock_button)
        for widget in (self.mode, self.low, PlainLabel("\N{EN DASH}"), self.high):
            bottom.addWidget(widget)
        bottom.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(6, 4, 6, 4)
        column.setSpacing(4)
        column.addLayout(top)
        column.addWidget(self._pages, 1)
        column.addLayout(bottom)
        self._take_theme()

    def show_range(
        self,
        title: str,
        kind: str,
        values: NDArray[np.floating] | None,
        levels: Levels,
        one: Range,
    ) -> None:
        """Show the range of a kind (`ranges.KINDS`) as it is, over the values of a view."""
        self._kind = kind
        self._pages.setCurrentWidget(self.histogram)
        self.title.setText(f"{title} [{KINDS[kind]}]")
        self.histogram.set_scale(kind == "expected", kind == "signed")
        self.histogram.show_values(values, levels)
        self.histogram.set_movable(not one.locked)
        self.mode.setCurrentIndex(self.mode.findData(one.mode))
        for number, level in zip((self.low, self.high), levels, strict=True):
            with QSignalBlocker(number):
                number.setDecimals(_DECIMALS[kind])
                number.setSuffix(f" {KINDS[kind]}")
                number.setValue(level)
        self._allow(True, one.locked)

    def show_nothing(self, title: str, reason: str) -> None:
        """Say why there is no range to be seen."""
        self._kind = ""
        self.title.setText(title)
        self._nothing.setText(reason)
        self._pages.setCurrentWidget(self._nothing)
        self._allow(False, False)

    def show_map(self, name: str) -> None:
        """Mark the colours of depth that are in use."""
        self.map.setCurrentIndex(self.map.findData(name))

    def _allow(self, there: bool, locked: bool) -> None:
        for widget in (self.mode, self.low, self.high):
            widget.setEnabled(there and not locked)
        self.map.setVisible(self._kind in ("", "depth"))

    def _type(self) -> None:
        """A number was typed: of a range around 0, the other one follows."""
        low, high = self.low.value(), self.high.value()
        if self._kind == "signed":
            far = abs(low) if self.sender() is self.low else abs(high)
            low, high = -far, far
        if self._kind:
            self.mode.setCurrentIndex(self.mode.findData(FIXED))
            self.levelsSet.emit(low, high)

    def _box(self, texts: dict[str, str], hint: str) -> QComboBox:
        box = QComboBox()
        for name, text in texts.items():
            box.addItem(text, name)
        box.setToolTip(hint)
        return box

    def _number(self, hint: str) -> QDoubleSpinBox:
        number = QDoubleSpinBox(minimum=-_LARGEST, maximum=_LARGEST)
        number.setKeyboardTracking(False)
        number.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        number.setToolTip(hint)
        number.setAccessibleName(hint)
        number.valueChanged.connect(self._type)
        return number

    def _take_theme(self) -> None:
        font = self.font()
        font.setPointSizeF(font.pointSizeF() * 0.85)
        self.histogram.set_colours(theme.colours(self.palette()), font)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._take_theme()
        super().changeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()
