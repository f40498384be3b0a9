"""Offers at the start what windows have left behind."""

from __future__ import annotations

import socket
from collections import Counter
from collections.abc import Generator
from pathlib import Path

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QMessageBox

from gui.autosave.recovery_dialog import OfferedWork, RecoveryDialog
from gui.autosave.restoring import Restoring, name_of
from gui.desk import Desk
from gui.project_file.opening import Opening
from gui.work.worker import Worker
from ilf.project import Stage
from ilf.project.journals import LeftWork, left_work

_STAGES = {
    Stage.UNTOUCHED: "without blocks",
    Stage.EXTRACTED: "as extracted",
    Stage.EDITED: "with edited blocks",
    Stage.RUN: "with results",
    Stage.FAILED: "that failed",
}


class Recovery(QObject):
    """Looks for left work in the background, and asks what is to become of it."""

    def __init__(self, desk: Desk, opening: Opening, folder: Path) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._folder = folder
        self._restoring = Restoring(desk, opening)
        self._found: list[LeftWork] = []
        self._let_go: set[int] = set()
        self.dialog: RecoveryDialog | None = None
        self._worker = Worker(self)
        self._worker.finished.connect(self._offer)
        self._worker.failed.connect(lambda error: desk.notes.report("Unsaved work", error))

    def look(self) -> None:
        """Look for left work; what there is, is offered."""
        if self.dialog is None and not self._worker.busy:
            self._worker.start(self._job)

    def shutdown(self) -> bool:
        """Stop, and leave what has not been decided for another time. True if the thread has ended."""
        ended = self._worker.shutdown()
        if self.dialog is not None:
            self.dialog.reject()
        return ended

    def _job(self) -> Generator[None, None, list[tuple[LeftWork, OfferedWork]]]:
        yield None
        return [(left, _offered(left)) for left in left_work(self._folder)]

    def _offer(self, found: list[tuple[LeftWork, OfferedWork]]) -> None:
        if not found:
            return
        self._found, self._let_go = [left for left, _ in found], set()
        self.dialog = RecoveryDialog([offered for _, offered in found], self._desk.window)
        self.dialog.restore_wished.connect(self._restore)
        self.dialog.discard_wished.connect(self._discard)
        self.dialog.finished.connect(self._close)
        self.dialog.say_added(not self._restoring.is_alone())
        self.dialog.open()

    def _restore(self, number: int) -> None:
        self._let_go.add(number)  # by the one who restores it
        self._restoring.restore(self._found[number], lambda: self._restored(number), lambda: self._failed(number))

    def _failed(self, number: int) -> None:
        """It is left for another time."""
        if self.dialog is None:
            self._found[number].release()
            return
        self._let_go.discard(number)
        self.dialog.go_on()

    def _restored(self, number: int) -> None:
        self._desk.notes.tell(f"Restored {name_of(self._found[number])}: save it to keep it")
        if self.dialog is not None:
            self.dialog.go_on()
            self.dialog.say_added(True)
            self.dialog.remove(number)

    def _discard(self, number: int) -> None:
        left = self._found[number]
        box = QMessageBox(self.dialog)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Warning)
        box.setWindowTitle("Discard unsaved work?")
        box.setTextFormat(Qt.TextFormat.PlainText)
        box.setText(f"The unsaved work on {name_of(left) or left.path.name} is deleted for good.")
        discard = box.addButton("&Discard", QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        box.finished.connect(lambda _: self._delete(number) if box.clickedButton() is discard else None)
        box.open()

    def _delete(self, number: int) -> None:
        left = self._found[number]
        try:
            left.discard()
        except OSError as error:
            self._desk.notes.report("Not discarded", error)
            return
        self._let_go.add(number)
        if self.dialog is not None:
            self.dialog.remove(number)

    def _close(self) -> None:
        for number, left in enumerate(self._found):
            if number not in self._let_go:
                left.release()
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()


def _offered(left: LeftWork) -> OfferedWork:
    """What there is to say of it; called off the GUI's thread."""
    if left.note is None or left.problem:
        return OfferedWork(left.path.name, left.note.changed if left.note else None, (), problem=left.problem)
    frames, all_frames = left.frames, left.read.project.frames
    stages = Counter(frame.summary.stage for frame in frames)
    parts = [f"{stages[stage]} {text}" for stage, text in _STAGES.items() if stages[stage]]
    count = _counted(len(all_frames), "frame")
    changed = f"{len(frames)} of {count} changed: {', '.join(parts)}"
    lines = [changed if frames else f"{count}: no work on them, but their list or what is set for them has changed"]
    if left.note.project:
        lines.append(f"Project {left.note.project}")
    if left.note.host != socket.gethostname():
        lines.append(f"From the machine {left.note.host}")
    lines += left.read.problems
    return OfferedWork(name_of(left), left.note.changed, tuple(lines), left.picture())


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'s' * (count != 1)}"
