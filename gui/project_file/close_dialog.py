"""The dialog that asks about work that would be lost: what it is, frame by frame, and what to do with it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QDialogButtonBox,
    QHeaderView,
    QPushButton,
    QRadioButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gui.widgets.messages import Message, group
from gui.widgets.plain_text import as_it_is

_ID = Qt.ItemDataRole.UserRole
_MOST_ROWS_SHOWN = 8


@dataclass(frozen=True)
class Unsaved:
    """A frame with work that would be lost.

    Attributes
    ----------
    id, name : str
        No id: what is set for all frames, which cannot be left out.
    work : str
        What the work is, as "3 edits, 1 run".
    stage : str
        How far the work on the frame has come.
    """

    id: str
    name: str
    work: str
    stage: str


class CloseDialog(QDialog):
    """Frames with a tick each, and *Save*, *Discard* and *Cancel*. It stays open until what was chosen is done.

    Parameters
    ----------
    what : str
        What is about to happen, as in "the window closes".
    rows : sequence of Unsaved
        May be none.
    others : sequence of str
        What else would be lost, as sentences.
    running : bool
        Whether runs of these frames are under way.
    parent : QWidget

    Signals
    -------
    save_wished(), discard_wished()
        One of the buttons; the dialog stays. What is ticked is `ticked()`, and whether runs are waited for `waits()`.
    """

    save_wished = Signal()
    discard_wished = Signal()

    def __init__(
        self, what: str, rows: Sequence[Unsaved], others: Sequence[str], running: bool, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save the work?" if rows else "Go on?")
        self.setModal(True)
        self._rows = rows
        about = Message()
        about.say(_question(what, rows), "text")
        self.frames = QTreeWidget()
        self.frames.setStyleSheet("QTreeView::item { padding: 3px 0; }")
        self.frames.setAccessibleName("Frames with unsaved work")
        self.frames.setToolTip("Frames that are ticked are saved; the work on the others is lost")
        self.wait = QRadioButton("&Wait until the runs have ended")
        self.wait.setToolTip("The runs go to their end, are kept and saved; it can be cancelled meanwhile")
        self.stop = QRadioButton("S&top the runs, and keep the blocks that are done")
        self.stop.setToolTip("What the runs have completed so far is kept and saved; their other blocks are not run")
        self._runs = QButtonGroup(self)
        self.also = Message()
        self.progress = Message()
        self.save_button = QPushButton("&Save")
        self.save_button.setToolTip("Save the frames that are ticked, and go on when they are saved")
        self.discard_button = QPushButton("&Discard" if rows else "&Go on")
        self.discard_button.setToolTip("Go on without saving: the work that is listed here is lost")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        buttons.button(QDialogButtonBox.StandardButton.Cancel).setToolTip("Stay, and leave everything as it is")
        if rows:
            buttons.addButton(self.save_button, QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.addButton(self.discard_button, QDialogButtonBox.ButtonRole.DestructiveRole)
        self.save_button.clicked.connect(lambda: self.save_wished.emit())
        self.discard_button.clicked.connect(lambda: self.discard_wished.emit())
        buttons.rejected.connect(self.reject)

        column = QVBoxLayout(self)
        column.setContentsMargins(14, 14, 14, 14)
        column.setSpacing(10)
        column.addWidget(about)
        if rows:
            self._fill()
            column.addWidget(self.frames, 1)
        if running:
            column.addWidget(self._of_runs())
        if others:
            self.also.say("\n".join(others), "warning")
            column.addWidget(self.also)
        column.addWidget(self.progress)
        column.addWidget(buttons)
        (self.save_button if rows else buttons.button(QDialogButtonBox.StandardButton.Cancel)).setDefault(True)
        self._can_be_changed = [self.frames, self.wait, self.stop, self.save_button, self.discard_button]
        self.progress.hide()
        self.setMinimumWidth(520)
        self._follow_ticks()

    def ticked(self) -> frozenset[str]:
        """Ids of the frames that are to be saved."""
        items = (self.frames.topLevelItem(row) for row in range(self.frames.topLevelItemCount()))
        return frozenset(
            item.data(0, _ID) for item in items if item is not None and item.checkState(0) == Qt.CheckState.Checked
        )

    def tick(self, ids: Collection[str]) -> None:
        """Tick just these frames."""
        for row in range(self.frames.topLevelItemCount()):
            item = self.frames.topLevelItem(row)
            if item is not None and item.data(0, _ID):
                on = item.data(0, _ID) in ids
                item.setCheckState(0, Qt.CheckState.Checked if on else Qt.CheckState.Unchecked)

    def waits(self) -> bool:
        """Whether runs are to go to their end."""
        return self.wait.isChecked()

    def show_progress(self, text: str) -> None:
        """What was chosen is being done, and this far; nothing can be chosen until then, but it can be cancelled. "":
        choose again."""
        self.progress.setVisible(bool(text))
        self.progress.say(text)
        for widget in self._can_be_changed:
            widget.setEnabled(not text)
        if not text:
            self._follow_ticks()

    def closeEvent(self, event: QCloseEvent) -> None:
        """As *Cancel*."""
        self.reject()
        super().closeEvent(event)

    def _fill(self) -> None:
        self.frames.setHeaderLabels(["Frame", "Unsaved work", "State"])
        self.frames.setRootIsDecorated(False)
        self.frames.setUniformRowHeights(True)
        for row in self._rows:
            item = QTreeWidgetItem([row.name, row.work, row.stage])
            item.setData(0, _ID, row.id)
            item.setCheckState(0, Qt.CheckState.Checked)
            if not row.id:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsUserCheckable)
            item.setToolTip(0, as_it_is(row.name))
            self.frames.addTopLevelItem(item)
        header = self.frames.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for column in (1, 2):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        rows = min(len(self._rows), _MOST_ROWS_SHOWN)
        self.frames.setFixedHeight(header.sizeHint().height() + (rows + 1) * (self.fontMetrics().height() + 10))
        self.frames.itemChanged.connect(lambda *_: self._follow_ticks())

    def _of_runs(self) -> QWidget:
        box, column = group("Runs that are under way")
        for button in (self.stop, self.wait):
            self._runs.addButton(button)
            column.addWidget(button)
        self.stop.setChecked(True)
        return box

    def _follow_ticks(self) -> None:
        ticked = self.ticked()
        frames, chosen = _frame_count(self._rows), len(ticked - {""})
        self.save_button.setEnabled(bool(ticked))
        self.save_button.setText("&Save" if chosen == frames else f"&Save {chosen} of {frames}")


def _question(what: str, rows: Sequence[Unsaved]) -> str:
    if not rows:
        return f"Something is under way that ends when {what}."
    names = [row.name for row in rows if row.id]
    parts = [names[0] if len(names) == 1 else f"{len(names)} frames"] * bool(names)
    parts += ["the project itself"] * (len(rows) > len(names))
    lost = " What is not ticked is lost." if len(names) > 1 else ""
    return f"Save the work on {' and '.join(parts)} before {what}?{lost}"


def _frame_count(rows: Sequence[Unsaved]) -> int:
    return sum(bool(row.id) for row in rows)
