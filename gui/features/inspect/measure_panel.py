"""The panel of numbers: statistics of a block or a rectangle, and what has been measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
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
from ...widgets.basics import PlainLabel, as_it_is

# Statistics of raw depth and of the result, side by side.

_ROWS = (
    ("Pixels", "How many there are"),
    ("Missing", "Share of them without depth"),
    ("Mean", "Of the known depth"),
    ("Median", "Of the known depth"),
    ("Std. deviation", "Standard deviation of the known depth"),
    ("Range", "Least and largest known depth"),
    (
        "Noise",
        "What differs from pixel to pixel, whatever the surface's shape: from the median second difference of "
        "neighbours. Depth that comes in steps shows less than it has",
    ),
    ("Plane RMS", "Root mean square distance from the plane that fits best, without outliers"),
    ("Outliers", "Share of the known depth that is farther from that plane than 3.5 robust deviations"),
    ("Tilt", "Angle between that plane's normal and the camera's axis: 0° faces the camera"),
    ("Quadric RMS", "Root mean square distance from the quadric that fits best, without outliers"),
)


class StatisticsTable(QTableWidget):
    """A row for each number, a column for raw depth and one for the result."""

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
        """All rows are to be seen: the panel around it scrolls."""
        super().showEvent(event)
        self.setFixedHeight(self.verticalHeader().length() + self.horizontalHeader().height() + 2 * self.frameWidth())

    def show_statistics(self, raw: SurfaceStatistics | None, result: SurfaceStatistics | None) -> None:
        """Write numbers; nothing where there are none."""
        for column, found in enumerate((raw, result)):
            texts = [""] * len(_ROWS) if found is None else _texts(found)
            for cells, text in zip(self._cells, texts, strict=True):
                cells[column].setText(text)

    def as_text(self) -> str:
        """The numbers as lines with tabs between columns."""
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
    """A length in metres, a dash for none."""
    return f"{length:.3f} m" if math.isfinite(length) else "–"


def _millimetres(length: float) -> str:
    """A small length with its unit, a dash for none."""
    return f"{millimetres(length)} mm" if math.isfinite(length) else UNKNOWN


def degrees(angle: float) -> str:
    """An angle, a dash for none."""
    return f"{angle:.1f}°" if math.isfinite(angle) else "–"


_LEAST_LIST = 96
_COLUMNS = (
    ("", "Measurement, and which of its stretches"),
    ("Distance", "Straight from point to point"),
    ("Height", "How much higher the second point lies"),
    ("Angle", "At the first point of the stretch, to the one before"),
)


@dataclass(frozen=True)
class MeasuredRow:
    """A stretch of a measurement, as it is listed.

    Attributes
    ----------
    chain : int
        Which measurement it belongs to.
    name, distance, height, angle : str
    filled : bool
        Whether an end of it lies on depth that was filled, not measured.
    """

    chain: int
    name: str
    distance: str
    height: str
    angle: str
    filled: bool


class MeasurePanel(QWidget):
    """Statistics on one page, measurements on the other.

    Parameters
    ----------
    tools : sequence of QAction
        What the rectangle and what points are drawn with.
    copying, actions : sequence of QAction
        On the statistics, and on the measurements.

    Signals
    -------
    shown(), hidden()
        It can be seen again, so that what has come meanwhile is to be drawn; or no longer.
    subject_wished(bool)
        Whether statistics are wanted of the rectangle, and not of the chosen block.
    reference_wished(bool)
        Whether heights are wanted over the chosen block's plane, and not along the image's upright.
    """

    shown = Signal()
    hidden = Signal()
    subject_wished = Signal(bool)
    reference_wished = Signal(bool)

    def __init__(
        self,
        tools: Sequence[QAction],
        copying: Sequence[QAction],
        actions: Sequence[QAction],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.subject = QComboBox()
        self.subject.addItems(["Chosen block", "Rectangle"])
        self.subject.setAccessibleName("What statistics are of")
        self.subject.setToolTip("Statistics of the chosen block, or of the rectangle if there is one")
        self.subject.activated.connect(lambda index: self.subject_wished.emit(index == 1))
        self._name = PlainLabel()
        self._name.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.statistics = StatisticsTable()
        self._reason, self._message = _note(), _note()
        self._list = _MeasuredList()
        self.reference = QComboBox()
        self.reference.addItems(["image's upright", "chosen block's plane"])
        self.reference.setAccessibleName("What heights are measured along")
        self.reference.setToolTip(
            "Heights along the image's upright, or over the plane of the block that is chosen now; "
            "the camera does not know which way is up in the room"
        )
        self.reference.activated.connect(lambda index: self.reference_wished.emit(index == 1))

        for box in (self.subject, self.reference):
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            box.setMinimumContentsLength(9)
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
        lengths, height = _column(), PlainLabel("Heights:")
        height.setBuddy(self.reference)
        lengths.addLayout(_row(height, (self.reference, 1), buttons[1], *(_button(action) for action in actions)))
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
        """What the statistics are of."""
        with QSignalBlocker(self.subject):
            self.subject.setCurrentIndex(int(of_region))
        self._name.setText(name)
        self._name.setToolTip(as_it_is(name))

    def show_statistics(self, raw: SurfaceStatistics | None, result: SurfaceStatistics | None, note: str) -> None:
        """Numbers, and what there is to say of them."""
        self.statistics.show_statistics(raw, result)
        self._reason.setText(note)
        self._reason.setVisible(bool(note))

    def show_reference(self, name: str) -> None:
        """The block whose plane heights are measured over; "" for the image's upright."""
        with QSignalBlocker(self.reference):
            self.reference.setItemText(1, f"plane of {name}" if name else "chosen block's plane")
            self.reference.setCurrentIndex(int(bool(name)))

    def show_measured(self, rows: Sequence[MeasuredRow], message: str) -> None:
        """The measurements, and what there is to say of them."""
        self._list.show_rows(rows)
        self._message.setText(message)
        self._message.setVisible(bool(message))

    def chosen(self) -> set[int]:
        """Measurements that are chosen in the list."""
        return self._list.chosen()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.hidden.emit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._take_theme()

    def _take_theme(self) -> None:
        muted = theme.colours(self.palette()).muted.name()
        for label in (self._reason, self._message, self._name):
            label.setStyleSheet(f"color: {muted};")


class _MeasuredList(QTableWidget):
    """A row for every stretch of every measurement."""

    def __init__(self) -> None:
        super().__init__(0, 4)
        self._rows: list[MeasuredRow] = []
        for column, (name, help) in enumerate(_COLUMNS):
            title = QTableWidgetItem(name)
            title.setToolTip(help)
            self.setHorizontalHeaderItem(column, title)
        self.setAccessibleName("Measurements")
        self.setToolTip("Measurements; those that are chosen are deleted first")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setFrameShape(QTableWidget.Shape.NoFrame)
        self.setMinimumHeight(_LEAST_LIST)
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
        for n, row in enumerate(rows):
            for column, text in enumerate((row.name, row.distance, row.height, row.angle)):
                item = self.item(n, column)
                if item is None:
                    item = QTableWidgetItem()
                    item.setTextAlignment(
                        Qt.AlignmentFlag.AlignVCenter
                        | (Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft)
                    )
                    self.setItem(n, column, item)
                font = QFont(self._font)
                font.setItalic(row.filled)
                item.setFont(font)
                item.setText(text)
                item.setToolTip("An end of it lies on depth that was filled, not measured" if row.filled else "")

    def chosen(self) -> set[int]:
        return {self._rows[index.row()].chain for index in self.selectionModel().selectedRows()}


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
