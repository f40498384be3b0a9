"""The area of the linked views: which cells are visible, how large and where."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QRect, QSize, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from .cell import Cell
from .layouts import CORRECT, CORRECT_VIEWS, GRIDS, LASTING, LAYOUTS, correct_places, grid_places

_MIN_SIZE = QSize(256, 192)


class Sheet(QWidget):
    """Widget that arranges cells by a layout. A double-click on a cell's title enlarges the cell, or restores it.

    Parameters
    ----------
    cells : mapping of str to Cell
        Keyed by the names that layouts use; the sheet becomes their parent.

    Signals
    -------
    layoutChanged(str)
        Another of `LAYOUTS` is shown.
    placed()
        Cells were moved, or other cells are shown.
    """

    layoutChanged = Signal(str)
    placed = Signal()

    def __init__(self, cells: Mapping[str, Cell]) -> None:
        super().__init__()
        self.setMinimumSize(_MIN_SIZE)
        self._cells = cells
        self._aspect = 1.0
        self.layout_name = self.lasting = LAYOUTS[0]
        """The layout shown, and the one of `LASTING` that it is or returns to."""
        self._large = CORRECT_VIEWS[0]
        self.shown: tuple[Cell, ...] = ()
        """Cells of the layout, even while the views are hidden; the first sets the scale of the others."""
        for name, cell in cells.items():
            # before it is made visible: without a parent it would be a window
            cell.setParent(self)
            cell.strip.doubleClicked.connect(lambda name=name: self._enlarge(name))
        self._arrange()

    def set_aspect(self, aspect: float) -> None:
        """Arrange the cells for pictures of this aspect ratio (width over height)."""
        self._aspect = aspect
        self._place()

    def set_layout(self, name: str, lasting: str = "") -> None:
        """Arrange the cells by one of `LAYOUTS`; single views return to `lasting`, or to the last one by default."""
        if name not in LAYOUTS:
            raise ValueError(f"layout must be one of {', '.join(LAYOUTS)}, not {name!r}")
        self.lasting = next(one for one in (name, lasting or self.lasting, LAYOUTS[0]) if one in LASTING)
        if name == self.layout_name:
            return
        self.layout_name = name
        self._arrange()
        self.layoutChanged.emit(name)

    def toggle_layout(self, name: str) -> None:
        """Show a layout, or return to the last lasting one if it is shown."""
        self.set_layout(self.lasting if self.layout_name == name else name)

    def _enlarge(self, name: str) -> None:
        """Enlarge a small view, otherwise maximise or restore the view."""
        if self.layout_name == CORRECT and name != self._large:
            self._large = name
            self._arrange()
        else:
            self.toggle_layout(name)

    def _names(self) -> tuple[str, ...]:
        if self.layout_name == CORRECT:
            return (self._large, *(name for name in CORRECT_VIEWS if name != self._large))
        return GRIDS[self.layout_name][0] if self.layout_name in GRIDS else (self.layout_name,)

    def _arrange(self) -> None:
        self.shown = tuple(self._cells[name] for name in self._names())
        for cell in self._cells.values():
            if cell not in self.shown:
                cell.hide()
        self._place()

    def _place(self) -> None:
        shown, size = self.shown, (self.width(), self.height())
        if self.layout_name == CORRECT:
            places = correct_places(len(shown) - 1, *size, self._aspect, shown[0].strip.height())
        else:
            places = grid_places(len(shown), GRIDS[self.layout_name][1] if len(shown) > 1 else 1, *size)
        for cell, place in zip(shown, places, strict=True):
            cell.setGeometry(QRect(*place))
            cell.show()  # only now: elsewhere, it could come between the pointer and the view under it
        self.placed.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place()
