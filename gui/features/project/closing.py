"""Question before unsaved work would be lost: save, discard or cancel."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QDialog,
    QDialogButtonBox,
    QPushButton,
    QRadioButton,
    QTreeWidgetItem,
    QWidget,
)
from shiboken6 import isValid

from ilf.project.state_codec import frame_part

from ...project.current_project import CurrentProject
from ...state.document import Document
from ...state.entries import Entry
from ...widgets.basics import Message, group, literal_text, open_once, row_list, stack
from ...widgets.notices import DESTROY, ask
from ...work.runs import RunController
from ..context import Context
from ..documents.feature import DocumentsFeature
from .saving import Saving

# The dialog that lists unsaved work by frame, and asks whether to save it.

Save = Callable[[frozenset[str], Callable[[bool], None]], None]
"""Saves only the work on frames of these ids, then calls a function with whether it was saved."""

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
    """

    id: str
    name: str
    work: str


class CloseDialog(QDialog):
    """Dialog with a tick per frame, and *Save*, *Discard* and *Cancel*. After *Save* it stays open until the ticked
    frames are saved, once their runs have ended.

    Parameters
    ----------
    what : str
        What is about to happen, such as "the window closes".
    rows : sequence of Unsaved
        May be empty.
    others : sequence of str
        Other work that would be lost, as sentences.
    running : sequence of Document
        Frames whose runs are in progress.
    runs : RunController
    save : Save
    parent : QWidget
    """

    def __init__(
        self,
        what: str,
        rows: Sequence[Unsaved],
        others: Sequence[str],
        running: Sequence[Document],
        runs: RunController,
        save: Save,
        parent: QWidget,
    ) -> None:
        super().__init__(parent)
        self._running, self._runs, self._save = running, runs, save
        self._waits = False
        runs.state_changed.connect(self._look)
        self.finished.connect(lambda: runs.state_changed.disconnect(self._look))
        self.setWindowTitle("Save the work?" if rows else "Continue?")
        self.setModal(True)
        self._rows = rows
        about = Message()
        about.show_message(_question(what, rows), "text")
        self.frames = row_list(
            "Frames with unsaved work",
            "Ticked frames are saved; the work on the others is lost",
            ["Frame", "Unsaved work"],
            stretched=0,
        )
        self.wait = QRadioButton("&Wait until the runs have ended")
        self.wait.setToolTip("Complete the runs and save their results; waiting can be cancelled")
        self.stop = QRadioButton("S&top the runs and keep the completed blocks")
        self.stop.setToolTip("Save the blocks that are completed so far; the remaining blocks are not run")
        self._ways = QButtonGroup(self)
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
        self.save_button.clicked.connect(self._begin)
        self.discard_button.clicked.connect(self.accept)
        buttons.rejected.connect(self.reject)

        self.also.show_message("\n".join(others), "warning")
        parts: list[QWidget] = [about]
        if rows:
            parts.append(self.frames)
        if running:
            parts.append(self._runs_box())
        if others:
            parts.append(self.also)
        stack(self, *parts, self.progress, buttons, stretched=self.frames if rows else None)
        self._fill()
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

    def _show_progress(self, text: str) -> None:
        """Show the progress and disable the choices; only *Cancel* stays enabled."""
        self.progress.show()
        self.progress.show_message(text)
        for widget in self._can_be_changed:
            widget.setEnabled(False)

    def _begin(self) -> None:
        """Save the ticked frames when their runs have ended, or are stopped."""
        self._running = [document for document in self._running if document.id in self.ticked()]
        if not self.wait.isChecked():
            for document in self._running:
                self._runs.of(document).cancel()
        self._waits = True
        self._look()

    def _look(self) -> None:
        """Save as soon as no run is in progress."""
        if not self._waits:
            return
        running = [document for document in self._running if document in self._runs.running]
        if running:
            done = sum(self._runs.of(document).share_done for document in running) / len(running)
            names = running[0].name if len(running) == 1 else f"{len(running)} frames"
            self._show_progress(f"Waiting for the run of {names}: {done:.0%} done…")
            return
        self._waits = False
        QTimer.singleShot(0, self, self._save_ticked)  # results of ended runs are stored by then

    def _save_ticked(self) -> None:
        if any(document in self._runs.running for document in self._running):  # an extrapolation follows the run
            self._waits = True
            self._look()
            return
        self._show_progress("Saving…")
        self._save(self.ticked(), self._take_saved)

    def _take_saved(self, done: bool) -> None:
        if isValid(self) and self.isVisible():  # not cancelled meanwhile
            (self.accept if done else self.reject)()

    def closeEvent(self, event: QCloseEvent) -> None:
        """Handle closing as *Cancel*."""
        self.reject()
        super().closeEvent(event)

    def _fill(self) -> None:
        for row in self._rows:
            item = QTreeWidgetItem([row.name, row.work])
            item.setData(0, _ID, row.id)
            item.setCheckState(0, Qt.CheckState.Checked)
            if not row.id:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsUserCheckable)
            item.setToolTip(0, literal_text(row.name))
            self.frames.addTopLevelItem(item)
        rows = min(len(self._rows), _MAX_ROWS_SHOWN)
        self.frames.setFixedHeight(
            self.frames.header().sizeHint().height() + (rows + 1) * (self.fontMetrics().height() + 10)
        )
        self.frames.itemChanged.connect(lambda *_: self._follow_ticks())

    def _runs_box(self) -> QWidget:
        box, column = group("Runs in progress")
        for button in (self.stop, self.wait):
            self._ways.addButton(button)
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


class Closing(QObject):
    """Asks the user about unsaved work before frames, projects or the window are closed.

    Parameters
    ----------
    context : Context
    present : CurrentProject
    saving : Saving
    save : Save
    """

    def __init__(
        self,
        context: Context,
        present: CurrentProject,
        saving: Saving,
        save: Save,
    ) -> None:
        super().__init__(context.window)
        self._context = context
        self._present = present
        self._saving = saving
        self._save = save
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
        else:
            self._saving.when_done(lambda: self._ask(entries, whole, what, then))

    def remove(self, entries: Sequence[Entry], then: Callable[[], None]) -> None:
        """Call `then` if frames may be removed from the project: at once if there is no work on them."""
        stored = self._context.recorder.store.project
        kept = set() if stored is None else set(stored.names())
        worked = [
            entry.name
            for entry in entries
            if entry.unsaved or entry.document in self._context.runs.running or frame_part(entry.id) in kept
        ]
        if self._context.feature(DocumentsFeature).discard_silently or not worked:
            then()
            return
        names = worked[0] if len(worked) == 1 else f"{len(worked)} frames"
        text = f"The work on {names} is removed, too. This cannot be undone."
        more = "The project file keeps it until the project is saved the next time."
        ask(self._context.window, "Remove from the project?", text, more, [("&Remove", DESTROY, then)])

    def _ask(self, entries: Sequence[Entry], whole: bool, what: str, then: Callable[[], None]) -> None:
        """Ask as in `leave`, once nothing is being saved."""
        runs = self._context.runs
        documents = {entry.document for entry in entries}
        running = [document for document in runs.running if document in documents]
        rows = [Unsaved(entry.id, entry.name, work) for entry, work in self._work(entries)]
        words = self._present.words() if whole else ""
        if words:
            rows.append(Unsaved("", "The project itself", words))
        others = [
            f"{way.what[:1].upper()}{way.what[1:]} is in progress: it is stopped, and its results are lost."
            for way in self._context.pending_work()
            if (whole if way.document is None else way.document in documents)
        ]
        if not (rows or others):
            then()
            return
        if self.dialog is not None:
            self.dialog.raise_()
            return
        self.dialog = dialog = CloseDialog(what, rows, others, running, runs, self._save, self._context.window)
        dialog.finished.connect(lambda _: setattr(self, "dialog", None))
        open_once(dialog, then)

    def _work(self, entries: Sequence[Entry]) -> Iterator[tuple[Entry, str]]:
        """Describe the unsaved work and the runs of the frames that have any."""
        runs = self._context.runs
        for entry in entries:
            texts = [entry.unsaved_summary()]
            if entry.document in runs.running:
                texts.append(f"a run is in progress ({runs.of(entry.document).share_done:.0%})")
            if work := ", ".join(filter(None, texts)):
                yield entry, work
