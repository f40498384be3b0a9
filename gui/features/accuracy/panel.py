"""The accuracy panel: errors against ground truth, or of hold-out tests."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QTabWidget, QToolButton, QVBoxLayout, QWidget

from ...widgets.basics import Message, PlainLabel, literal_text
from ...widgets.work_row import WorkRow
from . import rows as texts
from .rows import NumberTable, Row

NO_FRAME = "Open a frame to evaluate it."


class AccuracyPanel(QWidget):
    """The panel *Accuracy*: shows errors and emits the user's requests.

    Signals
    -------
    became_visible()
        The panel became visible: evaluate what changed meanwhile.
    pixels_changed()
        The user selected filled pixels, or all.
    part_changed()
        The user selected the hold-out errors of all blocks, or of the selected one.
    cancelled()
        The user cancelled the test.
    """

    became_visible = Signal()
    pixels_changed = Signal()
    part_changed = Signal()
    cancelled = Signal()

    def __init__(self, actions: Sequence[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.source = Message()
        buttons = QHBoxLayout()
        buttons.setSpacing(4)
        for action in actions:
            button = QToolButton()
            button.setDefaultAction(action)
            if action is not actions[-1]:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            buttons.addWidget(button)
        buttons.addStretch(1)
        self.work = WorkRow("hold-out test")
        self.work.cancelled.connect(self.cancelled)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.addTab(self._ground_truth_page(), "Ground truth")
        self.tabs.addTab(self._hold_out_page(), "Hold-out")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 4, 4)
        layout.setSpacing(6)
        layout.addWidget(self.source)
        layout.addLayout(buttons)
        layout.addWidget(self.work)
        layout.addWidget(self.tabs, 1)
        self.setMinimumSize(260, 150)

    def _ground_truth_page(self) -> QWidget:
        self.pixels = QComboBox()
        self.pixels.addItems(["Filled pixels", "All pixels"])
        self.pixels.setToolTip("Evaluate only filled pixels, or also pixels with known depth")
        self.pixels.activated.connect(lambda _: self.pixels_changed.emit())
        columns = [texts.RMSE, texts.MAE, texts.MEDIAN, texts.WITHIN]
        self.ground_truth_table = NumberTable("Errors against ground truth", columns)
        return _page("&Evaluate", self.pixels, None, self.ground_truth_table)

    def _hold_out_page(self) -> QWidget:
        self.part = QComboBox()
        self.part.addItems(["All blocks", "Selected block"])
        self.part.setToolTip("Show the errors of all blocks together, or of the selected block")
        self.part.activated.connect(lambda _: self.part_changed.emit())
        self.tested = Message()
        columns = [texts.RMSE, texts.MAE, texts.MEDIAN, texts.PIXELS]
        self.hold_out_table = NumberTable("Hold-out errors", columns)
        return _page("Errors &of", self.part, self.tested, self.hold_out_table)

    @property
    def every(self) -> bool:
        """Whether all pixels are evaluated, not only filled ones."""
        return self.pixels.currentIndex() == 1

    @property
    def over_selected(self) -> bool:
        """Whether the errors of the selected block are shown."""
        return self.part.currentIndex() == 1

    def show_source(self, text: str, path: str = "") -> None:
        """Show the source of the ground truth, or that there is none; `path` is the file."""
        self.source.show_message(text)
        self.source.setToolTip(literal_text(path))

    def show_ground_truth(self, rows: Sequence[Row], empty: str) -> None:
        """Show errors against ground truth, or the reason why there are none."""
        self.ground_truth_table.set_rows(rows, empty)
        self.pixels.setEnabled(bool(rows))

    def show_hold_out(self, rows: Sequence[Row], text: str, tone: str, empty: str) -> None:
        """Show hold-out errors and the settings of the test, or the reason why there are none."""
        self.tested.setVisible(bool(text))
        self.tested.show_message(text, tone)
        self.hold_out_table.set_rows(rows, empty)
        self.part.setEnabled(bool(rows))

    def set_chosen(self, name: str) -> None:
        """Set the name of the selected block; "" for none."""
        with QSignalBlocker(self.part):
            self.part.setItemText(1, f"{name} only" if name else "Selected block (none selected)")

    def show_page(self, hidden: bool) -> None:
        """Show the page of the hold-out test, or of the ground truth."""
        self.tabs.setCurrentIndex(int(hidden))

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.became_visible.emit()


def _page(text: str, choice: QComboBox, message: Message | None, table: NumberTable) -> QWidget:
    page = QWidget()
    row = QHBoxLayout()
    row.setSpacing(6)
    label = PlainLabel(text)
    label.setBuddy(choice)
    row.addWidget(label)
    row.addWidget(choice)
    row.addStretch(1)
    unit = PlainLabel("Errors in mm")
    unit.setEnabled(False)
    row.addWidget(unit)
    column = QVBoxLayout(page)
    column.setContentsMargins(2, 6, 2, 0)
    column.setSpacing(4)
    column.addLayout(row)
    if message is not None:
        column.addWidget(message)
    column.addWidget(table, 1)
    return page
