"""Autosave: work is written to a folder soon after every change, with a label in the status bar while that fails, and
offered again after the window closed unexpectedly."""

from __future__ import annotations

import contextlib
import html
from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import Qt

from ilf.project.recovery import RecoverableWork, autosave_folder, find_recoverable_work

from ...widgets.basics import Message
from ...widgets.notices import error_details, error_text
from ...work.latest_request import LatestRequest
from ...work.steps import Steps, in_steps
from ..context import Context, Feature

MEANING = "Your work is in memory only. The autosave is retried every few seconds. Save the project to be safe."


class AutosaveFeature(Feature):
    """Starts the autosave, reports its failures, and offers unsaved work of earlier windows."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._offered: list[RecoverableWork] = []
        """What is not decided yet."""
        self._search = LatestRequest(self, partial(context.notes.report, "Unsaved work"))
        self.label = Message()
        self.label.setWordWrap(False)
        self.label.setAlignment(Qt.AlignmentFlag.AlignVCenter)
        self.label.setAccessibleName("State of the autosave")
        self.label.hide()
        context.window.statusBar().addPermanentWidget(self.label)
        context.recorder.failed.connect(self._tell_failure)
        context.recorder.kept.connect(self._tell_kept)
        if context.persistent:
            context.recorder.start()
            self._search.ask(lambda: find_recoverable_work(autosave_folder()), self._offer)

    def shutdown(self) -> None:
        """Stop permanently; the remaining work has been saved or is discarded, undecided work is kept."""
        for left in self._offered:
            left.release()
        self.context.recorder.shutdown()
        with contextlib.suppress(OSError):  # a folder that cannot be deleted is offered at the next start
            self.context.recorder.store.discard()

    @in_steps
    def _offer(self, found: Sequence[RecoverableWork]) -> Steps[None]:
        """Offer unsaved work, one after the other."""
        from .recovery import ask_what_to_do  # made on use

        self._offered = [*found]
        for left in found:
            yield from ask_what_to_do(self.context, left)
            left.release()
            self._offered.remove(left)

    def _tell_failure(self, error: Exception) -> None:
        if self.label.isHidden():
            self.notes.warn("Not autosaved", [error_text(error), MEANING], error_details(error))
        self.label.show_message("Not autosaved", "warning")
        self.label.show()
        self.label.setToolTip(f"<p>{html.escape(str(error))}</p><p>{MEANING}</p>")
        self.label.setAccessibleDescription(str(error))

    def _tell_kept(self) -> None:
        if not self.label.isHidden():
            self.label.hide()
            self.notes.show_message("The autosave works again: all work is stored.")
