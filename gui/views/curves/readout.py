"""Combined legend and readout: a row for each curve with its numbers, in columns of fixed position."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from ...base import theme
from ...widgets.basics import literal_text, use_even_digits

_PAD = 6
_KEY = 14
_GAP = 7
_NAME_SHARE = 3
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


class Column(NamedTuple):
    """Name of a column, and its widest text, which sets its width."""

    name: str
    widest: str


class Row(NamedTuple):
    """One curve: name, style, a text for each column, and the limit at which it ended before it converged, if any."""

    name: str
    colour: tuple[int, int, int]
    dashed: bool
    texts: tuple[str, ...]
    limit: str = ""

    @property
    def title(self) -> str:
        """The name, and that it has not converged."""
        return f"{self.name}: not converged" if self.limit else self.name


class Readout(QWidget):
    """Rows of numbers. The last columns and rows are omitted if they do not fit."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Numbers of the curves")
        use_even_digits(self)
        self._columns: list[Column] = []
        self._rows: list[Row] = []
        self._max_rows = 1
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)

    def show_rows(self, columns: Sequence[Column], rows: Sequence[Row]) -> None:
        """Show these rows, each with a text for every column."""
        count = len(self._rows)
        self._columns, self._rows = list(columns), list(rows)
        if len(rows) != count:
            self.updateGeometry()
        limits = "\n".join(f"{row.title}. {row.limit}" for row in rows if row.limit)
        self.setToolTip(literal_text(limits) if limits else "")
        self.setAccessibleDescription("\n".join(filter(None, (self.text, limits))))
        self.update()

    def set_max_rows(self, max_rows: int) -> None:
        """Set the maximum number of rows."""
        self._max_rows = max(max_rows, 1)
        self.updateGeometry()

    @property
    def text(self) -> str:
        """The visible text, line by line."""
        shown = self._shown_columns()
        return "\n".join(
            "   ".join([row.title, *(f"{column.name} {row.texts[at]}".strip() for at, column in shown)])
            for row in self._shown_rows()
        )

    def sizeHint(self) -> QSize:
        return QSize(260, self._row_height * max(min(len(self._rows), self._max_rows), 1) + 6)

    def minimumSizeHint(self) -> QSize:
        return QSize(100, self.sizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        colours = theme.colours(self.palette())
        columns, rows = self._shown_columns(), self._shown_rows()
        left = self._name_end
        for number, row in enumerate(rows):
            line = QRect(_PAD, 3 + number * self._row_height, self.width() - 2 * _PAD, self._row_height)
            pen = QPen(QColor(*row.colour), 3)
            if row.dashed:
                pen.setDashPattern([1.2, 1.0])
                pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(line.left(), line.center().y(), line.left() + _KEY, line.center().y())
            painter.setPen(colours.warning if row.limit else colours.text)
            room = QRect(line.left() + _KEY + 6, line.top(), left - line.left() - _KEY - 6, line.height())
            name = self.fontMetrics().elidedText(row.title, Qt.TextElideMode.ElideRight, room.width())
            painter.drawText(room, _LEFT, name)
            x = left
            for at, column in columns:
                cell = QRect(x + _GAP, line.top(), self._width_of(column), line.height())
                painter.setPen(colours.muted)
                painter.drawText(cell, _LEFT, column.name)
                painter.setPen(colours.text)
                painter.drawText(cell, _RIGHT, row.texts[at])
                x = cell.right() + 1
        hidden = len(self._rows) - len(rows)
        if hidden:
            painter.setPen(colours.muted)
            painter.drawText(self.rect().adjusted(0, 0, -2, -1), _RIGHT, f"+{hidden}")

    @property
    def _row_height(self) -> int:
        return self.fontMetrics().height() + 2

    @property
    def _name_end(self) -> int:
        """Right end of the names: width of the widest, up to a share of the widget, twice that for "not converged"."""
        widest = max((self.fontMetrics().horizontalAdvance(row.title) for row in self._rows), default=0)
        shares = 2 if any(row.limit for row in self._rows) else 1
        return _PAD + _KEY + 6 + min(widest + 1, shares * self.width() // _NAME_SHARE)

    def _width_of(self, column: Column) -> int:
        text = f"{column.name} {column.widest}" if column.name else column.widest
        return self.fontMetrics().horizontalAdvance(text)

    def _shown_columns(self) -> list[tuple[int, Column]]:
        room = self.width() - _PAD - self._name_end
        shown = []
        for at, column in enumerate(self._columns):
            room -= self._width_of(column) + _GAP
            if room < 0:
                break
            shown.append((at, column))
        return shown

    def _shown_rows(self) -> list[Row]:
        return self._rows[: self._max_rows]
