"""Question before unsaved work would be lost: save, discard or cancel."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QPushButton,
    QTreeWidgetItem,
    QWidget,
)
from shiboken6 import isValid

from ...state.document import Document
from ...widgets.basics import Message, literal_text, row_list, stack
from ...work.frame_runs import RunController
from ...work.steps import Steps, in_steps

_ID = Qt.ItemDataRole.UserRole
_LOOK_MS = 300
"""How often it is looked whether work has ended meanwhile [ms]."""


class CloseDialog(QDialog):
    """Dialog with a tick per frame, and *Save*, *Discard* and *Cancel*. After *Save* it stays open until the ticked
    frames are saved, once their runs have ended.

    Parameters
    ----------
    what : str
        What is about to happen, such as "the window closes".
    rows : mapping of str to (str, str)
        Id of a frame with unsaved work -> its name, and a description of the work, such as "3 edits, 1 run"; "" -> the
        settings for all frames, which cannot be left out. May be empty.
    others : callable
        Returns other work that would be lost, as sentences. It may end while the dialog is open.
    runs : RunController
    save : callable
        Returns the steps that save only the work on frames of some ids, and return whether it was saved.
    parent : QWidget
    """

    def __init__(
        self,
        what: str,
        rows: Mapping[str, tuple[str, str]],
        others: Callable[[], Sequence[str]],
        runs: RunController,
        save: Callable[[frozenset[str]], Steps[bool]],
        parent: QWidget,
    ) -> None:
        super().__init__(parent)
        self._runs, self._save = runs, save
        self.setWindowTitle("Save the work?" if rows else "Stop the work?")
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
        self.wait = QCheckBox("&Wait until the runs in progress have ended")
        self.wait.setToolTip(
            "Complete the runs and save their results; otherwise they are stopped, and only completed blocks are saved"
        )
        self.also = Message()
        self.progress = Message()
        self.save_button = QPushButton("&Save")
        self.save_button.setToolTip("Save the ticked frames, then continue")
        self.discard_button = QPushButton("&Discard" if rows else "&Stop")
        self.discard_button.setToolTip("Go on without saving: the work listed here is lost")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        buttons.button(QDialogButtonBox.StandardButton.Cancel).setToolTip("Close nothing, and change nothing")
        if rows:
            buttons.addButton(self.save_button, QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.addButton(self.discard_button, QDialogButtonBox.ButtonRole.DestructiveRole)
        self.save_button.clicked.connect(self._save_ticked)
        self.discard_button.clicked.connect(self.accept)
        buttons.rejected.connect(self.reject)

        self._others = others
        self._tell_others()
        look = QTimer(self)
        look.timeout.connect(self._tell_others)
        look.start(_LOOK_MS)
        parts = about, self.frames, self.wait, self.also, self.progress
        stack(self, *parts, buttons, stretched=self.frames if rows else None)
        for part, is_shown in zip(parts, (True, rows, self._running(rows), self.also.text(), False), strict=True):
            part.setVisible(bool(is_shown))
        self._fill()
        (self.save_button if rows else buttons.button(QDialogButtonBox.StandardButton.Cancel)).setDefault(True)
        self.setMinimumWidth(520)
        self._follow_ticks()

    def ticked(self) -> frozenset[str]:
        """Return the ids of the frames to save."""
        items = (self.frames.topLevelItem(row) for row in range(self.frames.topLevelItemCount()))
        return frozenset(
            item.data(0, _ID) for item in items if item is not None and item.checkState(0) == Qt.CheckState.Checked
        )

    def _show_progress(self, text: str) -> None:
        """Show the progress and disable the choices; only *Cancel* stays enabled."""
        self.progress.show()
        self.progress.show_message(text)
        for widget in (self.frames, self.wait, self.save_button, self.discard_button):
            widget.setEnabled(False)

    def _tell_others(self) -> None:
        """Say what other work would be lost now, or that there is nothing left to stop."""
        text = "\n".join(self._others())
        if not (text or self._rows):
            text = "It has ended."
            self.discard_button.setText("&Go on")
        self.also.show_message(text, "warning")

    def ask(self, take: Callable[[bool], object]) -> None:
        """Open the dialog, and call a function with whether to go on."""
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.finished.connect(lambda result: take(result == QDialog.DialogCode.Accepted))
        self.open()

    def _running(self, frames: Collection[str]) -> list[Document]:
        return [document for document in self._runs.running if document.id in frames]

    @in_steps
    def _save_ticked(self) -> Steps[None]:
        """Save the ticked frames when their runs have ended, or are stopped, unless it is cancelled meanwhile."""
        ticked = self.ticked()
        if not self.wait.isChecked():
            for document in self._running(ticked):
                self._runs.of(document).cancel()
        while running := self._running(ticked):
            done = sum(self._runs.of(document).share_done for document in running) / len(running)
            names = running[0].name if len(running) == 1 else f"{len(running)} frames"
            self._show_progress(f"Waiting for the run of {names}: {done:.0%} done…")
            yield lambda go: self._runs.state_changed.connect(go, Qt.ConnectionType.SingleShotConnection)
            yield partial(QTimer.singleShot, 0)  # results are stored by then, or an extrapolation follows
            if not (isValid(self) and self.isVisible()):
                return
        self._show_progress("Saving…")
        saved = yield from self._save(ticked)
        if isValid(self) and self.isVisible():
            (self.accept if saved else self.reject)()

    def _fill(self) -> None:
        for frame, (name, work) in self._rows.items():
            item = QTreeWidgetItem([name, work])
            item.setData(0, _ID, frame)
            item.setCheckState(0, Qt.CheckState.Checked)
            if not frame:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsUserCheckable)
            item.setToolTip(0, literal_text(name))
            self.frames.addTopLevelItem(item)
        self.frames.itemChanged.connect(lambda *_: self._follow_ticks())

    def _follow_ticks(self) -> None:
        ticked = self.ticked()
        frames, chosen = len(self._rows.keys() - {""}), len(ticked - {""})
        self.save_button.setEnabled(bool(ticked))
        self.save_button.setText("&Save" if chosen == frames else f"&Save {chosen} of {frames}")


def _question(what: str, rows: Mapping[str, tuple[str, str]]) -> str:
    if not rows:
        return f"Work in progress ends when {what}."
    names = [name for frame, (name, _) in rows.items() if frame]
    parts = [names[0] if len(names) == 1 else f"{len(names)} frames"] * bool(names)
    parts += ["the project itself"] * (len(rows) > len(names))
    lost = " Work that is not ticked is lost." if len(names) > 1 else ""
    return f"Save the work on {' and '.join(parts)} before {what}?{lost}"
