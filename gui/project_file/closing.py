"""Asking before work would be lost: saved, discarded, or not left at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QMessageBox

from gui.desk import Desk
from gui.project_file.close_dialog import CloseDialog, Unsaved
from gui.state.entries import Entry
from gui.state.session import Session
from ilf.project.encoding import frame_part


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
