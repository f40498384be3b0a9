"""A table of things, a row each: its columns, its cells, and views of it, one to sort and edit, one of numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, NamedTuple

from PySide6.QtCore import (
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QRect,
    QSize,
    QSortFilterProxyModel,
    Qt,
    Signal,
)
from PySide6.QtGui import (
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
    QStandardItem,
    QStandardItemModel,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from ..base import theme
from .basics import Themed, literal_text, paint_hint, use_even_digits

Index = QModelIndex | QPersistentModelIndex

ICON_SIZE = 16
_ROW_HEIGHT, _ROW_PAD = 26, 6
_FILLED = "ilf_filled"
"""Property of editors that already contain the cell's text."""
_SORT_ROLE, _EDITED_ROLE, _KEY_ROLE = (Qt.ItemDataRole.UserRole + number for number in range(3))
"""By what rows are sorted, what is edited, and whose row it is."""
_TICKS = {False: Qt.CheckState.Unchecked, True: Qt.CheckState.Checked}
_NARROW = 26
"""Width of columns of icons and ticks [px]."""


@dataclass(frozen=True)
class Heading:
    """A column.

    Attributes
    ----------
    title, hint : str
        Of the header; the hint is that of cells without one, too.
    width : int
        First width [px]; 0 if the table sets it.
    kind : str
        What is in its cells: "text", "number", a name that can be "edited", an "icon", or a "tick".
    icon : str
        Of the header, in place of a title.
    """

    title: str
    hint: str
    width: int = 0
    kind: Literal["text", "number", "edited", "icon", "tick"] = "text"
    icon: str = ""


class TableCell(NamedTuple):
    """What a table shows of a thing in one column.

    Attributes
    ----------
    text : str
    key : str or float
        By which rows are sorted.
    hint : str
        "" for that of the column; rich text if it begins with "<p>".
    icon : (str, str) or (int, int, int) or None
        Name of an icon and of its colour in `theme.Colours`; or a colour.
    tone : str
        Name of the text's colour; "" for the usual one.
    bold, italic : bool
    ticked : bool
    edited : str or None
        What is edited; None for the text.
    said : str
        What screen readers say, if it differs from the text.
    """

    text: str = ""
    key: str | float = ""
    hint: str = ""
    icon: tuple[str, str] | tuple[int, int, int] | None = None
    tone: str = ""
    bold: bool = False
    italic: bool = False
    ticked: bool = False
    edited: str | None = None
    said: str = ""


TableCells = Mapping[int, TableCell]
"""Column -> cell, of one thing."""


class RowModel(QStandardItemModel):
    """Rows of cells. Rows change only by `show_rows`: what the user edits is passed on.

    Signals
    -------
    edited(object, int, object)
        A key, a column, and the text that was typed or whether the cell was ticked.
    """

    edited = Signal(object, int, object)

    def __init__(self, headings: Mapping[int, Heading], parent: QWidget) -> None:
        super().__init__(0, len(headings), parent)
        self._widget, self._headings = parent, headings
        self._shown: dict[Any, TableCells] = {}
        self._draw_heads()

    @property
    def keys(self) -> list[Any]:
        """Whose row each is."""
        return [self.index(row, 0).data(_KEY_ROLE) for row in range(self.rowCount())]

    def show_rows(self, rows: Mapping[Any, TableCells]) -> None:
        """Show the cells of each key, in this order; rows that stay keep their order. It tells only of what changes, so
        that editors stay open."""
        for row, key in reversed([*enumerate(self.keys)]):
            if key not in rows:
                self.removeRow(row)
        keys = self.keys
        for row, (key, cells) in enumerate(rows.items()):
            if row == len(keys) or keys[row] != key:
                keys.insert(row, key)
                self.insertRow(row, [self._item(key, cells[column], column) for column in self._headings])
            elif self._shown[key] != cells:
                self._draw(row, key, cells, self._shown[key])
        self._shown = dict(rows)

    def take_theme(self) -> None:
        """Draw icons and colours anew."""
        for row, (key, cells) in enumerate(self._shown.items()):
            self._draw(row, key, cells, {})

    def _draw_heads(self) -> None:
        for column, heading in self._headings.items():
            head = QStandardItem(heading.title)
            head.setToolTip(heading.hint)
            head.setAccessibleText(heading.title or heading.hint)
            head.setData(_alignment(heading).value | Qt.TextFlag.TextWordWrap.value, Qt.ItemDataRole.TextAlignmentRole)
            if heading.icon:
                head.setIcon(theme.icon(heading.icon))
            self.setHorizontalHeaderItem(column, head)

    def _draw(self, row: int, key: Any, cells: TableCells, former: TableCells) -> None:
        """Draw the cells of a row that are not as before."""
        for column in self._headings:
            if cells[column] != former.get(column):
                self.setItemData(self.index(row, column), self._roles(key, cells[column], column))

    def _item(self, key: Any, cell: TableCell, column: int) -> QStandardItem:
        item = QStandardItem()
        for role, value in self._roles(key, cell, column).items():
            if value is not None:
                item.setData(value, role)
        return item

    def _roles(self, key: Any, cell: TableCell, column: int) -> dict[int, Any]:
        """What is shown of a cell, by role; None for nothing."""
        role, heading, font = Qt.ItemDataRole, self._headings[column], QFont(self._widget.font())
        hint = cell.hint or heading.hint
        font.setBold(cell.bold)
        font.setItalic(cell.italic)
        return {
            _KEY_ROLE: key,
            role.DisplayRole: cell.text,
            _EDITED_ROLE: cell.text if cell.edited is None else cell.edited,
            _SORT_ROLE: cell.key,
            role.AccessibleTextRole: cell.said or cell.text,
            role.DecorationRole: cell.icon and self._decoration(cell.icon, heading.kind == "icon"),
            role.TextAlignmentRole: _alignment(heading),
            role.ForegroundRole: getattr(theme.colours(self._widget.palette()), cell.tone) if cell.tone else None,
            role.FontRole: font if cell.bold or cell.italic else None,
            role.CheckStateRole: _TICKS[cell.ticked] if heading.kind == "tick" else None,
            role.ToolTipRole: hint if hint.startswith("<p>") else literal_text(hint),
        }

    def flags(self, index: Index) -> Qt.ItemFlag:
        kind, flags = self._headings[index.column()].kind, Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        if kind == "tick":
            return flags | Qt.ItemFlag.ItemIsUserCheckable
        return flags | Qt.ItemFlag.ItemIsEditable if kind == "edited" else flags

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        return super().data(index, _EDITED_ROLE if role == Qt.ItemDataRole.EditRole else role)

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        key = index.data(_KEY_ROLE)
        if role == Qt.ItemDataRole.CheckStateRole:
            self.edited.emit(key, index.column(), Qt.CheckState(value) == Qt.CheckState.Checked)
            return True
        text = str(value).strip()
        if text == index.data(_EDITED_ROLE):
            return False
        self.edited.emit(key, index.column(), text)
        return True

    def _decoration(self, icon: tuple[str, str] | tuple[int, int, int], alone: bool) -> QIcon | QColor:
        if len(icon) == 3:
            if alone:
                return QColor(*icon)
            pixmap = QPixmap(ICON_SIZE, ICON_SIZE)
            pixmap.fill(QColor(*icon))
        else:
            pixmap = theme.icon(*icon).pixmap(2 * ICON_SIZE, 2 * ICON_SIZE)
        plain = QIcon(pixmap)
        plain.addPixmap(pixmap, QIcon.Mode.Selected)  # the same colours in selected rows
        return plain


def _alignment(heading: Heading) -> Qt.AlignmentFlag:
    if heading.kind == "icon":
        return Qt.AlignmentFlag.AlignCenter
    side = Qt.AlignmentFlag.AlignRight if heading.kind == "number" else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


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


class RowTable(Themed, QTableView):
    """View of a table that can be sorted by each column; F2 edits the current cell, or the name of its row.

    Attributes
    ----------
    rows : RowModel
    hint : str
        Text of the empty table.
    """

    hint = ""

    def __init__(self, name: str, headings: Mapping[int, Heading]) -> None:
        super().__init__()
        self._headings = headings
        self.rows = RowModel(headings, self)
        self.proxy = QSortFilterProxyModel(self)
        self.proxy.setSourceModel(self.rows)
        self.proxy.setSortRole(_SORT_ROLE)
        self.setModel(self.proxy)
        self.setAccessibleName(name)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.setFrameShape(QTableView.Shape.NoFrame)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(_ROW_HEIGHT)
        header = self.horizontalHeader()
        header.setMinimumSectionSize(_NARROW)
        header.setHighlightSections(False)
        header.setSortIndicatorClearable(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        self.setSortingEnabled(True)
        icons = [column for column, heading in headings.items() if heading.kind == "icon"]
        self.setItemDelegate(RowDelegate(icons, self))
        for column, heading in headings.items():
            if heading.kind in ("icon", "tick"):
                header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
            if width := _NARROW if heading.kind in ("icon", "tick") else heading.width:
                header.resizeSection(column, width)

    def key_of(self, index: Index) -> Any:
        """Return the key of the row of an index."""
        return index.data(_KEY_ROLE)

    def chosen(self) -> list[Any]:
        """Return the keys of the selected rows, in table order."""
        return [self.key_of(index) for index in sorted(self.selectionModel().selectedRows(), key=QModelIndex.row)]

    def _take_theme(self) -> None:
        self.rows.take_theme()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space:
            event.ignore()  # Space pans the views, regardless of the focus, and changes nothing
        elif event.key() == Qt.Key.Key_F2 and self.currentIndex().isValid():
            self.rename()
        else:
            super().keyPressEvent(event)

    def rename(self) -> None:
        """Let the user edit the current cell, or the name of its row; if that is not selected, of the first one that
        is. Do nothing if no column is edited."""
        current, selected = self.currentIndex(), self.selectionModel().selectedRows()
        if selected and current.siblingAtColumn(0) not in selected:
            current = min(selected, key=QModelIndex.row)
        can_be = [column for column, heading in self._headings.items() if heading.kind == "edited"]
        if can_be:
            self.edit(current.siblingAtColumn(current.column() if current.column() in can_be else can_be[0]))

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self.rows.rowCount():
            paint_hint(self, self.hint)


# A small table of numbers.

_SWATCH = 10


@dataclass(frozen=True)
class NumberRow:
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


class NumberTable(RowTable):
    """Table of numbers with headings of groups, the best marked; Ctrl+C copies tab-separated text.

    Parameters
    ----------
    name : str
        Its accessible name.
    columns : sequence of (str, str)
        Title and tooltip of each column but the first.
    """

    def __init__(self, name: str, columns: Sequence[tuple[str, str]]) -> None:
        headings = (Heading("", ""), *(Heading(title, hint, kind="number") for title, hint in columns))
        super().__init__(name, dict(enumerate(headings)))
        self.numbers: tuple[NumberRow, ...] = ()
        self.setIconSize(QSize(_SWATCH, _SWATCH))
        self.setSortingEnabled(False)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + _ROW_PAD)
        use_even_digits(self)

    def set_rows(self, rows: Iterable[NumberRow], empty: str = "") -> None:
        """Show other rows; `empty` is the text shown without rows."""
        self.numbers, self.hint = tuple(rows), empty
        columns = len(self._headings)
        self.rows.show_rows({number: _number_cells(row, columns) for number, row in enumerate(self.numbers)})
        self.clearSpans()
        for number, row in enumerate(self.numbers):
            if not row.cells:
                self.setSpan(number, 0, 1, columns)
        self.horizontalHeader().resizeSections()  # Qt looks at cells that change, not at new rows
        self.viewport().update()

    def text(self, chosen: Collection[int] = ()) -> str:
        """Return some rows, or all, as tab-separated text."""
        rows = [self.numbers[number] for number in chosen] or self.numbers
        head = [heading.title for heading in self._headings.values()]
        return "\n".join("\t".join(cells) for cells in [head, *((row.name, *row.cells) for row in rows)])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(self.text(self.chosen()))
        else:
            super().keyPressEvent(event)


def _number_cells(row: NumberRow, columns: int) -> TableCells:
    texts = row.name, *row.cells, *[""] * (columns - 1 - len(row.cells))
    tone = "good" if row.is_best else "" if row.cells else "muted"
    plain = TableCell(hint=row.hint or row.name, tone=tone, bold=row.is_best or not row.cells, italic=row.is_italic)
    return {column: plain._replace(text=text, icon=None if column else row.colour) for column, text in enumerate(texts)}
