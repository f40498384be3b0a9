"""Autosave: work is written to a folder soon after every change, and offered again after the window closed
unexpectedly."""

from __future__ import annotations

import contextlib
import html
import socket
from collections.abc import Generator, Sequence
from datetime import UTC, datetime
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.project.recovery import RecoverableWork, autosave_folder, find_recoverable_work

from ...widgets.basics import Message, PlainLabel, lay_out, scrolled, stack
from ...widgets.notices import DESTROY, ask, error_details, error_text
from ...work.jobs import Worker
from ..context import Context, Feature
from .restoring import Restoring, has_no_project, name_of

# The dialog that offers unsaved work of a window that closed unexpectedly.

_PICTURE = 160
_MAX_ROWS_SHOWN = 3
_ABOUT = (
    "ILF Studio or the computer closed unexpectedly. This work is not in a project file yet. It is kept until you "
    "discard it."
)
_ADDED = "This window has a project: restored frames are added to it."


class RecoveryDialog(QDialog):
    """Dialog with a row per unsaved work, to restore or discard it.

    What is neither restored nor discarded is kept for the next start when the dialog is closed.
    """

    def __init__(self, context: Context, works: Sequence[RecoverableWork]) -> None:
        super().__init__(context.window)
        self._context = context
        self._restoring: _Row | None = None
        self.setWindowTitle("Restore Unsaved Work")
        about = Message(lines=2)
        about.show_message(_ABOUT, "text")
        self.added = Message()
        self.added.show_message(_ADDED)
        self.rows = {number: _Row(left) for number, left in enumerate(works)}
        for number, row in self.rows.items():
            row.restore_button.clicked.connect(partial(self._restore, number))
            row.discard_button.clicked.connect(partial(self._ask_discard, number))
        self._list = QWidget()
        lay_out(QVBoxLayout(self._list), *self.rows.values(), None, spacing=8)
        area = scrolled(self._list)
        shown = list(self.rows.values())[:_MAX_ROWS_SHOWN]
        area.setMinimumHeight(sum(row.sizeHint().height() + 8 for row in shown))
        buttons = QDialogButtonBox()
        later = buttons.addButton("Decide &later", QDialogButtonBox.ButtonRole.RejectRole)
        later.setToolTip("Close this dialog, and offer the remaining work again at the next start")
        buttons.rejected.connect(self.reject)
        stack(self, about, self.added, area, buttons, stretched=area)
        later.setDefault(True)
        self.added.setVisible(not has_no_project(context))
        self.setMinimumWidth(600)

    def done(self, result: int) -> None:
        for row in self.rows.values():
            if row is not self._restoring:
                row.left.release()
        super().done(result)

    def _restore(self, number: int) -> None:
        self._restoring = row = self.rows[number]
        self._list.setEnabled(False)
        row.restore_button.setText("Restoring…")

        def end() -> None:
            self._restoring = None
            self._list.setEnabled(True)
            row.restore_button.setText("Restore")

        def take() -> None:
            self._context.notes.show_message(f"{name_of(row.left)} restored: save it to keep it.")
            end()
            self.added.show()
            self._remove(number)

        def fail() -> None:
            end()
            if not self.isVisible():  # closed meanwhile
                row.left.release()

        Restoring(self._context, row.left).restore(take, fail)

    def _ask_discard(self, number: int) -> None:
        text = f"The unsaved work on {name_of(self.rows[number].left)} is deleted permanently."
        ask(self, "Discard unsaved work?", text, "", [("&Discard", DESTROY, partial(self._discard, number))])

    def _discard(self, number: int) -> None:
        try:
            self.rows[number].left.discard()
        except OSError as error:
            self._context.notes.report("Not discarded", error)
        else:
            self._remove(number)

    def _remove(self, number: int) -> None:
        self.rows.pop(number).hide()
        if not self.rows:
            self.accept()


class _Row(QFrame):
    """Row of one unsaved work."""

    def __init__(self, left: RecoverableWork) -> None:
        super().__init__()
        self.left = left
        self.setFrameShape(QFrame.Shape.StyledPanel)
        title = name_of(left)
        picture = PlainLabel("No picture", alignment=Qt.AlignmentFlag.AlignCenter, enabled=False)
        picture.setFixedWidth(_PICTURE)
        picture.setAccessibleName(f"Picture of {title}")
        pixels = QPixmap()
        if pixels.loadFromData(left.picture() or b""):
            mode = Qt.TransformationMode.SmoothTransformation
            picture.setPixmap(pixels.scaled(_PICTURE, _PICTURE, Qt.AspectRatioMode.KeepAspectRatio, mode))
            picture.setEnabled(True)
        name = PlainLabel(title)
        name.setWordWrap(True)
        bold = name.font()
        bold.setBold(True)
        name.setFont(bold)
        when, what = Message(), Message()
        when.show_message("" if left.header is None else f"Last change {_age(left.header.changed)}")
        what.show_message(left.problem or "\n".join(_details(left)), "error" if left.problem else "text")
        self.restore_button = QPushButton("Restore")
        self.restore_button.setToolTip("Open the work in its last state; save it as a project afterwards")
        self.restore_button.setEnabled(not left.problem)
        self.discard_button = QPushButton("Discard…")
        self.discard_button.setToolTip("Delete this work permanently")
        buttons = self.restore_button, self.discard_button
        for button in buttons:
            button.setAccessibleName(f"{button.text().rstrip('…')} {title}")
        grid = QGridLayout(self)
        grid.setColumnStretch(1, 1)
        grid.setHorizontalSpacing(12)
        grid.addWidget(picture, 0, 0, 4, 1)
        for line, widget in enumerate((name, when, what)):
            grid.addWidget(widget, line, 1)
        grid.setRowStretch(2, 1)
        grid.addLayout(lay_out(QHBoxLayout(), None, *buttons), 3, 1)


def _details(left: RecoverableWork) -> list[str]:
    """Describe unsaved work in lines."""
    frames, all_frames = left.frames, left.read.project.frames
    count = counted(len(all_frames), "frame")
    changed = f"{len(frames)} of {count} changed"
    lines = [changed if frames else f"{count}: no work on frames, but the list or its settings have changed"]
    if left.project:
        lines.append(f"Project {left.project}")
    if left.header is not None and left.header.host != socket.gethostname():
        lines.append(f"From computer {left.header.host}")
    return [*lines, *left.read.problems]


def _age(moment: datetime) -> str:
    """Format a time as age and date."""
    passed = (datetime.now(UTC) - moment).total_seconds()
    units = (("day", 86400), ("hour", 3600), ("minute", 60))
    ago = next((f"{counted(int(passed // span), unit)} ago" for unit, span in units if passed >= span), "just now")
    return f"{ago}, {moment.astimezone():%d %B %Y at %H:%M:%S}"


def _found_work() -> Generator[None, None, list[RecoverableWork]]:
    yield None
    return find_recoverable_work(autosave_folder())


# The autosave of the window, with a label in the status bar while it fails.

MEANING = "Your work is in memory only. The autosave is retried every few seconds. Save the project to be safe."


class AutosaveFeature(Feature):
    """Starts the autosave, reports its failures, and offers unsaved work of earlier windows."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.dialog: RecoveryDialog | None = None
        """The dialog that offered unsaved work; None if there was none."""
        self._search = Worker(self)
        self._search.finished.connect(self._offer)
        self._search.failed.connect(lambda error: context.notes.report("Unsaved work", error))
        self.label = Message()
        self.label.setWordWrap(False)
        self.label.setAlignment(Qt.AlignmentFlag.AlignVCenter)
        self.label.setAccessibleName("State of the autosave")
        self.label.hide()
        context.window.statusBar().addPermanentWidget(self.label)
        context.recorder.failed.connect(self._tell_failure)
        context.recorder.kept.connect(self._tell_kept)

    def begin(self) -> None:
        """Start the autosave and the recovery, in a window that stores settings."""
        if self.context.panels.persistent:
            self.context.recorder.start()
            self._search.start(_found_work)

    def shutdown(self) -> None:
        """Stop permanently; the remaining work has been saved or is discarded, undecided work is kept."""
        if self.dialog is not None:
            self.dialog.reject()
        self.context.recorder.shutdown()
        with contextlib.suppress(OSError):  # a folder that cannot be deleted is offered at the next start
            self.context.recorder.store.discard()

    def _offer(self, found: Sequence[RecoverableWork]) -> None:
        if found:
            self.dialog = RecoveryDialog(self.context, found)
            self.dialog.open()

    def _tell_failure(self, error: Exception) -> None:
        if self.label.isHidden():
            self.context.notes.warn("Not autosaved", [error_text(error), MEANING], error_details(error))
        self.label.show_message("Not autosaved", "warning")
        self.label.show()
        self.label.setToolTip(f"<p>{html.escape(str(error))}</p><p>{MEANING}</p>")
        self.label.setAccessibleDescription(str(error))

    def _tell_kept(self) -> None:
        if not self.label.isHidden():
            self.label.hide()
            self.context.notes.show_message("The autosave works again: all work is stored.")
