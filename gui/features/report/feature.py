"""Reports of frames, written in the background, one at a time."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from pathlib import Path

from PySide6.QtCore import QSettings, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QStandardItemModel
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ilf.data.parameters import Parameters
from ilf.data.results import compose
from ilf.errors import IlfError
from ilf.evaluation.evaluation import Step, scaled_progress
from ilf.evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest
from ilf.report.content import Subject, Unreadable
from ilf.report.report import ReportOptions, date_text, report_steps, write_report
from ilf.run.options import as_file_name

from ...base.commands import Command
from ...project.store import WorkStore
from ...state.entries import Entry
from ...state.session import Session
from ...widgets.basics import Message
from ...widgets.notices import error_text
from ...widgets.work_row import WorkRow
from ...work.jobs import Worker, spare_cores
from ..context import Context, Feature
from ..documents.file_dialogs import ask_path
from .pdf import write_pdf

# The report dialog: frames, format, hold-out test and progress.

THIS_FRAME, ALL_FRAMES = "frame", "all"
_FORMATS = {"html": "HTML page, one file for any browser", "pdf": "PDF, for printing or sharing"}
_PATTERNS = {"areas": "areas, like holes in sensor depth", "random": "random pixels"}
_KEY = "report/"
_SEEDS, _MAX_SEEDS = 3, 20


class ReportDialog(QDialog):
    """Dialog of a report: frames, format and hold-out test. It stays open until the report is written.

    Signals
    -------
    requested()
        The user requested the report.
    cancelled()
        The user cancelled the report.
    """

    requested = Signal()
    cancelled = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Report")
        about = Message(lines=3)
        about.show_message(
            "Pictures with scales, blocks with their figures, parameters that differ from the preset, curves, errors, "
            "run history, versions and the hashes of all files, in one self-contained file."
        )
        self.scope = QComboBox()
        self.scope.setToolTip("Frames of the report; several frames get an index with a row for each")
        self._scopes = QStandardItemModel(self)
        self.scope.setModel(self._scopes)
        self.scope.addItem("", THIS_FRAME)
        self.scope.addItem("", ALL_FRAMES)
        self.format = QComboBox()
        self.format.setToolTip("File type of the report")
        for name, text in _FORMATS.items():
            self.format.addItem(text, name)
        self.hidden = QCheckBox("Measure the error on held-out known depth")
        self.hidden.setToolTip(
            "Run a hold-out test for every frame with results; takes about as long as a run per seed"
        )
        self.pattern = QComboBox()
        self.pattern.setToolTip("Which known depth is hidden")
        for name in sorted(HOLD_OUT_PATTERNS):
            self.pattern.addItem(_PATTERNS.get(name, name), name)
        self.seeds = QSpinBox(minimum=1, maximum=_MAX_SEEDS, value=_SEEDS)
        self.seeds.setToolTip("Number of random hold-outs; errors are shown for each and pooled")
        self.opens = QCheckBox("Open when done")
        self.opens.setToolTip("Open the report in the browser or the PDF viewer")
        self.state = Message()
        self.work = WorkRow("report", "nothing is written")

        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Close)
        self.write_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.write_button.setText("&Write…")
        self.write_button.setToolTip("Select the file and write the report in the background")
        buttons.accepted.connect(self.requested)
        buttons.rejected.connect(self.reject)
        self.work.cancelled.connect(self.cancelled)
        self.hidden.toggled.connect(lambda _: self._allow())

        test = QHBoxLayout()
        test.addWidget(self.pattern, 1)
        test.addWidget(self.seeds)
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("F&rames", self.scope)
        form.addRow("&Format", self.format)
        form.addRow("Hold-out test", self.hidden)
        form.addRow("Pattern and seeds", test)
        form.addRow("", self.opens)
        self.pattern.setAccessibleName("Pattern of the hold-out")
        self.seeds.setAccessibleName("Number of seeds")
        self._form = QWidget()
        self._form.setLayout(form)
        form.setContentsMargins(0, 0, 0, 0)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        for widget in (about, self._form, self.state, self.work):
            layout.addWidget(widget)
        layout.addStretch(1)
        layout.addWidget(buttons)
        self.setMinimumWidth(520)
        self._restore()
        self._allow()

    def set_frames(self, name: str, worked_on: int) -> None:
        """Set the name of the current frame, and the number of frames that have been worked on."""
        self.scope.setItemText(0, f"This frame: {name}")
        self.scope.setItemText(1, f"All frames that have been worked on: {worked_on}")
        item = self._scopes.item(1)
        item.setEnabled(worked_on > 0)
        if not worked_on:
            self.scope.setCurrentIndex(0)
        self.state.show_message("")

    @property
    def test(self) -> HoldOutTest | None:
        """The hold-out test; None for no test."""
        if not self.hidden.isChecked():
            return None
        return HoldOutTest(str(self.pattern.currentData()), tuple(range(self.seeds.value())))

    def begin(self) -> None:
        """Show that the report is being written."""
        self._keep()
        self._form.setEnabled(False)
        self.write_button.setEnabled(False)
        self.state.show_message("")
        self.work.begin()

    def show_step(self, share: float, text: str) -> None:
        """Show the share done, 0-1, and the current step."""
        self.work.show_share(share)
        self.state.show_message(text)

    def end(self, text: str = "", tone: str = "muted") -> None:
        """Show that the report has ended, with a message."""
        self.work.end()
        self._form.setEnabled(True)
        self.write_button.setEnabled(True)
        self.state.show_message(text, tone)

    def reject(self) -> None:
        self.cancelled.emit()  # on any way of closing
        super().reject()

    def _allow(self) -> None:
        for widget in (self.pattern, self.seeds):
            widget.setEnabled(self.hidden.isChecked())

    def _restore(self) -> None:
        settings = QSettings()
        for box, name in ((self.format, "format"), (self.pattern, "pattern")):
            box.setCurrentIndex(max(box.findData(settings.value(_KEY + name, box.itemData(0))), 0))
        self.hidden.setChecked(bool(settings.value(_KEY + "hidden", False, bool)))
        self.seeds.setValue(int(str(settings.value(_KEY + "seeds", _SEEDS, int))))
        self.opens.setChecked(bool(settings.value(_KEY + "open", True, bool)))

    def _keep(self) -> None:
        settings = QSettings()
        settings.setValue(_KEY + "format", self.format.currentData())
        settings.setValue(_KEY + "pattern", self.pattern.currentData())
        settings.setValue(_KEY + "hidden", self.hidden.isChecked())
        settings.setValue(_KEY + "seeds", self.seeds.value())
        settings.setValue(_KEY + "open", self.opens.isChecked())


# Conversion of frames of the window to subjects of a report.


def subject_of(session: Session) -> Subject:
    """Snapshot of an open frame; later changes do not affect it."""
    completion = session.completion() or compose(session.frame, {})
    infos = {label: session.info(label) for label in session.counts()}
    return Subject(
        session.run(session.common, extrapolate=session.extrapolated),
        completion,
        {label: info.name for label, info in infos.items()},
        {label: info.colour for label, info in infos.items()},
        session.note,
        tuple(session.run_history),
    )


def subjects_of(
    entries: Sequence[Entry], store: WorkStore, for_all: Parameters | None
) -> Iterator[Subject | Unreadable]:
    """Subjects of frames, open or not; closed frames are read when they are reached.

    Call in the GUI thread, iterate in any thread. `for_all`: the parameters shared by all frames, if any.
    """
    open_ones = {entry.id: subject_of(entry.session) for entry in entries if entry.session is not None}
    noted = [(entry, entry.note) for entry in entries]
    return (open_ones.get(entry.id) or _stored(entry, note, store, for_all) for entry, note in noted)


def _stored(entry: Entry, note: str, store: WorkStore, for_all: Parameters | None) -> Subject | Unreadable:
    try:
        decoded = store.read(entry.id, entry.source)
    except IlfError as error:
        return Unreadable(entry.name, str(error))
    return Subject.of_state(decoded.state.with_current_settings(note, for_all), problems=decoded.problems)


# Writing of a report, step by step, for any thread.

_OF_CONTENT = 0.8
"""Share of the work done before the pages are written."""


def write_steps(
    path: Path, subjects: Iterable[Subject | Unreadable], count: int, options: ReportOptions
) -> Generator[Step, None, Path]:
    """Write a report of `count` subjects, as PDF if that is the suffix, otherwise as HTML.

    Raises
    ------
    InputError
        As from `ilf.report.report.report_steps`.
    ExportError
        If the file cannot be written; an existing file stays unchanged.
    """
    content = yield from scaled_progress(report_steps(subjects, options, count), 0.0, _OF_CONTENT)
    if path.suffix.lower() == ".pdf":
        yield from scaled_progress(
            write_pdf(path, content, date_text(options)), _OF_CONTENT, 1 - _OF_CONTENT, "writing "
        )
    else:
        yield Step(_OF_CONTENT, "writing")
        write_report(path, content, options)
    return path


_KINDS = {"html": "HTML page (*.html)", "pdf": "PDF (*.pdf)"}


class ReportFeature(Feature):
    """The command *File > Report…*: its dialog and the report."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        context.actions.add(
            (
                Command(
                    "report",
                    "&Report…",
                    "Write a page on this frame or all frames, as HTML or PDF: "
                    "pictures, blocks, parameters, curves, errors",
                    icon="ph.file-text",
                    handler=self.ask,
                    why_off=context.reasons.no_frame,
                ),
            )
        )
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
        if self.worker.busy or not workspace.has_session:
            return
        present = workspace.frames.entries.of(workspace.session.id)
        entries = self._worked_on() if every else [present] if present is not None else []
        subjects = subjects_of(
            entries,
            self.context.recorder.store,
            workspace.parameters.shared.values if workspace.parameters.shared.on else None,
        )
        options = ReportOptions("Report", self.dialog.test, threads=spare_cores())
        self.dialog.begin()
        self.worker.start(lambda: write_steps(path, subjects, len(entries), options))

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if all threads have ended."""
        ended = self.worker.shutdown()
        self.dialog.close()
        return ended

    def _choose_file(self) -> None:
        workspace = self.context.workspace
        if not workspace.has_session:
            self.dialog.end("Open a frame first.", "warning")
            return
        every, format = self.dialog.scope.currentData() == ALL_FRAMES, self.dialog.format.currentData()
        name = "report" if every else f"{as_file_name(workspace.session.name)}-report"
        path = ask_path(self.dialog, "Write report", f"{name}.{format}", _KINDS[format])
        if path:
            self.write(Path(path), every)

    def _describe(self) -> None:
        workspace = self.context.workspace
        name = workspace.session.name if workspace.has_session else ""
        self.dialog.set_frames(name, len(self._worked_on()))

    def _worked_on(self) -> list[Entry]:
        """Frames that have been worked on and are open or stored."""
        store = self.context.recorder.store
        return [
            entry
            for entry in self.context.workspace.frames.entries
            if entry.summary.has_work and (entry.session is not None or store.has(entry.id))
        ]

    def _show_steps(self, steps: list[Step]) -> None:
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
