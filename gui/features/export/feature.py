"""Exports of frames: the dialog with frames, folder and files, the work in the background, and what was written."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Generator, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QSettings, QSignalBlocker, Qt, QUrl
from PySide6.QtGui import QDesktopServices, QStandardItemModel
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QTabWidget,
    QTreeWidgetItem,
    QWidget,
)

from ilf._runtime.files import is_address
from ilf._runtime.formatting import counted
from ilf._runtime.long_work import available_cores
from ilf.batch.pictures import write_contact_sheet, write_video
from ilf.batch.settings import some
from ilf.data.results import Completion
from ilf.errors import IlfError, ParameterError
from ilf.evaluation.evaluation import Progress
from ilf.project.exporting import ExportedFrame, ExportStatus, FrameToExport, export_frames
from ilf.run.options import as_file_name, output_folder_name
from ilf.run.run import Run
from ilf.run.writing import check_cloud_and_mesh, filenames
from ilf.sources.frame_ref import RECORD_FILE
from ilf.sources.naming import META_NAME

from ...base import theme
from ...state.parts import Part
from ...state.workspace import Entry
from ...widgets.basics import Message, combo, form, give_size, label_of, literal_text, row, row_list, scrolled, stack
from ...widgets.file_choice import EXPORTS, EXPORTS_OF_FRAMES, remember_folder, save_folder
from ...widgets.hold_out_choice import HoldOutChoice
from ...widgets.notices import DESTROY, ask, error_text
from ...work.jobs import spare_cores
from ...work.steps import Steps, in_steps
from ..context import Context
from ..documents.feature import DocumentsFeature
from ..frame_list.feature import FramesFeature
from ..panel import Panel
from ..sequence.moment import written_depth
from ..sequence.playing import PlayFeature
from ..status import StatusFeature
from .files import FilesForm, check
from .jobs import (
    Export,
    Scope,
    Step,
    batch_frames,
    batch_steps,
    behind,
    frame_as_shown,
    frames_to_export,
    present_frame,
    report_file_steps,
    settings_of,
    subjects_of,
)

_SOURCES = {
    False: "As in this window, with its blocks and results",
    True: "Anew from the files, with the current parameters",
}
_FORMATS = {"html": "HTML page, one file for any browser", "pdf": "PDF, for printing or sharing"}
_FROM_FILES = (
    "Blocks are extracted, and edits in this window are not used. Starting again resumes: completed frames are "
    "skipped. manifest.csv lists the result of each frame."
)
_FRAMES_KEY = "export/frames"
"""Settings key of the folder of the frames of the last export of several."""

_MAX_NAMED = 3
_OF_SEVERAL = "Blocks without a result are run first. Frames unchanged since an earlier export are skipped."


class ExportFeature(Panel):
    """The dialog of exports, one of which runs at a time. It stays open with what was written, and may be closed
    meanwhile."""

    title, group = "Export", None
    parts = Part.FRAME | Part.LIST | Part.LABELS | Part.RESULTS | Part.PARAMETERS | Part.INVALID_MASK
    what = "export"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._status, self._playing = context.feature(StatusFeature), context.feature(PlayFeature)
        self._run: Run | None = None
        """The run of the current frame as it is shown, and what it has completed."""
        self._completion: Completion | None = None
        self._proposed = ""
        self._export: Export | None = None
        """The export in progress."""
        self._total = 1
        self._done: list[ExportedFrame] = []
        self._ids: dict[str, str] = {}
        """Name of a folder -> id of its frame, while frames are completed from their files."""
        self.requests.ended.connect(self._end_cancelled)
        _ = self.widget

    def make(self) -> QDialog:
        dialog = QDialog(self.context.window)
        give_size(dialog, 760, 690)
        self.scope = combo(
            {scope: scope.value for scope in Scope}, "Frames to export; of several, each gets a folder of its own"
        )
        self.source = combo(_SOURCES, "Where blocks and completed depth are taken from")
        self.folder_path = QLineEdit()
        browse = QPushButton("Browse…")
        browse.setToolTip("Select the folder for the files")
        browse.clicked.connect(self._browse)
        self.files = FilesForm()
        hint = "What has come of each frame; double-click one to open it"
        self.results = row_list("Results of the frames", hint, ("Frame", "Status", "Notes"), stretched=2)
        self.results.itemActivated.connect(lambda item: self._open(item.data(0, Qt.ItemDataRole.UserRole)))
        self.report_page, self.batch_page = self._report_page(), self._batch_page()
        self.tabs = QTabWidget()
        for page, title in (
            (scrolled(self.files), "&Files"),
            (self.report_page, "&Report"),
            (self.batch_page, "&Batch"),
            (self.results, "Re&sults"),
        ):
            self.tabs.addTab(page, title)
        self.message, self.warning = Message(lines=2), Message()
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.export_button = buttons.addButton("Export", QDialogButtonBox.ButtonRole.AcceptRole)
        self.close_button = buttons.button(QDialogButtonBox.StandardButton.Close)
        buttons.accepted.connect(lambda: self.begin_export(self.request()))
        buttons.rejected.connect(dialog.reject)
        dialog.finished.connect(self._release)
        self._form = QWidget()
        folder = label_of("F&older", self.folder_path), row(self.folder_path, browse)
        form(("Fra&mes", self.scope), ("&Depth", self.source), folder, parent=self._form)
        stack(dialog, self._form, self.tabs, self.message, self.warning, self.work, buttons, stretched=self.tabs)
        for choice in (self.scope, self.source):
            choice.currentIndexChanged.connect(self._turn)
        of_report = self.report.toggled, self.hidden.toggled, self.format.currentIndexChanged
        for changed in (self.folder_path.textChanged, self.files.changed, *of_report):
            changed.connect(self.update_message)
        return dialog

    def _report_page(self) -> QWidget:
        self.report = check(
            "&Write a report on the frames",
            "One self-contained page; several frames get an index with a row for each. It has pictures with scales, "
            "blocks with their figures, parameters that differ from the preset, curves, errors, run history, versions "
            "and the hashes of all files. Of frames that are not open, only those that have been worked on.",
        )
        self.format = combo(_FORMATS, "File type of the report")
        self.hidden = check(
            "Measure the error on held-out known depth",
            "Run a hold-out test for every frame with results; takes about as long as a run per seed",
        )
        self.hold_out = HoldOutChoice()
        self.opens = check("Open when done", "Open the report in the browser or the PDF viewer")
        self.opens.setChecked(True)
        page, fields = QWidget(), QWidget()
        test = ("Hold-out test", self.hidden), ("&Hide", self.hold_out)
        form(("Form&at", self.format), *test, ("", self.opens), parent=fields)
        stack(page, self.report, fields, QWidget())
        return page

    def _batch_page(self) -> QWidget:
        self.jobs = QSpinBox(minimum=1, maximum=available_cores(), value=spare_cores())
        self.jobs.setToolTip("Number of frames completed at the same time; they share the cores")
        self.sheet = check("Contact sheet", "One picture of all frames, with their names, in one depth colour range")
        self.video = check("Video", "Colour, measured and completed depth of all frames in sequence")
        self.retry = check("Failed frames", "Retry frames that failed before")
        self.anew = check(
            "Frames with changed settings or files",
            "Complete frames again whose settings or files have changed since",
        )
        page, fields = QWidget(), QWidget()
        also, redo = row(self.sheet, self.video), row(self.retry, self.anew)
        form(("&Processes", self.jobs), ("Also write", also), ("Redo", redo), parent=fields)
        stack(page, fields, QWidget())
        return page

    # what is offered

    def ask(self, of_all: bool = False, from_files: bool = False, only_report: bool = False) -> None:
        """Open the dialog for the present frame or all, with the last choice of files, or to show the export in
        progress."""
        self.widget.show()
        self.widget.raise_()
        self.widget.activateWindow()
        if self.busy:
            return
        with QSignalBlocker(self.scope), QSignalBlocker(self.source):
            self.scope.setCurrentIndex(self.scope.findData(Scope.ALL if of_all else Scope.THIS))
            self.source.setCurrentIndex(self.source.findData(from_files))
        self.folder_path.setText("")
        self.refresh(self.parts)
        self.files.restore(None if self._run is None else self._run.frame.inputs)
        self.report.setChecked(only_report)
        if only_report:
            self.files.choose_none()
        self.tabs.setCurrentIndex(1 if only_report else 0)
        self.export_button.setDefault(True)
        self.export_button.setFocus()

    def refresh(self, parts: Part) -> None:
        """Offer what can be exported now."""
        if self.busy:
            return
        workspace, model = self.workspace, self.scope.model()
        self._run, self._completion = present_frame(workspace.shown) if workspace.shown is not None else (None, None)
        for number, scope in enumerate(Scope):
            count = len(self._entries(scope))
            name = self._run.frame.name if scope is Scope.THIS and self._run is not None else count
            self.scope.setItemText(number, f"{scope}: {name}")
            if isinstance(model, QStandardItemModel):
                model.item(number).setEnabled(count > 0)
        self._turn()

    def _release(self) -> None:
        """Release the frame, which may be closed while the dialog is not shown."""
        self._run = self._completion = None
        self.files.describe(None)

    def request(self) -> Export:
        """Return what the user wants; ParameterError or InputError if nothing can be exported like this."""
        from_files, scope, folder = bool(self.source.currentData()), Scope(self.scope.currentData()), self._folder()
        name = "" if scope != Scope.THIS or self._run is None else f"{as_file_name(self._run.frame.name)}-"
        writes_report = self.report.isChecked() and not from_files
        options = self.files.options()
        if scope == Scope.THIS and not from_files and self._run is not None:
            check_cloud_and_mesh(self._run.frame, options)
        if not self.folder_path.text().strip():
            raise ParameterError("Choose a target folder.")
        if folder.exists() and not folder.is_dir():
            raise ParameterError(f"{folder} is a file, not a folder. Choose another folder.")
        if not (filenames(None, options) or from_files or writes_report):
            raise ParameterError("Choose at least one file to write.")
        if not self._entries(scope):
            raise ParameterError("There is no such frame. Choose other frames.")
        return Export(
            folder,
            options,
            scope,
            from_files,
            self.jobs.value(),
            [write_contact_sheet] * self.sheet.isChecked() + [write_video] * self.video.isChecked(),
            self.retry.isChecked(),
            self.anew.isChecked(),
            folder / f"{name}report.{self.format.currentData()}" if writes_report else None,
            self.hold_out.test() if self.hidden.isChecked() else None,
        )

    def update_message(self) -> None:
        """Say what the export would write, or why it cannot."""
        for field in (self.format, self.hidden, self.opens):
            field.setEnabled(self.report.isChecked())
        self.hold_out.setEnabled(self.report.isChecked() and self.hidden.isChecked())
        if self.busy:
            return
        self._allow()
        try:
            text, lacks, tone = *self._plan(self.request()), "muted"
        except IlfError as error:
            text, lacks, tone = str(error), "", "error"
        self.export_button.setEnabled(tone == "muted")
        self.message.show_message(text, tone)
        self.warning.show_message(lacks, "warning")

    def _plan(self, export: Export) -> tuple[str, str]:
        """Return what the export would write, and what the results of a single frame lack."""
        record = [RECORD_FILE] * export.from_files
        report = [] if export.report is None else [export.report.name]
        files = ", ".join(dict.fromkeys([*self.files.names(), *record, *report]))
        if export.from_files or export.scope != Scope.THIS:
            folders = counted(len(self._entries(export.scope)), "folder")
            more = _FROM_FILES if export.from_files else _OF_SEVERAL
            return f"Writes {folders}, one per frame, with {files}. {more}", ""
        if self._completion is None:
            lacks = "No block has been run in its current state: the input depth is exported."
        else:
            lacks = behind(self.workspace.current)
        return f"Writes {files}.", lacks

    def _turn(self) -> None:
        """Offer what belongs to the chosen frames and to where their depth is from."""
        from_files, is_this = bool(self.source.currentData()), self.scope.currentData() == Scope.THIS
        self.widget.setWindowTitle(f"Export {self._run.frame.name}" if is_this and self._run is not None else "Export")
        self.tabs.setTabVisible(1, not from_files)
        self.tabs.setTabVisible(2, from_files)
        single = is_this and not from_files
        self.files.describe(self._run if single else None, self._completion if single else None)
        proposed = self._proposal(is_this, from_files)
        if self.folder_path.text() in ("", self._proposed):
            self.folder_path.setText(proposed)
        self._proposed = proposed
        self.update_message()

    def _proposal(self, is_this: bool, from_files: bool) -> str:
        """Return the folder to propose: where these frames were exported last, or beside their files."""
        name, beside = "batch" if from_files else "export", self._beside(is_this)
        if is_this and not from_files and self._run is not None:
            name = output_folder_name(self._run.frame.name)
        kind = EXPORTS if is_this else EXPORTS_OF_FRAMES
        if not is_this and QSettings().value(_FRAMES_KEY) != str(Path(beside).parent):
            kind = ""  # those were frames of another data set
        return str(save_folder(beside, kind) / name)

    def _beside(self, is_this: bool) -> str:
        """Return the path beside which exports of the current frame, or of many like it, are proposed; "" for none."""
        inputs = None if self._run is None else self._run.frame.inputs
        if self._run is None or inputs is None or is_address(inputs.rgb.path):
            return ""
        path = Path(inputs.rgb.path)
        if path.parent != Path(inputs.depth.path).parent:
            path = path.parent  # beside the folders of colour and depth
        if not is_this and (path.parent.name == self._run.frame.name or (path.parent / META_NAME).is_file()):
            path = path.parent  # beside the folders of the frames, not in one of them
        return str(path)

    def _allow(self) -> None:
        for part in (self._form, self.files, self.report_page, self.batch_page, self.export_button):
            part.setEnabled(not self.busy)

    def _folder(self) -> Path:
        return Path(os.path.abspath(os.path.expanduser(self.folder_path.text().strip())))

    def _browse(self) -> None:
        if path := QFileDialog.getExistingDirectory(self.widget, "Choose target folder", str(self._folder())):
            self.folder_path.setText(path)

    # the export

    @in_steps
    def begin_export(self, export: Export) -> Steps[None]:
        """Start an export, and remember its files; ask first if it would replace files."""
        if replaced := self._replaced(export):
            text = f"{export.folder} has files of an earlier export. Replace those of frames that have changed since?"
            if not (
                yield partial(ask, self.widget, "Replace files?", text, f"{some(replaced)}.", [("&Replace", DESTROY)])
            ):
                return
        if filenames(None, export.options):
            self.files.store()
        self.start(export)

    def _replaced(self, export: Export) -> list[str]:
        """Return the files that there are already, relative to the folder. A batch skips what is complete."""
        if export.from_files:
            return []
        frames = self._frames(export.scope) if filenames(None, export.options) else []
        files = [str(Path(frame.folder, name)) for frame in frames for name in self.files.names()]
        files += [] if export.report is None else [export.report.name]
        return [file for file in files if (export.folder / file).exists()]

    def start(self, export: Export) -> None:
        """Export in the background; none may be in progress."""
        workspace, entries = self.workspace, self._entries(export.scope)
        self._export, self._total, self._done, self._ids = export, 1, [], {}
        parts: list[Iterator[Step]] = []
        if export.from_files:
            frames = batch_frames(workspace.entries)
            only = {entry.id: frames[entry.id] for entry in entries if entry.id in frames}
            self._ids = {frame.folder: id for id, frame in only.items()}
            settings = settings_of(workspace.parameters, replace(export.options, run_record=True))
            parts.append(batch_steps(export, list(frames.values()), list(only.values()), settings))
            self._total = len(only) or 1
        elif filenames(None, export.options):
            parts.append(export_frames(self._frames(export.scope), export.folder, export.options))
            self._total = len(entries)
        if export.report is not None:
            subjects = subjects_of(entries, self.context.recorder.store, workspace.parameters.for_all)
            parts.append(report_file_steps(export.report, subjects, export.test))
        if export.scope == Scope.THIS:
            remember_folder(EXPORTS, export.folder)
        else:
            remember_folder(EXPORTS_OF_FRAMES, export.folder)
            QSettings().setValue(_FRAMES_KEY, str(Path(self._beside(is_this=False)).parent))

        def job() -> Generator[Step, None, str]:
            for steps in parts:
                yield from steps
            return ""

        what = f"an export of {counted(self._total, 'frame')}"
        self.requests.ask(job, self._end, step=self._take, what=what)
        self.results.clear()
        self.retry.setChecked(False)
        self.anew.setChecked(False)
        self.tabs.setCurrentWidget(self.results)
        self.work.begin()
        self._allow()
        self._show_frames()

    def _take(self, step: Step) -> None:
        """List what has come of a frame, or show how far the report is."""
        if isinstance(step, Progress):
            self.work.show_share(step.share)
            self.message.show_message(f"Report: {step.text}")
            return
        self._done.append(step)
        item = QTreeWidgetItem([step.name, str(step.status), " ".join(step.notes)])
        item.setToolTip(2, literal_text("\n".join(step.notes)))
        item.setData(0, Qt.ItemDataRole.UserRole, step)
        if step.status is ExportStatus.FAILED:
            item.setForeground(1, theme.colours(self.widget.palette()).error)
        self.results.addTopLevelItem(item)
        id = self._ids.get(step.folder.name)
        if id is not None and step.status is not ExportStatus.FAILED and self._export is not None:
            self._playing.written[id] = partial(written_depth, step.folder, self._export.options.depth_units)
        self._show_frames()

    def _show_frames(self) -> None:
        count, total = len(self._done), self._total
        self.work.show_share(count / total)
        self.message.show_message(f"{count} of {counted(total, 'frame')}")
        self._status.show_exporting(f"Exporting {count} of {total}")

    def _end(self, text: str = "") -> None:
        """Say what was written, and what was not; also in the log, and in one message if the dialog is closed."""
        export, done = self._export, self._done
        assert export is not None
        report = None if text else export.report
        counts = Counter(frame.status for frame in done)
        parts = [f"{counts[status]} {status}" for status in ExportStatus if counts[status]]
        parts += [] if report is None else [report.name]
        failed = [f"{frame.name}: {frame.notes[0]}" for frame in done if frame.status is ExportStatus.FAILED]
        written = "Exported" if len(failed) < len(done) or report is not None else "Nothing was exported"
        told = [f"{text}{written} to {export.folder}{': ' * bool(parts)}{', '.join(parts)}."]
        told += failed[:_MAX_NAMED] if failed or len(done) != 1 else done[0].notes
        self._close("\n".join(told), "warning" if text or failed else "good")
        self.notes.show_message(" ".join(told))
        if not self.visible:
            self.notes.warn(f"Not exported: {counted(len(failed), 'frame')}", failed)
        if report is not None and self.opens.isChecked():
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(report.absolute())))

    def _end_cancelled(self) -> None:
        if self._export is not None:
            self._end("Cancelled: export again to go on. ")

    def fail(self, error: Exception) -> None:
        self._close(error_text(error), "error")
        if not self.visible:
            self.notes.report("Export", error)

    def _close(self, text: str, tone: str) -> None:
        """Offer the next export, below what is to be said of this one."""
        self._export = None
        self.work.hide()
        self._allow()
        self.refresh(self.parts)  # another frame may be the current one now
        self._status.show_exporting("")
        self.message.show_message(text, tone)
        self.warning.show_message("")
        (self.close_button if tone == "good" else self.export_button).setFocus()

    def _open(self, frame: ExportedFrame) -> None:
        """Open the run of a frame; show why a failed one has none."""
        record = frame.folder / RECORD_FILE
        if frame.status is not ExportStatus.FAILED and record.exists():
            self.context.feature(DocumentsFeature).open_run(record)
        else:
            self.message.show_message(f"{frame.name}: {' '.join(frame.notes) or 'no run record'}", "warning")

    # frames

    def _entries(self, scope: Scope) -> list[Entry]:
        """Return the frames of a choice."""
        entries = list(self.workspace.entries)
        if scope == Scope.THIS:
            return [] if self.workspace.current_entry is None else [self.workspace.current_entry]
        if scope == Scope.SELECTED:
            chosen = {entry.id for entry in self.context.feature(FramesFeature).panel.view.chosen()}
            return [entry for entry in entries if entry.id in chosen]
        if scope == Scope.ALL:
            return entries
        return [entry for entry in entries if (entry.summary.done if scope == Scope.DONE else entry.summary.has_work)]

    def _frames(self, scope: Scope) -> list[FrameToExport]:
        workspace, store = self.workspace, self.context.recorder.store
        if scope == Scope.THIS:
            return [frame_as_shown(workspace.current)]
        return frames_to_export(self._entries(scope), store, workspace.parameters)
