"""Question before unsaved work would be lost: save, discard or cancel."""

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

from ilf.project.state_codec import frame_part

from ...state.entries import Entry
from ...state.session import Session
from ...widgets.basics import Message, group, literal_text
from ...widgets.notices import question
from ..context import Context
from ..documents.feature import DocumentsFeature

# The dialog that lists unsaved work by frame, and asks whether to save it.

_ID = Qt.ItemDataRole.UserRole
_MAX_ROWS_SHOWN = 8


@dataclass(frozen=True)
class Unsaved:
    """A frame with unsaved work.

    Attributes
    ----------
    id, name : str
        Empty id: the settings for all frames, which cannot be left out.
    work : str
        Description of the work, such as "3 edits, 1 run".
    stage : str
        State of the work on the frame.
    """

    id: str
    name: str
    work: str
    stage: str


class CloseDialog(QDialog):
    """Dialog with a tick per frame, and *Save*, *Discard* and *Cancel*. It stays open until the action is done.

    Parameters
    ----------
    what : str
        What is about to happen, such as "the window closes".
    rows : sequence of Unsaved
        May be empty.
    others : sequence of str
        Other work that would be lost, as sentences.
    running : bool
        Whether runs of these frames are in progress.
    parent : QWidget

    Signals
    -------
    save_requested(), discard_requested()
        A button was clicked; the dialog stays open. See `ticked()` and `waits()` for the choices.
    """

    save_requested = Signal()
    discard_requested = Signal()

    def __init__(
        self, what: str, rows: Sequence[Unsaved], others: Sequence[str], running: bool, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save the work?" if rows else "Continue?")
        self.setModal(True)
        self._rows = rows
        about = Message()
        about.show_message(_question(what, rows), "text")
        self.frames = QTreeWidget()
        self.frames.setStyleSheet("QTreeView::item { padding: 3px 0; }")
        self.frames.setAccessibleName("Frames with unsaved work")
        self.frames.setToolTip("Ticked frames are saved; the work on the others is lost")
        self.wait = QRadioButton("&Wait until the runs have ended")
        self.wait.setToolTip("Complete the runs and save their results; waiting can be cancelled")
        self.stop = QRadioButton("S&top the runs and keep the completed blocks")
        self.stop.setToolTip("Save the blocks that are completed so far; the remaining blocks are not run")
        self._runs = QButtonGroup(self)
        self.also = Message()
        self.progress = Message()
        self.save_button = QPushButton("&Save")
        self.save_button.setToolTip("Save the ticked frames, then continue")
        self.discard_button = QPushButton("&Discard" if rows else "&Continue")
        self.discard_button.setToolTip("Continue without saving: the work listed here is lost")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        buttons.button(QDialogButtonBox.StandardButton.Cancel).setToolTip("Close nothing, and change nothing")
        if rows:
            buttons.addButton(self.save_button, QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.addButton(self.discard_button, QDialogButtonBox.ButtonRole.DestructiveRole)
        self.save_button.clicked.connect(lambda: self.save_requested.emit())
        self.discard_button.clicked.connect(lambda: self.discard_requested.emit())
        buttons.rejected.connect(self.reject)

        column = QVBoxLayout(self)
        column.setContentsMargins(14, 14, 14, 14)
        column.setSpacing(10)
        column.addWidget(about)
        if rows:
            self._fill()
            column.addWidget(self.frames, 1)
        if running:
            column.addWidget(self._runs_box())
        if others:
            self.also.show_message("\n".join(others), "warning")
            column.addWidget(self.also)
        column.addWidget(self.progress)
        column.addWidget(buttons)
        (self.save_button if rows else buttons.button(QDialogButtonBox.StandardButton.Cancel)).setDefault(True)
        self._can_be_changed = [self.frames, self.wait, self.stop, self.save_button, self.discard_button]
        self.progress.hide()
        self.setMinimumWidth(520)
        self._follow_ticks()

    def ticked(self) -> frozenset[str]:
        """Return the ids of the frames to save."""
        items = (self.frames.topLevelItem(row) for row in range(self.frames.topLevelItemCount()))
        return frozenset(
            item.data(0, _ID) for item in items if item is not None and item.checkState(0) == Qt.CheckState.Checked
        )

    def tick(self, ids: Collection[str]) -> None:
        """Tick exactly these frames."""
        for row in range(self.frames.topLevelItemCount()):
            item = self.frames.topLevelItem(row)
            if item is not None and item.data(0, _ID):
                on = item.data(0, _ID) in ids
                item.setCheckState(0, Qt.CheckState.Checked if on else Qt.CheckState.Unchecked)

    def waits(self) -> bool:
        """Whether to wait until the runs have ended."""
        return self.wait.isChecked()

    def show_progress(self, text: str) -> None:
        """Show the progress and disable the choices; only *Cancel* stays enabled. "" enables the choices again."""
        self.progress.setVisible(bool(text))
        self.progress.show_message(text)
        for widget in self._can_be_changed:
            widget.setEnabled(not text)
        if not text:
            self._follow_ticks()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Handle closing as *Cancel*."""
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
            item.setToolTip(0, literal_text(row.name))
            self.frames.addTopLevelItem(item)
        header = self.frames.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for column in (1, 2):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        rows = min(len(self._rows), _MAX_ROWS_SHOWN)
        self.frames.setFixedHeight(header.sizeHint().height() + (rows + 1) * (self.fontMetrics().height() + 10))
        self.frames.itemChanged.connect(lambda *_: self._follow_ticks())

    def _runs_box(self) -> QWidget:
        box, column = group("Runs in progress")
        for button in (self.stop, self.wait):
            self._runs.addButton(button)
            column.addWidget(button)
        self.stop.setChecked(True)
        return box

    def _follow_ticks(self) -> None:
        ticked = self.ticked()
        frames, chosen = sum(bool(row.id) for row in self._rows), len(ticked - {""})
        self.save_button.setEnabled(bool(ticked))
        self.save_button.setText("&Save" if chosen == frames else f"&Save {chosen} of {frames}")


def _question(what: str, rows: Sequence[Unsaved]) -> str:
    if not rows:
        return f"Work in progress ends when {what}."
    names = [row.name for row in rows if row.id]
    parts = [names[0] if len(names) == 1 else f"{len(names)} frames"] * bool(names)
    parts += ["the project itself"] * (len(rows) > len(names))
    lost = " Work that is not ticked is lost." if len(names) > 1 else ""
    return f"Save the work on {' and '.join(parts)} before {what}?{lost}"


class SaveHandler(Protocol):
    """Unsaved work of the project, and how to save it."""

    def project_words(self) -> str:
        """Describe the unsaved changes apart from the frames; "" for none."""
        ...

    def when_saved(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as nothing is being saved."""
        ...

    def save_then(self, frames: frozenset[str], then: Callable[[bool], None]) -> None:
        """Save only the work on these frames; `then` receives whether it was saved."""
        ...


class Closing(QObject):
    """Asks the user about unsaved work before frames, projects or the window are closed.

    Parameters
    ----------
    context : Context
    work : SaveHandler
    """

    def __init__(self, context: Context, work: SaveHandler) -> None:
        super().__init__(context.window)
        self._context = context
        self._work = work
        self.dialog: CloseDialog | None = None
        """The open dialog; None for none."""

    def leave(self, entries: Sequence[Entry], whole: bool, what: str, then: Callable[[], None]) -> None:
        """Call `then` as soon as these frames may be closed: at once if there is nothing to ask, never if the user
        cancels.

        Parameters
        ----------
        entries : sequence of Entry
        whole : bool
            Whether these are all frames of the project, which is closed, too.
        what : str
            What is about to happen, such as "the window closes".
        then : callable
        """
        if self._context.feature(DocumentsFeature).discard_silently:
            then()
            return
        self._work.when_saved(lambda: self._ask(entries, whole, what, then))

    def _ask(self, entries: Sequence[Entry], whole: bool, what: str, then: Callable[[], None]) -> None:
        """Ask as in `leave`, once nothing is being saved."""
        rows, running = self._rows(entries), self._running(entries)
        ways = [way.what for way in self._context.pending_work() if _concerns(way.session, entries, whole)]
        others = [
            f"{way[:1].upper()}{way[1:]} is in progress: it is stopped, and its results are lost." for way in ways
        ]
        words = self._work.project_words() if whole else ""
        if words:
            rows.append(Unsaved("", "The project itself", words, ""))
        if not (rows or others):
            then()
            return
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = CloseDialog(what, rows, others, bool(running), self._context.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        question = _CloseAnswer(self._context, self._work, dialog, running, then)
        dialog.save_requested.connect(question.save)
        dialog.discard_requested.connect(question.discard)
        dialog.finished.connect(self._forget)
        dialog.open()

    def remove(self, entries: Sequence[Entry], then: Callable[[], None]) -> None:
        """Call `then` if frames may be removed from the project: at once if there is no work on them."""
        stored = self._context.recorder.store
        worked = [
            entry.name
            for entry in entries
            if entry.unsaved
            or entry.session in self._context.runs.running
            or (stored.project is not None and frame_part(entry.id) in stored.project.names())
        ]
        if self._context.feature(DocumentsFeature).discard_silently or not worked:
            then()
            return
        names = worked[0] if len(worked) == 1 else f"{len(worked)} frames"
        text = f"The work on {names} is removed, too. This cannot be undone."
        more = "The project file keeps it until the project is saved the next time."
        box = question(self._context.window, "Remove from the project?", text, more)
        remove = box.addButton("&Remove", QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        box.finished.connect(lambda _: then() if box.clickedButton() is remove else None)
        box.open()

    def _forget(self) -> None:
        self.dialog = None

    def _running(self, entries: Sequence[Entry]) -> list[Session]:
        sessions = {entry.session for entry in entries}
        return [session for session in self._context.runs.running if session in sessions]

    def _rows(self, entries: Sequence[Entry]) -> list[Unsaved]:
        running = self._context.runs.running
        rows = []
        for entry in entries:
            texts = [entry.unsaved_summary()]
            if entry.session in running:
                share = self._context.runs.of(entry.session).share_done
                texts.append(f"a run is in progress ({share:.0%})")
            work = ", ".join(filter(None, texts))
            if work:
                rows.append(Unsaved(entry.id, entry.name, work, entry.summary.stage.value))
        return rows


class _CloseAnswer(QObject):
    """Handling of the user's answer in a `CloseDialog`."""

    def __init__(
        self, context: Context, work: SaveHandler, dialog: CloseDialog, running: list[Session], then: Callable[[], None]
    ) -> None:
        super().__init__(dialog)
        self._context = context
        self._work = work
        self._dialog = dialog
        self._running = running
        self._then = then
        self._saves = False
        self._over = False
        dialog.rejected.connect(self._give_up)
        context.runs.state_changed.connect(self._look)

    def discard(self) -> None:
        """Continue without saving."""
        self._end()

    def _give_up(self) -> None:
        self._over = True

    def save(self) -> None:
        """Save the ticked frames when their runs have ended."""
        self._saves = True
        ticked = self._dialog.ticked()
        self._running = [session for session in self._running if session.id in ticked]
        if not self._dialog.waits():
            for session in self._running:
                self._context.runs.of(session).cancel()
        self._look()

    def _look(self) -> None:
        """Save as soon as no run is in progress."""
        if not self._saves:
            return
        running = [session for session in self._running if session in self._context.runs.running]
        if running:
            done = sum(self._context.runs.of(session).share_done for session in running) / len(running)
            names = running[0].name if len(running) == 1 else f"{len(running)} frames"
            self._dialog.show_progress(f"Waiting for the run of {names}: {done:.0%} done…")
            return
        self._saves = False
        QTimer.singleShot(0, self, self._begin)  # results of ended runs are stored by then

    def _begin(self) -> None:
        if any(session in self._context.runs.running for session in self._running):  # an extrapolation follows the run
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
        self._context.runs.state_changed.disconnect(self._look)
        self._dialog.accept()
        self._then()


def _concerns(session: Session | None, entries: Sequence[Entry], whole: bool) -> bool:
    return whole if session is None else any(entry.session is session for entry in entries)
