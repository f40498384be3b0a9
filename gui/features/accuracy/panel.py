"""The panel that says how far off the depth is: against the truth, or on hidden depth."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QTabWidget, QToolButton, QVBoxLayout, QWidget

from ...widgets.basics import Message, PlainLabel, as_it_is
from ...widgets.work_row import WorkRow
from . import rows as texts
from .rows import NumberTable, Row

NO_FRAME = "Open a frame to judge it."


class AccuracyPanel(QWidget):
    """Shows and reports wishes.

    Signals
    -------
    looked_at()
        It can be seen again: what changed meanwhile is to be judged.
    pixels_changed()
        The user wants filled pixels judged, or all.
    part_changed()
        The user wants the test on hidden depth for all blocks, or for the chosen one.
    cancelled()
        The user wants the test to end.
    """

    looked_at = Signal()
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
        self.work = WorkRow("test on hidden depth")
        self.work.cancelled.connect(self.cancelled)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.addTab(self._truth_page(), "Truth")
        self.tabs.addTab(self._hidden_page(), "Hidden depth")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 4, 4)
        layout.setSpacing(6)
        layout.addWidget(self.source)
        layout.addLayout(buttons)
        layout.addWidget(self.work)
        layout.addWidget(self.tabs, 1)
        self.setMinimumSize(260, 150)

    def _truth_page(self) -> QWidget:
        self.pixels = QComboBox()
        self.pixels.addItems(["Filled pixels", "All pixels"])
        self.pixels.setToolTip("Judge what was filled in, or also the depth that was known before")
        self.pixels.activated.connect(lambda _: self.pixels_changed.emit())
        columns = [texts.RMSE, texts.MAE, texts.MEDIAN, texts.WITHIN]
        self.truth_table = NumberTable("Errors against the truth", columns)
        return _page("&Judge", self.pixels, None, self.truth_table)

    def _hidden_page(self) -> QWidget:
        self.part = QComboBox()
        self.part.addItems(["All blocks", "Chosen block"])
        self.part.setToolTip("Show the errors of all blocks together, or of the chosen block")
        self.part.activated.connect(lambda _: self.part_changed.emit())
        self.tested = Message()
        columns = [texts.RMSE, texts.MAE, texts.MEDIAN, texts.PIXELS]
        self.hidden_table = NumberTable("Errors on hidden depth", columns)
        return _page("&Over", self.part, self.tested, self.hidden_table)

    @property
    def every(self) -> bool:
        """Whether all pixels are to be judged, and not only filled ones."""
        return self.pixels.currentIndex() == 1

    @property
    def over_chosen(self) -> bool:
        """Whether the test is wanted for the chosen block."""
        return self.part.currentIndex() == 1

    def say_source(self, text: str, path: str = "") -> None:
        """Where the truth comes from, or that there is none; `path` is the file's."""
        self.source.say(text)
        self.source.setToolTip(as_it_is(path))

    def show_truth(self, rows: Sequence[Row], empty: str) -> None:
        """Errors against the truth; without any, why."""
        self.truth_table.set_rows(rows, empty)
        self.pixels.setEnabled(bool(rows))

    def show_hidden(self, rows: Sequence[Row], text: str, tone: str, empty: str) -> None:
        """What was tested on hidden depth, and how; without any, why."""
        self.tested.setVisible(bool(text))
        self.tested.say(text, tone)
        self.hidden_table.set_rows(rows, empty)
        self.part.setEnabled(bool(rows))

    def set_chosen(self, name: str) -> None:
        """What the chosen block is called; "" for none."""
        with QSignalBlocker(self.part):
            self.part.setItemText(1, f"{name} only" if name else "Chosen block (none is chosen)")

    def turn_to(self, hidden: bool) -> None:
        """Show the page of the test on hidden depth, or that of the truth."""
        self.tabs.setCurrentIndex(int(hidden))

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.looked_at.emit()


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
