"""Combined legend and readout: a row for each curve with the numbers of one iteration, in columns of fixed position."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from ilf._runtime.formatting import length_text
from ilf.data.results import EdgeAwareRecord, IterationRecord, PassBandRecord

from ...base import theme
from ...widgets.basics import literal_text, use_even_digits
from .curve import Curve, legible

Number = tuple[str, str, str]
"""Name of a column, its widest text, which sets its width, and the text in it."""

_LENGTH = "0.000 mm"


def numbers_of(record: IterationRecord, has: Mapping[str, bool], by_time: bool, alone: bool) -> Iterator[Number]:
    """The numbers of an iteration, the most important first.

    Parameters
    ----------
    record : IterationRecord
    has : mapping of str to bool
        Whether any of the curves shown has an "error", or a "held_out".
    by_time : bool
        Whether the time comes first.
    alone : bool
        Whether it is of the only curve: then with what only some filters have.
    """
    time = "", "000.00 s", "–" if math.isnan(record.seconds) else f"{record.seconds:.2f} s"
    yield "i", "0000", f"{record.i}"
    if by_time:
        yield time
    yield "σ", _LENGTH, length_text(record.sigma_i)
    if has["error"]:
        yield "err", _LENGTH, length_text(record.error)
    if has["held_out"]:
        yield "hold-out", _LENGTH, length_text(record.held_out)
    yield "L1", "000,000 m", f"{record.l1:,.4g} m" if record.l1 < 1e4 else f"{record.l1:,.0f} m"
    if alone and isinstance(record, PassBandRecord):
        yield "radii", "000.0 × 000.0", f"{record.radii[0]:.1f} × {record.radii[1]:.1f}"
    elif alone and isinstance(record, EdgeAwareRecord):
        yield "cells", "00 px", f"{record.cell} px"
        yield "round", "0", f"{record.round or '–'}"
    yield "stage", "000", f"{record.stage}"
    yield "residual", _LENGTH, length_text(record.residual)
    if not by_time:
        yield time


_PAD = 6
_KEY = 14
_GAP = 7
_NAME_SHARE = 3
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


class Readout(QWidget):
    """Rows of numbers. The last columns and rows are omitted if they do not fit."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Numbers of the curves")
        use_even_digits(self)
        self._rows: list[tuple[Curve, Sequence[Number]]] = []
        self._max_rows = 1
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)

    def show_rows(self, rows: Sequence[tuple[Curve, Sequence[Number]]]) -> None:
        """Show these curves, each with its numbers, in the same columns."""
        count, self._rows = len(self._rows), list(rows)
        if len(rows) != count:
            self.updateGeometry()
        limits = "\n".join(f"{curve.title}. {curve.limit}" for curve, _ in rows if curve.limit)
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
        return "\n".join(
            "   ".join([curve.title, *(f"{name} {text}".strip() for name, _, text in self._fitting(numbers))])
            for curve, numbers in self._rows[: self._max_rows]
        )

    def sizeHint(self) -> QSize:
        return QSize(260, self._row_height * max(min(len(self._rows), self._max_rows), 1) + 6)

    def minimumSizeHint(self) -> QSize:
        return QSize(100, self.sizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        colours = theme.colours(self.palette())
        left = self._name_end
        for row, (curve, numbers) in enumerate(self._rows[: self._max_rows]):
            line = QRect(_PAD, 3 + row * self._row_height, self.width() - 2 * _PAD, self._row_height)
            pen = QPen(QColor(*legible(curve.colour, colours.is_dark)), 3)
            if curve.dashed:
                pen.setDashPattern([1.2, 1.0])
                pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(line.left(), line.center().y(), line.left() + _KEY, line.center().y())
            painter.setPen(colours.warning if curve.limit else colours.text)
            room = QRect(line.left() + _KEY + 6, line.top(), left - line.left() - _KEY - 6, line.height())
            name = self.fontMetrics().elidedText(curve.title, Qt.TextElideMode.ElideRight, room.width())
            painter.drawText(room, _LEFT, name)
            x = left
            for name, widest, text in self._fitting(numbers):
                cell = QRect(x + _GAP, line.top(), self._width_of(name, widest), line.height())
                painter.setPen(colours.muted)
                painter.drawText(cell, _LEFT, name)
                painter.setPen(colours.text)
                painter.drawText(cell, _RIGHT, text)
                x = cell.right() + 1
        hidden = len(self._rows) - self._max_rows
        if hidden > 0:
            painter.setPen(colours.muted)
            painter.drawText(self.rect().adjusted(0, 0, -2, -1), _RIGHT, f"+{hidden}")

    @property
    def _row_height(self) -> int:
        return self.fontMetrics().height() + 2

    @property
    def _name_end(self) -> int:
        """Right end of the names: width of the widest, up to a share of the widget, twice that for "not converged"."""
        widest = max((self.fontMetrics().horizontalAdvance(curve.title) for curve, _ in self._rows), default=0)
        shares = 2 if any(curve.limit for curve, _ in self._rows) else 1
        return _PAD + _KEY + 6 + min(widest + 1, shares * self.width() // _NAME_SHARE)

    def _width_of(self, name: str, widest: str) -> int:
        return self.fontMetrics().horizontalAdvance(f"{name} {widest}" if name else widest)

    def _fitting(self, numbers: Sequence[Number]) -> Iterator[Number]:
        """The first numbers, as many as have room."""
        room = self.width() - _PAD - self._name_end
        for name, widest, text in numbers:
            room -= self._width_of(name, widest) + _GAP
            if room < 0:
                return
            yield name, widest, text
