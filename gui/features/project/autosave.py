"""Autosave: work is written to a folder soon after every change, and offered again after the window closed
unexpectedly."""

from __future__ import annotations

import contextlib
import html
import socket
from collections.abc import Sequence
from functools import partial
from typing import cast

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QPushButton, QTreeWidgetItem

from ilf._runtime.formatting import counted
from ilf.project.recovery import RecoverableWork, autosave_folder, find_recoverable_work

from ...widgets.basics import Message, literal_text, row_list, stack
from ...widgets.notices import DESTROY, ask, error_details, error_text
from ...work.latest_request import LatestRequest
from ..context import Context, Feature
from .feature import ProjectFeature
from .restoring import name_of, restore

# The dialog that offers unsaved work of a window that closed unexpectedly.

_WORK = Qt.ItemDataRole.UserRole
_ABOUT = (
    "ILF Studio or the computer closed unexpectedly. This work is not in a project file yet. It is kept until you "
    "discard it."
)


class RecoveryDialog(QDialog):
    """Dialog with a row per unsaved work, to restore or discard it.

    What is neither restored nor discarded is kept for the next start when the dialog is closed.
    """

    def __init__(self, context: Context, works: Sequence[RecoverableWork]) -> None:
        super().__init__(context.window)
        self._context = context
        self._restoring: RecoverableWork | None = None
        self.setWindowTitle("Restore Unsaved Work")
        about = Message(lines=2)
        about.show_message(_ABOUT, "text")
        self.works = row_list("Unsaved work", "Select work to restore or discard", ["Work", "Last change"], stretched=0)
        self.details = Message(lines=4)
        self.restore_button, self.discard_button = QPushButton("&Restore"), QPushButton("&Discard…")
        self.restore_button.setToolTip("Open the selected work in its last state, as the project of this window")
        self.restore_button.clicked.connect(self._restore)
        self.discard_button.setToolTip("Delete the selected work permanently")
        self.discard_button.clicked.connect(self._ask_discard)
        buttons = QDialogButtonBox()
        buttons.addButton(self.restore_button, QDialogButtonBox.ButtonRole.ActionRole)
        buttons.addButton(self.discard_button, QDialogButtonBox.ButtonRole.ActionRole)
        later = buttons.addButton("Decide &later", QDialogButtonBox.ButtonRole.RejectRole)
        later.setToolTip("Close this dialog, and offer the remaining work again at the next start")
        buttons.rejected.connect(self.reject)
        stack(self, about, self.works, self.details, buttons, stretched=self.works)
        later.setDefault(True)
        self.setMinimumWidth(600)
        self.works.currentItemChanged.connect(lambda *_: self._describe())
        for left in works:
            when = "" if left.header is None else f"{left.header.changed.astimezone():%d %B %Y at %H:%M:%S}"
            item = QTreeWidgetItem([name_of(left), when])
            item.setData(0, _WORK, left)
            item.setToolTip(0, literal_text(name_of(left)))
            self.works.addTopLevelItem(item)
        self.works.setCurrentIndex(self.works.model().index(0, 0))

    def done(self, result: int) -> None:
        for row in range(self.works.topLevelItemCount()):
            left = self._work(self.works.topLevelItem(row))
            if left is not self._restoring:
                left.release()
        super().done(result)

    def _work(self, item: QTreeWidgetItem | None) -> RecoverableWork:
        work: RecoverableWork = cast("QTreeWidgetItem", item).data(0, _WORK)
        return work

    def _describe(self) -> None:
        """Describe the selected work, and offer what can be done with it."""
        if (item := self.works.currentItem()) is None:
            return
        left = self._work(item)
        self.details.show_message(left.problem or "\n".join(_details(left)), "error" if left.problem else "text")
        self.restore_button.setEnabled(self._restoring is None and not left.problem)
        self.discard_button.setEnabled(self._restoring is None)

    def _restore(self) -> None:
        """Restore the selected work as the project of the window, after asking about the present one."""
        item = self.works.currentItem()
        left, opening = self._work(item), self._context.feature(ProjectFeature).opening

        def take() -> None:
            self._context.notes.show_message(f"{name_of(left)} restored: save it to keep it.")
            self._restoring = None
            self._remove(item)

        def fail() -> None:
            self._restoring = None
            self._describe()
            if not self.isVisible():  # closed meanwhile
                left.release()

        def begin() -> None:
            self._restoring = left
            self._describe()
            self.details.show_message("Restoring…")
            opening.begin(lambda: restore(self._context, left, take, fail))

        opening.leave(f"{name_of(left)} is restored", begin)

    def _ask_discard(self) -> None:
        item = self.works.currentItem()
        text = f"The unsaved work on {name_of(self._work(item))} is deleted permanently."
        ask(self, "Discard unsaved work?", text, "", [("&Discard", DESTROY, lambda: self._discard(item))])

    def _discard(self, item: QTreeWidgetItem | None) -> None:
        try:
            self._work(item).discard()
        except OSError as error:
            self._context.notes.report("Not discarded", error)
        else:
            self._remove(item)

    def _remove(self, item: QTreeWidgetItem | None) -> None:
        if item is not None:
            self.works.takeTopLevelItem(self.works.indexOfTopLevelItem(item))
        self._describe()
        if not self.works.topLevelItemCount():
            self.accept()


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


# The autosave of the window, with a label in the status bar while it fails.

MEANING = "Your work is in memory only. The autosave is retried every few seconds. Save the project to be safe."


class AutosaveFeature(Feature):
    """Starts the autosave, reports its failures, and offers unsaved work of earlier windows."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.dialog: RecoveryDialog | None = None
        """The dialog that offered unsaved work; None if there was none."""
        self._search = LatestRequest(self, partial(context.notes.report, "Unsaved work"))
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
            self._search.ask(lambda: find_recoverable_work(autosave_folder()), self._offer)

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
