"""Autosave: work is written to a folder soon after every change, and offered again after the window closed
unexpectedly."""

from __future__ import annotations

import contextlib
import html
import socket
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from PySide6.QtCore import QObject, Qt
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
from ilf.project.project import Stage
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


@dataclass(frozen=True)
class UnsavedWorkInfo:
    """Description of unsaved work.

    Attributes
    ----------
    name : str
        Name of the project, or of the frames.
    changed : datetime or None
        Time of the last change.
    details : tuple of str
        Description, a line each.
    picture : bytes or None
        A JPEG image.
    problem : str
        Why it cannot be restored; "" if it can.
    """

    name: str
    changed: datetime | None
    details: tuple[str, ...]
    picture: bytes | None = None
    problem: str = ""


_Do = Callable[[int], None]


class RecoveryDialog(QDialog):
    """Dialog with a row per unsaved work, to restore it, discard it, or decide later.

    Parameters
    ----------
    works : sequence of UnsavedWorkInfo
    restore, discard : callable
        Called with the number of the work.
    parent : QWidget
    """

    def __init__(self, works: Sequence[UnsavedWorkInfo], restore: _Do, discard: _Do, parent: QWidget) -> None:
        super().__init__(parent)
        self._restore_work = restore
        self.setWindowTitle("Restore Unsaved Work")
        about = Message(lines=2)
        about.show_message(_ABOUT, "text")
        self.added = Message()
        self.rows = {number: _Row(work) for number, work in enumerate(works)}
        for number, row in self.rows.items():
            row.restore_button.clicked.connect(lambda _=False, number=number: self._restore(number))
            row.discard_button.clicked.connect(lambda _=False, number=number: discard(number))
            row.later_button.clicked.connect(lambda _=False, number=number: self.remove(number))
            row.later_button.setVisible(len(works) > 1)  # with a single row, the dialog's own button does the same
        inside = QWidget()
        lay_out(QVBoxLayout(inside), *self.rows.values(), None, spacing=8)
        area = scrolled(inside)
        shown = list(self.rows.values())[:_MAX_ROWS_SHOWN]
        area.setMinimumHeight(sum(row.sizeHint().height() + 8 for row in shown))
        buttons = QDialogButtonBox()
        later = buttons.addButton("Decide &later", QDialogButtonBox.ButtonRole.RejectRole)
        later.setToolTip("Close this dialog, and offer the remaining work again at the next start")
        buttons.rejected.connect(self.reject)
        stack(self, about, self.added, area, buttons, stretched=area)
        self.setMinimumWidth(600)
        self.show_added(False)

    def show_added(self, on: bool) -> None:
        """Show whether restored frames are added to an existing project."""
        self.added.setVisible(on)
        self.added.show_message(_ADDED if on else "")

    def remove(self, number: int) -> None:
        """Remove the row of work that was restored, discarded or postponed."""
        row = self.rows.pop(number, None)
        if row is not None:
            row.hide()
            row.deleteLater()
        if not self.rows:
            self.accept()

    def _restore(self, number: int) -> None:
        for row in self.rows.values():
            row.wait(row is self.rows[number])
        self._restore_work(number)

    def go_on(self) -> None:
        """Enable the remaining rows after a restore."""
        for row in self.rows.values():
            row.go_on()


class _Row(QFrame):
    """Row of one unsaved work."""

    def __init__(self, work: UnsavedWorkInfo) -> None:
        super().__init__()
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self._problem = work.problem
        picture = PlainLabel()
        picture.setAlignment(Qt.AlignmentFlag.AlignCenter)
        picture.setFixedWidth(_PICTURE)
        picture.setAccessibleName(f"Picture of {work.name}")
        pixels = QPixmap()
        if work.picture is not None and pixels.loadFromData(work.picture):
            mode = Qt.TransformationMode.SmoothTransformation
            picture.setPixmap(pixels.scaled(_PICTURE, _PICTURE, Qt.AspectRatioMode.KeepAspectRatio, mode))
        else:
            picture.setText("No picture")
            picture.setEnabled(False)
        name = PlainLabel(work.name)
        name.setWordWrap(True)
        bold = name.font()
        bold.setBold(True)
        name.setFont(bold)
        when, what = Message(), Message()
        when.show_message("" if work.changed is None else f"Last change {format_age(work.changed)}", "muted")
        what.show_message(work.problem or "\n".join(work.details), "error" if work.problem else "text")
        self.restore_button = QPushButton("Restore", autoDefault=False)
        self.restore_button.setToolTip("Open the work in its last state; save it as a project afterwards")
        self.discard_button = QPushButton("Discard…", autoDefault=False)
        self.discard_button.setToolTip("Delete this work permanently")
        self.later_button = QPushButton("Later", autoDefault=False)
        self.later_button.setToolTip("Keep the work, and offer it again at the next start")
        self._buttons = self.restore_button, self.discard_button, self.later_button
        for button in self._buttons:
            button.setAccessibleName(f"{button.text().rstrip('…')} {work.name}")
        grid = QGridLayout(self)
        grid.setColumnStretch(1, 1)
        grid.setHorizontalSpacing(12)
        grid.addWidget(picture, 0, 0, 4, 1)
        for line, widget in enumerate((name, when, what)):
            grid.addWidget(widget, line, 1)
        grid.setRowStretch(2, 1)
        grid.addLayout(lay_out(QHBoxLayout(), None, *self._buttons), 3, 1)
        self.go_on()

    def wait(self, is_this: bool) -> None:
        """Disable the row while some work is being restored."""
        for button in self._buttons:
            button.setEnabled(False)
        if is_this:
            self.restore_button.setText("Restoring…")

    def go_on(self) -> None:
        """Enable the row after a restore."""
        self.restore_button.setText("Restore")
        self.restore_button.setEnabled(not self._problem)
        self.discard_button.setEnabled(True)
        self.later_button.setEnabled(True)


def format_age(moment: datetime, now: datetime | None = None) -> str:
    """Format a time as age and date.

    Examples
    --------
    >>> noon = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
    >>> format_age(noon, noon.replace(minute=5)).split(",")[0]
    '5 minutes ago'
    """
    passed = ((now or datetime.now(UTC)) - moment).total_seconds()
    for seconds, unit in ((86400, "day"), (3600, "hour"), (60, "minute")):
        count = int(passed // seconds)
        if count:
            ago = f"{counted(count, unit)} ago"
            break
    else:
        ago = "just now"
    return f"{ago}, {moment.astimezone():%d %B %Y at %H:%M:%S}"


# Offers unsaved work of earlier windows at the start.

_STAGES = {
    Stage.UNTOUCHED: "without blocks",
    Stage.EXTRACTED: "as extracted",
    Stage.EDITED: "with edited blocks",
    Stage.RUN: "with results",
    Stage.FAILED: "that failed",
}


class Recovery(QObject):
    """Looks for unsaved work in the background, and asks whether to restore it."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self._context = context
        self._found: list[RecoverableWork] = []
        self._handled: set[int] = set()
        self.dialog: RecoveryDialog | None = None
        self._worker = Worker(self)
        self._worker.finished.connect(self._offer)
        self._worker.failed.connect(lambda error: context.notes.report("Unsaved work", error))

    def look(self) -> None:
        """Look for unsaved work, and offer what is found."""
        if self.dialog is None and not self._worker.busy:
            self._worker.start(_found_work)

    def _offer(self, found: list[tuple[RecoverableWork, UnsavedWorkInfo]]) -> None:
        if not found:
            return
        self._found, self._handled = [left for left, _ in found], set()
        works = [offered for _, offered in found]
        self.dialog = RecoveryDialog(works, self._restore, self._discard, self._context.window)
        self.dialog.finished.connect(self._close)
        self.dialog.show_added(not has_no_project(self._context))
        self.dialog.open()

    def _restore(self, number: int) -> None:
        self._handled.add(number)  # `Restoring` releases it
        Restoring(self._context, self._found[number]).restore(
            lambda: self._restored(number), lambda: self._failed(number)
        )

    def _failed(self, number: int) -> None:
        """Keep the work for the next start."""
        if self.dialog is None:
            self._found[number].release()
            return
        self._handled.discard(number)
        self.dialog.go_on()

    def _restored(self, number: int) -> None:
        self._context.notes.show_message(f"{name_of(self._found[number])} restored: save it to keep it.")
        if self.dialog is not None:
            self.dialog.go_on()
            self.dialog.show_added(True)
            self.dialog.remove(number)

    def _discard(self, number: int) -> None:
        left = self._found[number]
        text = f"The unsaved work on {name_of(left) or left.path.name} is deleted permanently."
        answers = (("&Discard", DESTROY, lambda: self._delete(number)),)
        ask(self.dialog or self._context.window, "Discard unsaved work?", text, "", answers)

    def _delete(self, number: int) -> None:
        left = self._found[number]
        try:
            left.discard()
        except OSError as error:
            self._context.notes.report("Not discarded", error)
            return
        self._handled.add(number)
        if self.dialog is not None:
            self.dialog.remove(number)

    def _close(self) -> None:
        for number, left in enumerate(self._found):
            if number not in self._handled:
                left.release()
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            dialog.deleteLater()


def _found_work() -> Generator[None, None, list[tuple[RecoverableWork, UnsavedWorkInfo]]]:
    yield None
    return [(left, _offered(left)) for left in find_recoverable_work(autosave_folder())]


def _offered(left: RecoverableWork) -> UnsavedWorkInfo:
    """Describe unsaved work; called in a worker thread."""
    if left.header is None or left.problem:
        return UnsavedWorkInfo(left.path.name, left.header.changed if left.header else None, (), problem=left.problem)
    frames, all_frames = left.frames, left.read.project.frames
    stages = Counter(frame.summary.stage for frame in frames)
    parts = [f"{stages[stage]} {text}" for stage, text in _STAGES.items() if stages[stage]]
    count = counted(len(all_frames), "frame")
    changed = f"{len(frames)} of {count} changed: {', '.join(parts)}"
    lines = [changed if frames else f"{count}: no work on frames, but the list or its settings have changed"]
    if left.project:
        lines.append(f"Project {left.project}")
    if left.header.host != socket.gethostname():
        lines.append(f"From computer {left.header.host}")
    lines += left.read.problems
    return UnsavedWorkInfo(name_of(left), left.header.changed, tuple(lines), left.picture())


# The autosave of the window, with a label in the status bar while it fails.

MEANING = "Your work is in memory only. The autosave is retried every few seconds. Save the project to be safe."


class AutosaveFeature(Feature):
    """Starts the autosave, and reports its failures."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.recovery = Recovery(context)
        self.label = Message()
        self.label.setWordWrap(False)
        self.label.setAlignment(Qt.AlignmentFlag.AlignVCenter)
        self.label.setAccessibleName("State of the autosave")
        self.label.hide()
        context.window.statusBar().addPermanentWidget(self.label)
        context.recorder.failed.connect(self._tell_failure)
        context.recorder.kept.connect(self._tell_kept)
        self._failing = False

    def begin(self) -> None:
        """Start the autosave and the recovery, in a window that stores settings."""
        if self.context.panels.persistent:
            self.context.recorder.start()
            self.recovery.look()

    def shutdown(self) -> None:
        """Stop permanently; the remaining work has been saved or is discarded, undecided work is kept."""
        if self.recovery.dialog is not None:
            self.recovery.dialog.reject()
        self.context.recorder.shutdown()
        with contextlib.suppress(OSError):  # a folder that cannot be deleted is offered at the next start
            self.context.recorder.store.discard()

    def _tell_failure(self, error: Exception) -> None:
        self._show_failure(str(error))
        if not self._failing:
            self._failing = True
            self.context.notes.warn("Not autosaved", [error_text(error), MEANING], error_details(error))

    def _tell_kept(self) -> None:
        if self._failing:
            self._failing = False
            self._show_failure("")
            self.context.notes.show_message("The autosave works again: all work is stored.")

    def _show_failure(self, why: str) -> None:
        """Show a sentence why the autosave fails; "" if it works."""
        self.label.show_message("Not autosaved", "warning")
        self.label.setVisible(bool(why))
        self.label.setToolTip(f"<p>{html.escape(why)}</p><p>{MEANING}</p>")
        self.label.setAccessibleDescription(why)
