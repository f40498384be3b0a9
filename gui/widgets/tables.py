"""A small table of numbers: rows in groups, the best marked."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QGuiApplication,
    QIcon,
    QKeyEvent,
    QKeySequence,
    QPaintEvent,
    QPixmap,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QTreeWidget,
    QTreeWidgetItem,
)

from ..base import theme
from .basics import Themed, literal_text, paint_hint, set_up_rows, use_even_digits

_SWATCH = 10
_ROW_PAD = 6
_LEAST_COLUMN = 36
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class Row:
    """One row of the table.

    Attributes
    ----------
    name : str
    cells : tuple of str
        One for each column but the first; empty for the heading of a group.
    hint : str
        Tooltip.
    colour : (int, int, int) or None
        Colour of its run.
    is_best : bool
        Whether it is the best row of its group, or equal to it.
    is_italic : bool
        Whether its numbers are less reliable than others; the tooltip says why.
    """

    name: str
    cells: tuple[str, ...] = ()
    hint: str = ""
    colour: tuple[int, int, int] | None = None
    is_best: bool = False
    is_italic: bool = False


class NumberTable(Themed, QTreeWidget):
    """Table of numbers with group headings; Ctrl+C copies tab-separated text.

    Parameters
    ----------
    name : str
        Its accessible name.
    columns : sequence of (str, str)
        Title and tooltip of each column but the first.
    """

    def __init__(self, name: str, columns: Sequence[tuple[str, str]]) -> None:
        super().__init__()
        self._empty = ""
        self.rows: tuple[Row, ...] = ()
        self.setAccessibleName(name)
        set_up_rows(self, ["", *(title for title, _ in columns)], 0)
        for number, (_, hint) in enumerate(columns, 1):
            self.headerItem().setToolTip(number, hint)
            self.headerItem().setTextAlignment(number, _RIGHT)
        self.header().setMinimumSectionSize(_LEAST_COLUMN)
        self.setIndentation(0)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setFrameShape(QTreeWidget.Shape.NoFrame)
        use_even_digits(self)

    def set_rows(self, rows: Iterable[Row], empty: str = "") -> None:
        """Show other rows; `empty` is the text shown without rows."""
        wanted = tuple(rows)
        if (wanted, empty) != (self.rows, self._empty):
            self.rows, self._empty = wanted, empty
            self._take_theme()

    def chosen(self) -> list[int]:
        """Return the numbers of the selected rows."""
        return sorted(self.indexOfTopLevelItem(item) for item in self.selectedItems())

    def text(self, chosen: Collection[int] = ()) -> str:
        """Return some rows, or all, as tab-separated text."""
        rows = [self.rows[number] for number in chosen] or self.rows
        head = [self.headerItem().text(number) for number in range(self.columnCount())]
        return "\n".join("\t".join(cells) for cells in [head, *((row.name, *row.cells) for row in rows)])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(self.text(self.chosen()))
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self.rows and self._empty:
            paint_hint(self, self._empty)

    def _take_theme(self) -> None:
        selected = self.chosen()
        self.clear()
        for number, row in enumerate(self.rows):
            item = self._item(row)
            self.addTopLevelItem(item)
            item.setFirstColumnSpanned(not row.cells)
            item.setSelected(number in selected)

    def _item(self, row: Row) -> QTreeWidgetItem:
        colours = theme.colours(self.palette())
        item = QTreeWidgetItem([row.name, *row.cells])
        item.setSizeHint(0, QSize(0, self.fontMetrics().height() + _ROW_PAD))
        font = QFont(self.font())
        font.setBold(row.is_best or not row.cells)
        font.setItalic(row.is_italic)
        for number in range(self.columnCount()):
            item.setFont(number, font)
            item.setToolTip(number, literal_text(row.hint or row.name))
            if number:
                item.setTextAlignment(number, _RIGHT)
            if row.is_best:
                item.setForeground(number, QBrush(colours.good))
        if row.colour is not None:
            swatch = QPixmap(_SWATCH, _SWATCH)
            swatch.fill(QColor(*row.colour))
            item.setIcon(0, QIcon(swatch))
        if not row.cells:
            item.setForeground(0, QBrush(colours.muted))
            item.setFlags(Qt.ItemFlag.ItemIsEnabled)
        return item
