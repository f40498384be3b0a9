"""What has come of the frames of a batch, a row each."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtGui import QBrush, QPaintEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from gui import theme
from gui.widgets.hint import paint_hint
from gui.widgets.plain_text import as_it_is
from gui.widgets.row_model import Index, RowModel
from ilf.batch import FrameOutcome, FrameStatus
from ilf.confidence import MEDIAN_MEANING, MEDIAN_NAME
from ilf.number_words import UNKNOWN, millimetres

_HEADERS = (
    ("Frame", "Its name in the batch"),
    ("Status", "Whether it was completed"),
    ("Missing", "Share of the pixels without depth, before and after"),
    (f"{MEDIAN_NAME} [mm]", MEDIAN_MEANING),
    ("Seconds", "How long it took"),
    ("Message", "Why it failed, or what there is to know of the result"),
)
_FRAME, _STATUS, _MISSING, _ERROR, _SECONDS, _MESSAGE = range(len(_HEADERS))
_WIDTHS = (150, 84, 110, 196, 70)


class OutcomeModel(RowModel[FrameOutcome]):
    """Rows of outcomes, in the order in which they came."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(len(_HEADERS), parent)
        self._parent = parent

    def key(self, row: FrameOutcome) -> str:
        return row.frame

    def look(self, row: FrameOutcome, column: int) -> str:
        looks = {
            _FRAME: row.frame,
            _STATUS: row.status.value,
            _MISSING: _missing(row),
            _ERROR: UNKNOWN if row.expected_error_median is None else millimetres(row.expected_error_median),
            _SECONDS: UNKNOWN if row.seconds is None else f"{row.seconds:.1f}",
            _MESSAGE: row.message,
        }
        return looks[column]

    def add(self, outcomes: list[FrameOutcome]) -> None:
        """More have come."""
        first = len(self.rows)
        self.beginInsertRows(QModelIndex(), first, first + len(outcomes) - 1)
        self.rows += outcomes
        self.endInsertRows()

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        looks = {
            Qt.ItemDataRole.DisplayRole: _HEADERS[section][0],
            Qt.ItemDataRole.ToolTipRole: _HEADERS[section][1],
            Qt.ItemDataRole.TextAlignmentRole: _alignment(section),
        }
        return looks.get(Qt.ItemDataRole(role))

    def data(self, index: Index, role: int = 0) -> Any:
        row, column = self.rows[index.row()], index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            return self.look(row, column)
        if role == Qt.ItemDataRole.ToolTipRole:
            return as_it_is(row.message or row.frame)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.ForegroundRole and row.status is FrameStatus.FAILED and column == _STATUS:
            return QBrush(theme.colours(self._parent.palette()).error)
        return None


class OutcomeTable(QTableView):
    """The rows.

    Signals
    -------
    opened(object)
        The outcome that was double-clicked, or that Enter was pressed on.
    """

    opened = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.outcomes = OutcomeModel(self)
        self.setModel(self.outcomes)
        self.setAccessibleName("What has come of the frames")
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        self.horizontalHeader().setStretchLastSection(True)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        for column, width in enumerate(_WIDTHS):
            self.setColumnWidth(column, width)
        self.activated.connect(lambda index: self.opened.emit(self.outcomes.rows[index.row()]))

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self.outcomes.rows:
            paint_hint(self, "What comes of each frame is listed here; a double-click opens it.")


def _alignment(column: int) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignRight if column in (_MISSING, _ERROR, _SECONDS) else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


def _missing(row: FrameOutcome) -> str:
    if row.missing_before is None or row.missing_after is None or not row.pixels:
        return UNKNOWN
    return f"{row.missing_before / row.pixels:.1%} → {row.missing_after / row.pixels:.1%}"
