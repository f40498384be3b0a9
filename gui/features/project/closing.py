"""Asking before work would be lost: saved, discarded, or not left at all."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Protocol

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QDialogButtonBox,
    QHeaderView,
    QMessageBox,
    QPushButton,
    QRadioButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ilf.project.encoding import frame_part

from ...state.entries import Entry
from ...state.session import Session
from ...widgets.basics import Message, as_it_is, group
from ..context import Desk

# The dialog that asks about work that would be lost: what it is, frame by frame, and what to do with it.

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


class Work(Protocol):
    """What the project's file lacks, and how that is saved."""

    def project_words(self) -> str:
        """What is unsaved beside the frames; "" for nothing."""
        ...

    def when_saved(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as nothing is being saved."""
        ...

    def save_then(self, frames: frozenset[str], then: Callable[[bool], None]) -> None:
        """Save the work on these frames alone; `then` is told whether that has been done."""
        ...


class Closing(QObject):
    """Lets frames, projects and the window be closed only after the user has been asked about the work on them.

    Parameters
    ----------
    desk : Desk
    work : Work
    """

    def __init__(self, desk: Desk, work: Work) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._work = work
        self.dialog: CloseDialog | None = None
        """The question that is open."""

    def leave(self, entries: Sequence[Entry], whole: bool, what: str, then: Callable[[], None]) -> None:
        """Call `then` as soon as these frames may be closed: at once if there is nothing to be asked, never if the user
        would rather stay.

        Parameters
        ----------
        entries : sequence of Entry
        whole : bool
            Whether they are all of the project, which is left, too.
        what : str
            What is about to happen, as in "the window closes".
        then : callable
        """
        if self._desk.documents.discard_silently:
            then()
            return
        self._work.when_saved(lambda: self._ask(entries, whole, what, then))

    def _ask(self, entries: Sequence[Entry], whole: bool, what: str, then: Callable[[], None]) -> None:
        """The same, once nothing is being saved."""
        rows, running = self._rows(entries), self._running(entries)
        ways = [way.what for way in self._desk.under_way() if _concerns(way.session, entries, whole)]
        others = [f"{way[:1].upper()}{way[1:]} is under way: it ends, and what it has found is lost." for way in ways]
        words = self._work.project_words() if whole else ""
        if words:
            rows.append(Unsaved("", "The project itself", words, ""))
        if not (rows or others):
            then()
            return
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = CloseDialog(what, rows, others, bool(running), self._desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        question = _Question(self._desk, self._work, dialog, running, then)
        dialog.save_wished.connect(question.save)
        dialog.discard_wished.connect(question.discard)
        dialog.finished.connect(self._forget)
        dialog.open()

    def remove(self, entries: Sequence[Entry], then: Callable[[], None]) -> None:
        """Call `then` if frames may be taken out of the project: at once where there is no work on them."""
        stored = self._desk.store
        worked = [
            entry.name
            for entry in entries
            if entry.unsaved
            or entry.session in self._desk.runs.running
            or (stored.project is not None and frame_part(entry.id) in stored.project.names())
        ]
        if self._desk.documents.discard_silently or not worked:
            then()
            return
        names = worked[0] if len(worked) == 1 else f"{len(worked)} frames"
        box = QMessageBox(self._desk.window)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Warning)
        box.setWindowTitle("Remove from the project?")
        box.setTextFormat(Qt.TextFormat.PlainText)
        box.setText(f"The work on {names} goes with {'it' if len(worked) == 1 else 'them'}: it cannot be brought back.")
        box.setInformativeText("What the project's file holds of it is there until the project is saved the next time.")
        remove = box.addButton("&Remove", QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        box.finished.connect(lambda _: then() if box.clickedButton() is remove else None)
        box.open()

    def _forget(self) -> None:
        self.dialog = None

    def _running(self, entries: Sequence[Entry]) -> list[Session]:
        sessions = {entry.session for entry in entries}
        return [session for session in self._desk.runs.running if session in sessions]

    def _rows(self, entries: Sequence[Entry]) -> list[Unsaved]:
        running = self._desk.runs.running
        rows = []
        for entry in entries:
            texts = [entry.unsaved_words()]
            if entry.session in running:
                share = self._desk.runs.of(entry.session).share_done
                texts.append(f"a run is under way ({share:.0%})")
            work = ", ".join(filter(None, texts))
            if work:
                rows.append(Unsaved(entry.id, entry.name, work, entry.summary.stage.value))
        return rows


class _Question(QObject):
    """What becomes of the answer."""

    def __init__(
        self, desk: Desk, work: Work, dialog: CloseDialog, running: list[Session], then: Callable[[], None]
    ) -> None:
        super().__init__(dialog)
        self._desk = desk
        self._work = work
        self._dialog = dialog
        self._running = running
        self._then = then
        self._saves = False
        self._over = False
        dialog.rejected.connect(self._give_up)
        desk.runs.state_changed.connect(self._look)

    def discard(self) -> None:
        """Go on without saving."""
        self._end()

    def _give_up(self) -> None:
        self._over = True

    def save(self) -> None:
        """Save what is ticked, when its runs have ended."""
        self._saves = True
        ticked = self._dialog.ticked()
        self._running = [session for session in self._running if session.id in ticked]
        if not self._dialog.waits():
            for session in self._running:
                self._desk.runs.of(session).cancel()
        self._look()

    def _look(self) -> None:
        """Save as soon as nothing runs any more."""
        if not self._saves:
            return
        running = [session for session in self._running if session in self._desk.runs.running]
        if running:
            done = sum(self._desk.runs.of(session).share_done for session in running) / len(running)
            names = running[0].name if len(running) == 1 else f"{len(running)} frames"
            self._dialog.show_progress(f"Waiting for the run of {names}: {done:.0%} done…")
            return
        self._saves = False
        QTimer.singleShot(0, self, self._begin)  # what has ended is kept by then

    def _begin(self) -> None:
        if any(session in self._desk.runs.running for session in self._running):  # a guess follows the run
            self._saves = True
            self._look()
            return
        self._dialog.show_progress("Saving…")
        self._work.save_then(self._dialog.ticked(), self._saved)

    def _saved(self, done: bool) -> None:
        if self._over:
            return
        if done:
            self._end()
        else:
            self._dialog.reject()

    def _end(self) -> None:
        self._over = True
        self._desk.runs.state_changed.disconnect(self._look)
        self._dialog.accept()
        self._then()


def _concerns(session: Session | None, entries: Sequence[Entry], whole: bool) -> bool:
    return whole if session is None else any(entry.session is session for entry in entries)
