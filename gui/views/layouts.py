"""Which views are visible, how large and where: layouts by name, and the area that they arrange."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QRect, QSize, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from .cell import Cell

CELLS = {
    "colour": ("Colour + blocks", "colour"),
    "depth-in": ("Depth in", "depth-in"),
    "depth-out": ("Depth out", "result"),
    "difference": ("Difference", "difference"),
    "expected-error": ("Expected error", "expected-error"),
    "flicker": ("Flicker", "flicker"),
    "extraction": ("Extraction", "extraction"),
    "a": ("Side A", "a"),
    "b": ("Side B", "b"),
    "evaluation": ("Error", "evaluation"),
}
"""Cells: name -> title of the layout with this cell alone, and the default content."""

COMPARE = "compare"
"""Two depths side by side."""

_FIRST_THREE = ("colour", "depth-in", "depth-out")
GRIDS = {
    "grid": ((*_FIRST_THREE, "expected-error"), 2),
    "grid-difference": ((*_FIRST_THREE, "difference"), 2),
    "grid-flicker": ((*_FIRST_THREE, "flicker"), 2),
    "grid-extraction": (("colour", "depth-in", "extraction", "depth-out"), 2),
    "row": ((*_FIRST_THREE, "expected-error"), 4),
    COMPARE: (("a", "b", "difference", "evaluation"), 2),
}
"""Layouts of several views of one size: name -> views, row by row, and the number per row."""

CORRECT = "correct"
"""One large view and several small ones, any of which can be swapped with the large one."""
CORRECT_VIEWS = (*_FIRST_THREE, "expected-error")

LAYOUT_TEXTS = {
    "grid": "Four views",
    "grid-difference": "Four with difference",
    "grid-flicker": "Four with flicker",
    "grid-extraction": "Four with extraction",
    "row": "Four in a row",
    COMPARE: "Two compared",
    CORRECT: "One large, three small",
    **{name: title for name, (title, _) in CELLS.items()},
}
"""Names for `Sheet.set_layout`, and their texts in the window."""

LAYOUTS = tuple(LAYOUT_TEXTS)
"""The same names, in the order of the menu."""

LASTING = tuple(name for name in (*GRIDS, CORRECT) if name != COMPARE)
"""Layouts for work; single views and the comparison of two depths return to them."""

_GAP = 1
_SMALL_SHARES = (0.2, 0.36)
"""Minimum and maximum share of the area's side for the small views of `CORRECT`."""
_SHARES_TRIED = 33


Place = tuple[int, int, int, int]
"""Left, top, width and height of a cell in the area of the views [screen pixels]."""


def picture_area(place: Place, aspect: float, strip: int) -> float:
    """Area of a picture of this aspect ratio in a cell, below a title strip of this height."""
    width = min(float(place[2]), max(place[3] - strip, 0) * aspect)
    return width * width / aspect


def grid_places(count: int, columns: int, width: int, height: int, left: int = 0, top: int = 0) -> list[Place]:
    """Places of cells of one size, row by row, in an area of this size and corner."""
    columns = min(columns, count)
    rows = -(-count // columns)
    across, down = (width - (columns - 1) * _GAP) // columns, (height - (rows - 1) * _GAP) // rows
    return [
        (left + index % columns * (across + _GAP), top + index // columns * (down + _GAP), across, down)
        for index in range(count)
    ]


def correct_places(small: int, width: int, height: int, aspect: float, strip: int) -> list[Place]:
    """Places of the large cell and of `small` others at its right or below, for the largest pictures.

    Parameters
    ----------
    small : int
        Number of small cells.
    width, height : int
        Size of the area.
    aspect : float
        The frame's width over its height.
    strip : int
        Height of the cells' title strips.
    """
    low, high = _SMALL_SHARES
    choices = []
    for share in (low + (high - low) * step / (_SHARES_TRIED - 1) for step in range(_SHARES_TRIED)):
        left, top = width - round(share * width), height - round(share * height)
        choices += [
            [(0, 0, left - _GAP, height), *grid_places(small, 1, width - left, height, left=left)],
            [(0, 0, width, top - _GAP), *grid_places(small, small, width, height - top, top=top)],
        ]
    return max(choices, key=lambda places: sum(picture_area(place, aspect, strip) for place in places))


# The area of the views.

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
