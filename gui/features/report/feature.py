"""Reports of frames, written in the background, one at a time."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from ilf._runtime.writing import write_bytes
from ilf.data.parameters import Parameters
from ilf.data.results import compose
from ilf.errors import IlfError
from ilf.evaluation.evaluation import Progress, scaled_progress
from ilf.report.report import ReportOptions, report_steps, write_report
from ilf.report.subject import Subject, Unreadable
from ilf.run.options import as_file_name

from ...project.store import WorkStore
from ...state.document import Document
from ...state.entries import Entry
from ...widgets.file_choice import ask_path
from ...widgets.notices import error_text
from ...work.jobs import Worker, spare_cores
from ..context import Context, Feature
from .dialog import ALL_FRAMES, ReportDialog
from .pdf import pdf_steps

# Conversion of frames of the window to subjects of a report.


def subject_of(document: Document) -> Subject:
    """Snapshot of an open frame; later changes do not affect it."""
    run = document.run(document.state.common, extrapolate=document.extrapolated)
    infos = {label: document.info(label) for label in document.counts()}
    return Subject(
        run,
        document.completion() or compose(run, {}),
        {label: info.name for label, info in infos.items()},
        {label: info.colour for label, info in infos.items()},
        document.state.note,
        tuple(document.state.runs),
    )


def subjects_of(
    entries: Sequence[Entry], store: WorkStore, for_all: Parameters | None
) -> Iterator[Subject | Unreadable]:
    """Subjects of frames, open or not; closed frames are read when they are reached.

    Call in the GUI thread, iterate in any thread. `for_all`: the parameters shared by all frames, if any.
    """
    open_ones = {entry.id: subject_of(entry.document) for entry in entries if entry.document is not None}
    noted = [(entry, entry.note) for entry in entries]
    return (open_ones.get(entry.id) or _stored(entry, note, store, for_all) for entry, note in noted)


def _stored(entry: Entry, note: str, store: WorkStore, for_all: Parameters | None) -> Subject | Unreadable:
    try:
        decoded = store.read(entry.id)
    except IlfError as error:
        return Unreadable(entry.name, str(error))
    return Subject.of_state(decoded.state.with_current_settings(note, for_all), problems=decoded.problems)


# Writing of a report, step by step, for any thread.

_OF_CONTENT = 0.8
"""Share of the work done before the pages are written."""


def write_steps(
    path: Path, subjects: Iterable[Subject | Unreadable], count: int, options: ReportOptions
) -> Generator[Progress, None, Path]:
    """Write a report of `count` subjects, as PDF if that is the suffix, otherwise as HTML.

    Raises
    ------
    InputError
        As from `ilf.report.report.report_steps`.
    ExportError
        If the file cannot be written; an existing file stays unchanged.
    """
    report = yield from scaled_progress(report_steps(subjects, options, count), 0.0, _OF_CONTENT)
    if path.suffix.lower() == ".pdf":
        write_bytes(path, (yield from scaled_progress(pdf_steps(report), _OF_CONTENT, 1 - _OF_CONTENT, "writing ")))
    else:
        yield Progress(_OF_CONTENT, "writing")
        write_report(path, report)
    return path


_KINDS = {"html": "HTML page (*.html)", "pdf": "PDF (*.pdf)"}


class ReportFeature(Feature):
    """Writes reports, one at a time, with its dialog."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.dialog = ReportDialog(context.window)
        self.worker = Worker(self)
        self.worker.progressed.connect(self._show_steps)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self.dialog.end("Cancelled. Nothing was written."))
        self.dialog.requested.connect(self._choose_file)
        self.dialog.cancelled.connect(self.worker.cancel)
        context.workspace.frames.session_changed.connect(self._describe_again)

    def ask(self) -> None:
        """Open the dialog."""
        if not self.worker.busy:
            self._describe()
        self.dialog.show()
        self.dialog.raise_()
        self.dialog.activateWindow()

    def write(self, path: Path, every: bool = False) -> None:
        """Write a report of the current frame, or of all worked-on frames, with the settings of the dialog."""
        workspace = self.context.workspace
        if self.worker.busy or not workspace.has_current:
            return
        present = workspace.entries.of(workspace.current.id)
        entries = self._worked_on() if every else [present] if present is not None else []
        subjects = subjects_of(
            entries,
            self.context.recorder.store,
            workspace.parameters.shared.values if workspace.parameters.shared.on else None,
        )
        options = ReportOptions("Report", self.dialog.test, threads=spare_cores())
        self.dialog.begin()
        self.worker.start(lambda: write_steps(path, subjects, len(entries), options))

    def _choose_file(self) -> None:
        workspace = self.context.workspace
        if not workspace.has_current:
            self.dialog.end("Open a frame first.", "warning")
            return
        every, format = self.dialog.scope.currentData() == ALL_FRAMES, self.dialog.format.currentData()
        name = "report" if every else f"{as_file_name(workspace.current.name)}-report"
        path = ask_path(self.dialog, "Write report", f"{name}.{format}", _KINDS[format])
        if path:
            self.write(Path(path), every)

    def _describe(self) -> None:
        workspace = self.context.workspace
        name = workspace.current.name if workspace.has_current else ""
        self.dialog.set_frames(name, len(self._worked_on()))

    def _worked_on(self) -> list[Entry]:
        """Frames that have been worked on and are open or stored."""
        store = self.context.recorder.store
        return [
            entry
            for entry in self.context.workspace.entries
            if entry.summary.has_work and (entry.document is not None or store.has(entry.id))
        ]

    def _show_steps(self, steps: list[Progress]) -> None:
        self.dialog.show_step(steps[-1].share, steps[-1].text)

    def _finish(self, path: Path) -> None:
        self.dialog.end()
        self.dialog.accept()
        self.context.notes.show_message(f"Saved {path}")
        if self.dialog.opens.isChecked():
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.absolute())))

    def _fail(self, error: Exception) -> None:
        self.dialog.end(error_text(error), "warning")
        self.context.notes.report("Report", error)

    def _describe_again(self) -> None:
        if self.dialog.isVisible() and not self.worker.busy:
            self._describe()
