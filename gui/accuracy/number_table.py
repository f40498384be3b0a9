"""A small table of numbers: rows in groups, the best marked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QColor, QGuiApplication, QIcon, QKeyEvent, QKeySequence, QPaintEvent, QPixmap
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from gui import theme
from gui.widgets.hint import paint_hint
from gui.widgets.plain_text import as_it_is

_SWATCH = 10
_ROW_PAD = 6
_CELL_PAD = 13
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class Row:
    """One row.

    Attributes
    ----------
    name : str
    cells : tuple of str
        One for each column but the first; empty for the heading of a group.
    hint : str
        Tooltip.
    colour : (int, int, int) or None
        Of the run that it is of.
    is_best : bool
        Whether it is the best of its group.
    """

    name: str
    cells: tuple[str, ...] = ()
    hint: str = ""
    colour: tuple[int, int, int] | None = None
    is_best: bool = False


class NumberTable(QTreeWidget):
    """Rows under headings; copied with Ctrl+C as text that spreadsheets take."""

    def __init__(self, name: str, columns: Sequence[tuple[str, str]], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._empty = ""
        self._rows: tuple[Row, ...] = ()
        self.setAccessibleName(name)
        self.setColumnCount(1 + len(columns))
        self.setHeaderLabels(["", *(title for title, _ in columns)])
        for number, (_, hint) in enumerate(columns, 1):
            self.headerItem().setToolTip(number, hint)
            self.headerItem().setTextAlignment(number, _RIGHT)
        header = self.header()
        header.setStretchLastSection(False)
        header.setMinimumSectionSize(36)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for number, (title, _) in enumerate(columns, 1):
            widest = max(self.fontMetrics().horizontalAdvance(text) for text in (title, "1000"))
            header.setSectionResizeMode(number, QHeaderView.ResizeMode.Interactive)
            header.resizeSection(number, widest + _CELL_PAD)
        self.setRootIsDecorated(False)
        self.setIndentation(0)
        self.setUniformRowHeights(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setFrameShape(QTreeWidget.Shape.NoFrame)

    @property
    def rows(self) -> tuple[Row, ...]:
        """What is shown."""
        return self._rows

    def set_rows(self, rows: Iterable[Row], empty: str = "") -> None:
        """Show other rows; without any, `empty` says why."""
        wanted = tuple(rows)
        if (wanted, empty) != (self._rows, self._empty):
            self._rows, self._empty = wanted, empty
            self._fill()

    def text(self) -> str:
        """The table, or what is selected of it, cells separated by tabs."""
        chosen = [self.indexOfTopLevelItem(item) for item in self.selectedItems()]
        rows = [self._rows[number] for number in sorted(chosen)] or list(self._rows)
        head = [self.headerItem().text(number) for number in range(self.columnCount())]
        return "\n".join("\t".join(cells) for cells in [head, *((row.name, *row.cells) for row in rows)])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(self.text())
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self._rows and self._empty:
            paint_hint(self, self._empty)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_rows"):
            self._fill()

    def _fill(self) -> None:
        colours = theme.colours(self.palette())
        self.clear()
        for row in self._rows:
            item = QTreeWidgetItem([row.name, *row.cells])
            item.setSizeHint(0, QSize(0, self.fontMetrics().height() + _ROW_PAD))
            for number in range(self.columnCount()):
                item.setToolTip(number, as_it_is(row.hint or row.name))
                if number:
                    item.setTextAlignment(number, _RIGHT)
                if row.is_best or not row.cells:
                    font = item.font(number)
                    font.setBold(True)
                    item.setFont(number, font)
                if row.is_best:
                    item.setForeground(number, colours.good)
            if row.colour is not None:
                item.setIcon(0, _swatch(row.colour))
            if not row.cells:
                item.setForeground(0, colours.muted)
                item.setFlags(Qt.ItemFlag.ItemIsEnabled)
            self.addTopLevelItem(item)
            if not row.cells:
                item.setFirstColumnSpanned(True)


def _swatch(colour: tuple[int, int, int]) -> QIcon:
    pixels = QPixmap(_SWATCH, _SWATCH)
    pixels.fill(QColor(*colour))
    return QIcon(pixels)
