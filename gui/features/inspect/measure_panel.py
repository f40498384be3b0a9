"""Panel *Measure*: statistics of a block or a rectangle, and measurements."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QFont, QHideEvent, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QTableWidget,
    QTableWidgetItem,
    QTabWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.evaluation.statistics import SurfaceStatistics

from ...base import theme
from ...widgets.basics import PlainLabel, Themed, literal_text

# Statistics of raw depth and of the result, side by side.

_ROWS = (
    ("Pixels", "Number of pixels"),
    ("Missing", "Share of the pixels without depth"),
    ("Mean", "Mean of the known depth"),
    ("Median", "Median of the known depth"),
    ("Std. deviation", "Standard deviation of the known depth"),
    ("Range", "Minimum and maximum of the known depth"),
    (
        "Noise",
        "Variation from pixel to pixel, independent of the surface's shape: from the median second difference of "
        "neighbours. Quantised depth shows less noise than it has",
    ),
    ("Plane RMS", "Root mean square distance from the best-fitting plane, without outliers"),
    ("Outliers", "Share of the known depth farther from that plane than 3.5 robust standard deviations"),
    ("Tilt", "Angle between that plane's normal and the camera's axis; 0° faces the camera"),
    ("Quadric RMS", "Root mean square distance from the best-fitting quadric, without outliers"),
)


class StatisticsTable(QTableWidget):
    """Table with a row per statistic, a column for raw depth and one for the result."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(len(_ROWS), 2, parent)
        self.setHorizontalHeaderLabels(["Raw", "Result"])
        self.setAccessibleName("Statistics of raw depth and result")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setFrameShape(QTableWidget.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        height = self.fontMetrics().height() + 3
        for header in (self.horizontalHeader(), self.verticalHeader()):
            header.setSectionsClickable(False)
            header.setHighlightSections(False)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.verticalHeader().setDefaultSectionSize(height)
        self.verticalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        tabular = QFont(self.font())
        tabular.setFeature(QFont.Tag("tnum"), 1)
        self._cells: list[list[QTableWidgetItem]] = []
        for row, (name, help) in enumerate(_ROWS):
            title = QTableWidgetItem(name)
            title.setToolTip(help)
            self.setVerticalHeaderItem(row, title)
            self._cells.append([QTableWidgetItem(), QTableWidgetItem()])
            for column, item in enumerate(self._cells[row]):
                item.setFont(tabular)
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                item.setToolTip(f"{name}: {help[0].lower()}{help[1:]}")
                self.setItem(row, column, item)

    def showEvent(self, event: QShowEvent) -> None:
        """Fit the height to all rows; the panel around the table scrolls."""
        super().showEvent(event)
        self.setFixedHeight(self.verticalHeader().length() + self.horizontalHeader().height() + 2 * self.frameWidth())

    def show_statistics(self, raw: SurfaceStatistics | None, result: SurfaceStatistics | None) -> None:
        """Show statistics; empty cells for None."""
        for column, found in enumerate((raw, result)):
            texts = [""] * len(_ROWS) if found is None else _texts(found)
            for cells, text in zip(self._cells, texts, strict=True):
                cells[column].setText(text)

    def as_text(self) -> str:
        """Return the table as tab-separated lines."""
        lines = ["\tRaw\tResult"]
        for (name, _), cells in zip(_ROWS, self._cells, strict=True):
            lines.append("\t".join([name, *(cell.text() for cell in cells)]))
        return "\n".join(lines)


def _texts(found: SurfaceStatistics) -> list[str]:
    plane, quadric = found.plane, found.quadric
    return [
        f"{found.pixels:,}",
        f"{100 * found.missing_share:.1f} %",
        metres(found.mean),
        metres(found.median),
        _millimetres(found.deviation),
        f"{found.least:.2f}–{found.largest:.2f} m" if found.known else "–",
        _millimetres(found.noise),
        "–" if plane is None else _millimetres(plane.rms),
        "–" if plane is None else f"{100 * plane.outliers:.1f} %",
        "–" if plane is None else degrees(plane.tilt),
        "–" if quadric is None else _millimetres(quadric.rms),
    ]


def metres(length: float) -> str:
    """Format a length in metres; a dash for NaN."""
    return f"{length:.3f} m" if math.isfinite(length) else "–"


def _millimetres(length: float) -> str:
    """Format a small length in millimetres; a dash for NaN."""
    return f"{millimetres(length)} mm" if math.isfinite(length) else UNKNOWN


def degrees(angle: float) -> str:
    """Format an angle in degrees; a dash for NaN."""
    return f"{angle:.1f}°" if math.isfinite(angle) else "–"


_MIN_LIST_HEIGHT = 96
_COLUMNS = (
    ("", "Number of the measurement"),
    ("Distance", "Straight-line distance of the end points"),
    ("Height", "Height of the second point above the first, along the image's vertical"),
)
MeasuredRow = tuple[str, str, str, bool]
"""Number, distance, height, and whether an end lies on filled depth, not measured depth."""


class MeasurePanel(Themed, QWidget):
    """Panel with a page of statistics and a page of measurements.

    Parameters
    ----------
    tools : sequence of QAction
        Tools for the rectangle and for the points.
    copying, actions : sequence of QAction
        Commands on the statistics, and on the measurements.

    Signals
    -------
    shown(), hidden()
        The panel has become visible, so that it must be updated; or hidden.
    subject_requested(bool)
        Whether to show statistics of the rectangle instead of the selected block.
    """

    shown = Signal()
    hidden = Signal()
    subject_requested = Signal(bool)

    def __init__(
        self,
        tools: Sequence[QAction],
        copying: Sequence[QAction],
        actions: Sequence[QAction],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.subject = QComboBox()
        self.subject.addItems(["Selected block", "Rectangle"])
        self.subject.setAccessibleName("Region of the statistics")
        self.subject.setToolTip("Statistics of the selected block, or of the rectangle if there is one")
        self.subject.activated.connect(lambda index: self.subject_requested.emit(index == 1))
        self._name = PlainLabel()
        self._name.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.statistics = StatisticsTable()
        self._reason, self._message = _note(), _note()
        self._list = _MeasuredList()
        self.subject.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.subject.setMinimumContentsLength(9)
        numbers, buttons = _column(), [_button(action) for action in tools]
        numbers.addLayout(_row(self.subject, (self._name, 1), buttons[0], *(_button(action) for action in copying)))
        numbers.addWidget(self.statistics)
        numbers.addWidget(self._reason)
        numbers.addStretch(1)
        scroll = QScrollArea()
        scroll.setWidget(_page(numbers))
        scroll.setWidgetResizable(True)
        scroll.setFrameShape(QScrollArea.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        lengths = _column()
        lengths.addLayout(_row((QWidget(), 1), buttons[1], *(_button(action) for action in actions)))
        lengths.addWidget(self._message)
        lengths.addWidget(self._list, 1)
        self.pages = QTabWidget()
        self.pages.setDocumentMode(True)
        self.pages.setAccessibleName("Statistics and measurements")
        self.pages.addTab(scroll, "Statistics")
        self.pages.addTab(_page(lengths), "Measurements")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.pages)
        self.setMinimumSize(240, 120)
        self._take_theme()

    def show_subject(self, of_region: bool, name: str) -> None:
        """Show the region of the statistics."""
        with QSignalBlocker(self.subject):
            self.subject.setCurrentIndex(int(of_region))
        self._name.setText(name)
        self._name.setToolTip(literal_text(name))

    def show_statistics(self, raw: SurfaceStatistics | None, result: SurfaceStatistics | None, note: str) -> None:
        """Show statistics and a note."""
        self.statistics.show_statistics(raw, result)
        self._reason.setText(note)
        self._reason.setVisible(bool(note))

    def show_measured(self, rows: Sequence[MeasuredRow], message: str) -> None:
        """Show the measurements and a message."""
        self._list.show_rows(rows)
        self._message.setText(message)
        self._message.setVisible(bool(message))

    def chosen(self) -> set[int]:
        """Return the numbers of the measurements selected in the list."""
        return self._list.chosen()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.hidden.emit()

    def _take_theme(self) -> None:
        muted = theme.colours(self.palette()).muted.name()
        for label in (self._reason, self._message, self._name):
            label.setStyleSheet(f"color: {muted};")


class _MeasuredList(QTableWidget):
    """Table with a row for every measurement."""

    def __init__(self) -> None:
        super().__init__(0, len(_COLUMNS))
        self._rows: list[MeasuredRow] = []
        for column, (name, help) in enumerate(_COLUMNS):
            title = QTableWidgetItem(name)
            title.setToolTip(help)
            self.setHorizontalHeaderItem(column, title)
        self.setAccessibleName("Measurements")
        self.setToolTip("Measurements; Delete removes the selected ones, or all")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setFrameShape(QTableWidget.Shape.NoFrame)
        self.setMinimumHeight(_MIN_LIST_HEIGHT)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 4)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
        header.setHighlightSections(False)
        self._font = QFont(self.font())
        self._font.setFeature(QFont.Tag("tnum"), 1)

    def show_rows(self, rows: Sequence[MeasuredRow]) -> None:
        if list(rows) == self._rows:
            return
        self._rows = list(rows)
        self.setRowCount(len(rows))
        for n, (*texts, filled) in enumerate(rows):
            for column, text in enumerate(texts):
                item = self.item(n, column)
                if item is None:
                    item = QTableWidgetItem()
                    item.setTextAlignment(
                        Qt.AlignmentFlag.AlignVCenter
                        | (Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft)
                    )
                    self.setItem(n, column, item)
                font = QFont(self._font)
                font.setItalic(filled)
                item.setFont(font)
                item.setText(text)
                item.setToolTip("An end point lies on filled depth, not measured depth" if filled else "")

    def chosen(self) -> set[int]:
        return {index.row() for index in self.selectionModel().selectedRows()}


def _note() -> QLabel:
    label = PlainLabel()
    label.setWordWrap(True)
    label.hide()
    return label


def _button(action: QAction) -> QToolButton:
    button = QToolButton()
    button.setDefaultAction(action)
    button.setAutoRaise(True)
    return button


def _column() -> QVBoxLayout:
    column = QVBoxLayout()
    column.setContentsMargins(6, 4, 6, 4)
    column.setSpacing(4)
    return column


def _page(layout: QVBoxLayout) -> QWidget:
    page = QWidget()
    page.setLayout(layout)
    return page


def _row(*parts: QWidget | tuple[QWidget, int]) -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(3)
    for part in parts:
        widget, stretch = part if isinstance(part, tuple) else (part, 0)
        row.addWidget(widget, stretch)
    return row
