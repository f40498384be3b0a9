"""The panel of numbers: statistics of a block or a rectangle, and what has been measured."""

from __future__ import annotations

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

from gui import theme
from gui.inspect.statistics_table import StatisticsTable
from gui.widgets.plain_text import PlainLabel, as_it_is
from ilf.inspection import SurfaceStatistics

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
