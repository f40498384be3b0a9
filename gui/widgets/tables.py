"""Tables: their common style, with a soft selection colour and centred icons; and a small table of numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from PySide6.QtCore import QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QGuiApplication,
    QIcon,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPaintEvent,
    QPalette,
    QPixmap,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from ..base import theme
from .basics import Themed, literal_text, paint_hint, set_up_rows, use_even_digits

Index = QModelIndex | QPersistentModelIndex

ICON_SIZE = 16
_ROW_HEIGHT = 26
_FILLED = "ilf_filled"
"""Property of editors that already contain the cell's text."""


def set_up_table(view: QTableView, min_width: int = _ROW_HEIGHT) -> None:
    """Set up a table like all others: row selection, a context menu, smooth scrolling, no grid, and sortable columns of
    this minimum width."""
    view.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    view.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
    view.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    view.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    view.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
    view.setShowGrid(False)
    view.setWordWrap(False)
    view.setTabKeyNavigation(False)
    view.setFrameShape(QTableView.Shape.NoFrame)
    view.verticalHeader().hide()
    view.verticalHeader().setDefaultSectionSize(_ROW_HEIGHT)
    header = view.horizontalHeader()
    header.setMinimumSectionSize(min_width)
    header.setHighlightSections(False)
    header.setSortIndicatorClearable(True)
    header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
    view.setSortingEnabled(True)


class RowDelegate(QStyledItemDelegate):
    """Delegate that paints rows.

    Parameters
    ----------
    icon_columns : collection of int
        Columns with only a centred icon or colour.
    """

    def __init__(self, icon_columns: Collection[int], parent: QObject) -> None:
        super().__init__(parent)
        self._icon_columns = icon_columns

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Set the text only once, so that changes of the cell do not overwrite the user's input."""
        if not editor.property(_FILLED):
            editor.setProperty(_FILLED, True)
            super().setEditorData(editor, index)

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        accent, base = option.palette.highlight().color(), option.palette.base().color()
        option.palette.setColor(QPalette.ColorRole.Highlight, _selection_colour(accent.rgb(), base.rgb()))
        option.palette.setColor(QPalette.ColorRole.HighlightedText, option.palette.text().color())
        option.state &= ~QStyle.StateFlag.State_HasFocus

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Paint a cell; that with the keyboard focus has a frame."""
        self._paint_cell(painter, option, index)
        if option.state & QStyle.StateFlag.State_HasFocus:
            painter.setPen(theme.colours(option.palette).accent)
            painter.drawRect(option.rect.adjusted(0, 0, -1, -1))

    def _paint_cell(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        if index.column() not in self._icon_columns:
            super().paint(painter, option, index)
            return
        full = QStyleOptionViewItem(option)
        self.initStyleOption(full, index)
        full.icon = QIcon()
        full.widget.style().drawControl(QStyle.ControlElement.CE_ItemViewItem, full, painter, full.widget)
        box = QRect(0, 0, ICON_SIZE, ICON_SIZE)
        box.moveCenter(option.rect.center())
        decoration = index.data(Qt.ItemDataRole.DecorationRole)
        if isinstance(decoration, QColor):
            painter.save()
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(decoration)
            painter.drawRoundedRect(box.adjusted(1, 1, -1, -1), 3, 3)
            painter.restore()
        elif decoration is not None:
            decoration.paint(painter, box)


@lru_cache(maxsize=8)
def _selection_colour(accent: int, base: int) -> QColor:
    """Return the background of selected rows; colours as numbers so that the cache works, used for every cell."""
    return theme.blend(QColor(base), QColor(accent), 0.28)


# A small table of numbers: rows in groups, the best marked.

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
