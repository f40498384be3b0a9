"""Reports of frames, written in the background, one at a time."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from gui.desk import Desk, Part
from gui.dialogs.saving import ask_path
from gui.report.commands import COMMANDS
from gui.report.dialog import ALL_FRAMES, ReportDialog
from gui.report.job import write_steps
from gui.report.subjects import subjects_of
from gui.state.entries import Entry
from gui.widgets.problems import error_text
from gui.work.cores import spare_cores
from gui.work.worker import Worker
from ilf.judgement import Step
from ilf.report import ReportOptions
from ilf.run.options import as_file_name

_KINDS = {"html": "HTML page (*.html)", "pdf": "PDF (*.pdf)"}


class ReportPart(Part):
    """*File > Report…*: the dialog, and what it starts."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        desk.actions.add(COMMANDS)
        desk.actions["report"].triggered.connect(lambda _=False: self.ask())
        self.dialog = ReportDialog(desk.window)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._show_steps)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self.dialog.end("Cancelled: nothing was written."))
        self.dialog.wished.connect(self._choose_file)
        self.dialog.cancelled.connect(self.worker.cancel)
        desk.workspace.session_changed.connect(self._allow)
        self._allow()

    def ask(self) -> None:
        """Ask what is wished for, by the dialog."""
        if not self.worker.busy:
            self._describe()
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

    def write(self, path: Path, every: bool = False) -> None:
        """Write a report of the present frame, or of every frame that has been worked on, as the dialog says."""
        workspace = self.desk.workspace
        if self.worker.busy or not workspace.has_session:
            return
        present = workspace.entries.of(workspace.session.id)
        entries = self._worked_on() if every else [present] if present is not None else []
        subjects = subjects_of(entries, self.desk.store, workspace.shared.values if workspace.shared.on else None)
        options = ReportOptions("Report", self.dialog.test, threads=spare_cores())
        self.dialog.begin()
        self.worker.start(lambda: write_steps(path, subjects, len(entries), options))

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread is left."""
        ended = self.worker.shutdown()
        self.dialog.close()
        return ended

    def _choose_file(self) -> None:
        workspace = self.desk.workspace
        if not workspace.has_session:
            self.dialog.end("Open a frame first.", "warning")
            return
        every, format = self.dialog.scope.currentData() == ALL_FRAMES, self.dialog.format.currentData()
        name = "report" if every else f"{as_file_name(workspace.session.name)}-report"
        path = ask_path(self.dialog, "Write report", f"{name}.{format}", _KINDS[format])
        if path:
            self.write(Path(path), every)

    def _describe(self) -> None:
        workspace = self.desk.workspace
        name = workspace.session.name if workspace.has_session else ""
        self.dialog.set_frames(name, len(self._worked_on()))

    def _worked_on(self) -> list[Entry]:
        """Frames that somebody has done anything with, and that are open or stored."""
        store = self.desk.store
        return [
            entry
            for entry in self.desk.workspace.entries
            if entry.summary.is_worked_on and (entry.session is not None or store.has(entry.id))
        ]

    def _show_steps(self, steps: list[Step]) -> None:
        self.dialog.show_step(steps[-1].share, steps[-1].text)

    def _finish(self, path: Path) -> None:
        self.dialog.end()
        self.dialog.accept()
        self.desk.notes.tell(f"Saved {path}")
        if self.dialog.opens.isChecked():
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.absolute())))

    def _fail(self, error: Exception) -> None:
        self.dialog.end(error_text(error), "warning")
        self.desk.notes.report("Report", error)

    def _allow(self) -> None:
        self.desk.actions.allow("" if self.desk.workspace.has_session else "Open a frame first.", "report")
        if self.dialog.isVisible() and not self.worker.busy:
            self._describe()
