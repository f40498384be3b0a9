"""The autosave: the work is kept in a side file as it goes, and offered again after a sudden end."""

from __future__ import annotations

import contextlib

from gui.autosave.recovery import Recovery
from gui.autosave.unkept_label import MEANING, UnkeptLabel
from gui.desk import Desk, Part
from gui.project_file.opening import Opening
from gui.widgets.problems import error_details, error_text
from ilf.project.journals import journal_folder


class AutosavePart(Part):
    """Has the work recorded, and says so where that fails."""

    def __init__(self, desk: Desk, opening: Opening) -> None:
        super().__init__(desk)
        self.recovery = Recovery(desk, opening, journal_folder())
        self.label = UnkeptLabel()
        desk.window.statusBar().addPermanentWidget(self.label)
        desk.recorder.failed.connect(self._tell_failure)
        desk.recorder.kept.connect(self._tell_kept)
        self._failing = False

    def begin(self) -> None:
        """Follow the work, and offer what other windows have left, in a window that remembers."""
        if self.desk.panels.remembers:
            self.desk.recorder.start()
            self.recovery.look()

    def shutdown(self) -> bool:
        """Stop for good; what is left has been saved, or is not to be kept. True if no thread of it is left."""
        ended = all([self.recovery.shutdown(), self.desk.recorder.shutdown()])
        with contextlib.suppress(OSError):  # what cannot be taken away is offered the next time
            self.desk.store.discard()
        return ended

    def _tell_failure(self, error: Exception) -> None:
        self.label.say(str(error))
        if not self._failing:
            self._failing = True
            self.desk.notes.warn("Not autosaved", [error_text(error), MEANING], error_details(error))

    def _tell_kept(self) -> None:
        if self._failing:
            self._failing = False
            self.label.say("")
            self.desk.notes.tell("The autosave works again: all is kept.")
