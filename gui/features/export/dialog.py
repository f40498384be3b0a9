"""The export dialog: frames, folder, files, progress, and what was written."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSettings, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import (
    QCheckBox,
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
from ilf._runtime.threads import available_cores
from ilf.batch.pictures import write_contact_sheet, write_video
from ilf.data.results import Completion
from ilf.errors import ParameterError
from ilf.evaluation.hold_out import HoldOutTest
from ilf.project.exporting import ExportedFrame, ExportStatus
from ilf.run.options import RECORD_FILE, ExportOptions, as_file_name, output_folder_name
from ilf.run.run import Run

from ...base import theme
from ...widgets.basics import Message, combo, form, give_size, label_of, literal_text, row, row_list, scrolled, stack
from ...widgets.file_choice import EXPORTS, EXPORTS_OF_FRAMES, save_folder
from ...widgets.hold_out_choice import HoldOutChoice
from ...widgets.work_row import WorkRow
from ...work.jobs import spare_cores
from .files import FilesForm
from .jobs import Pictures

THIS, DONE, WORKED_ON, SELECTED, ALL = "this", "done", "worked on", "selected", "all"
"""Choices of frames."""

_SCOPES = {
    THIS: "This frame",
    DONE: "Frames marked as done",
    WORKED_ON: "Frames that have been worked on",
    SELECTED: "Selected rows of the list",
    ALL: "All frames of the list",
}
_SOURCES = {
    False: "As in this window, with its blocks and results",
    True: "Anew from the files, with the current parameters",
}
_FORMATS = {"html": "HTML page, one file for any browser", "pdf": "PDF, for printing or sharing"}
_BATCH_FOLDER = "batch/folder"
_FROM_FILES = (
    "Blocks are extracted, and edits in this window are not used. Starting again resumes: completed frames are "
    "skipped. manifest.csv lists the result of each frame."
)

_OF_SEVERAL = "Blocks without a result are run first. Frames unchanged since an earlier export are skipped."


@dataclass(frozen=True)
class Export:
    """What the user wants to be written.

    Attributes
    ----------
    folder : Path
    options : ExportOptions
    scope : str
        A choice of frames.
    from_files : bool
        Whether frames are completed anew, as a batch.
    jobs : int
        Number of processes of a batch.
    pictures : sequence of callable
        What writes the pictures of a batch.
    retry, anew : bool
        Whether a batch completes frames again that have failed, or whose settings or files have changed.
    report : Path or None
        The file of the report, HTML or PDF; None for no report.
    test : HoldOutTest or None
        Of the frames of the report.
    """

    folder: Path
    options: ExportOptions
    scope: str = THIS
    from_files: bool = False
    jobs: int = 1
    pictures: Pictures = ()
    retry: bool = False
    anew: bool = False
    report: Path | None = None
    test: HoldOutTest | None = None


class ExportDialog(QDialog):
    """Dialog of exports; it stays open with what was written, and may be closed meanwhile.

    Signals
    -------
    requested(object)
        The user wants an `Export`.
    cancelled()
    opened(object)
        The user opened the `ExportedFrame` of a row.
    results_requested(object)
        The user wants the frames written to a folder in the list.
    """

    requested = Signal(object)
    cancelled = Signal()
    opened = Signal(object)
    results_requested = Signal(object)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Export")
        give_size(self, 760, 650)
        self._run: Run | None = None
        self._completion: Completion | None = None
        self._behind = self._proposed = ""
        self._counts: Mapping[str, int] = {}
        self._busy = False
        self.scope = combo(_SCOPES, "Frames to export; of several, each gets a folder of its own")
        self.source = combo(_SOURCES, "Where blocks and completed depth are taken from")
        self.folder_path = QLineEdit()
        browse = QPushButton("Browse…")
        browse.setToolTip("Select the folder for the files")
        browse.clicked.connect(self._browse)
        self.files, self.results = FilesForm(), self._results()
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
        self.work = WorkRow("export", "finished frames stay, and exporting again goes on")
        self.work.cancelled.connect(self.cancelled)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.export_button = buttons.addButton("Export", QDialogButtonBox.ButtonRole.AcceptRole)
        # of this role it is at the left: the other buttons keep their places when it comes
        self.show_button = buttons.addButton("Open as fram&es", QDialogButtonBox.ButtonRole.ResetRole)
        self.show_button.setToolTip(
            "Add the completed frames of the folder to the list, with completed depth as their input; double-click a "
            "row above to open its run, with its blocks"
        )
        self.show_button.clicked.connect(lambda: self.results_requested.emit(self._folder()))
        self.close_button = buttons.button(QDialogButtonBox.StandardButton.Close)
        buttons.accepted.connect(lambda: self.requested.emit(self.request()))
        buttons.rejected.connect(self.reject)
        self._form = QWidget()
        folder = label_of("F&older", self.folder_path), row(self.folder_path, browse)
        form(("Fra&mes", self.scope), ("&Depth", self.source), folder, parent=self._form)
        stack(self, self._form, self.tabs, self.message, self.warning, self.work, buttons, stretched=self.tabs)
        self._remembered: dict[str, QWidget] = {
            "report/format": self.format,
            "report/hidden": self.hidden,
            "report/open": self.opens,
            "batch/sheet": self.sheet,
            "batch/video": self.video,
        }
        for key, field in self._remembered.items():
            if (value := QSettings().value(key)) is not None:
                field.setProperty(_user_property(field), value)
        for choice in (self.scope, self.source):
            choice.currentIndexChanged.connect(self._turn)
        of_report = self.report.toggled, self.hidden.toggled, self.format.currentIndexChanged
        for changed in (self.folder_path.textChanged, self.files.changed, *of_report):
            changed.connect(self.update_message)

    def prepare(self, scope: str, from_files: bool, only_report: bool) -> None:
        """Offer a new export, with the last settings."""
        with QSignalBlocker(self.scope), QSignalBlocker(self.source):
            self.scope.setCurrentIndex(self.scope.findData(scope))
            self.source.setCurrentIndex(self.source.findData(from_files))
        self.folder_path.setText("")
        self._turn()
        self.files.restore(None if self._run is None else self._run.frame.inputs)
        self.report.setChecked(only_report)
        if only_report:
            self.files.choose_none()
        self.tabs.setCurrentIndex(1 if only_report else 0)
        self.export_button.setDefault(True)
        self.export_button.setFocus()

    def describe(self, run: Run | None, completion: Completion | None, behind: str, counts: Mapping[str, int]) -> None:
        """Set the run of the current frame and its completion, what its results lack, and the number of frames of each
        choice."""
        self._run, self._completion, self._behind, self._counts = run, completion, behind, counts
        model = self.scope.model()
        for number, (name, text) in enumerate(_SCOPES.items()):
            name_of_it = run.frame.name if name == THIS and run is not None else counts[name]
            self.scope.setItemText(number, f"{text}: {name_of_it}")
            if isinstance(model, QStandardItemModel):
                model.item(number).setEnabled(counts[name] > 0)
        self._turn()

    def request(self) -> Export:
        """Return what the user wants; ParameterError if a value is wrong."""
        from_files, scope, folder = bool(self.source.currentData()), str(self.scope.currentData()), self._folder()
        name = "" if scope != THIS or self._run is None else f"{as_file_name(self._run.frame.name)}-"
        writes_report = self.report.isChecked() and not from_files
        return Export(
            folder,
            self.files.options(),
            scope,
            from_files,
            self.jobs.value(),
            [write_contact_sheet] * self.sheet.isChecked() + [write_video] * self.video.isChecked(),
            self.retry.isChecked(),
            self.anew.isChecked(),
            folder / f"{name}report.{self.format.currentData()}" if writes_report else None,
            self.hold_out.test() if self.hidden.isChecked() else None,
        )

    def remember(self, export: Export) -> None:
        """Remember the settings of an export."""
        if export.options.filenames():
            self.files.store()
        for key, field in self._remembered.items():
            QSettings().setValue(key, field.property(_user_property(field)))
        if export.from_files:
            QSettings().setValue(_BATCH_FOLDER, str(export.folder))

    def begin(self) -> None:
        """Show that an export has begun."""
        self._busy = True
        self.results.clear()
        self.retry.setChecked(False)
        self.anew.setChecked(False)
        self.tabs.setCurrentWidget(self.results)
        self.work.begin()
        self._allow()

    def add(self, frames: Sequence[ExportedFrame]) -> None:
        """List what has come of frames."""
        for frame in frames:
            item = QTreeWidgetItem([frame.name, str(frame.status), " ".join(frame.notes)])
            item.setToolTip(2, literal_text("\n".join(frame.notes)))
            item.setData(0, Qt.ItemDataRole.UserRole, frame)
            if frame.status is ExportStatus.FAILED:
                item.setForeground(1, theme.colours(self.palette()).error)
            self.results.addTopLevelItem(item)

    def end(self, text: str, tone: str) -> None:
        """Show that the export has ended, with a summary."""
        self._busy = False
        self.work.hide()
        self._allow()
        self.message.show_message(text, tone)
        self.warning.show_message("")
        (self.close_button if tone == "good" else self.export_button).setFocus()

    def update_message(self) -> None:
        """Say what the export would write, or why it cannot."""
        for field in (self.format, self.hidden, self.opens):
            field.setEnabled(self.report.isChecked())
        self.hold_out.setEnabled(self.report.isChecked() and self.hidden.isChecked())
        if self._busy or not self._counts:
            return
        self._allow()
        try:
            export = self.request()
            record = [RECORD_FILE] * export.from_files
            report = [] if export.report is None else [export.report.name]
            names = list(dict.fromkeys([*self.files.names(), *record, *report]))
        except ParameterError as error:
            problem = str(error)
        else:
            problem = self._problem(export.folder, names)
        self.export_button.setEnabled(not problem)
        text, lacks = (problem, "") if problem else self._plan(export, names)
        self.message.show_message(text, "error" if problem else "muted")
        self.warning.show_message(lacks, "warning")

    def _problem(self, folder: Path, names: Sequence[str]) -> str:
        """Return why nothing can be exported, and what to do; "" if it can."""
        if not self.folder_path.text().strip():
            return "Choose a target folder."
        if folder.exists() and not folder.is_dir():
            return f"{folder} is a file, not a folder. Choose another folder."
        if not names:
            return "Choose at least one file to write."
        if not self._counts[self.scope.currentData()]:
            return "There is no such frame. Choose other frames."
        return ""

    def _plan(self, export: Export, names: Sequence[str]) -> tuple[str, str]:
        """Return what the export would write, and what the results of a single frame lack."""
        files = ", ".join(names)
        if export.from_files:
            return f"Writes a folder per frame with {files}. {_FROM_FILES}", ""
        if export.scope != THIS:
            folders = counted(self._counts[export.scope], "folder")
            text = f"Writes {folders}, one per frame, with {files}, as far as the frame has them. {_OF_SEVERAL}"
            return text, ""
        text = f"Writes {files}." if export.folder.is_dir() else f"Creates the folder, writes {files}."
        if self._completion is None:
            return text, "No block has been run in its current state: the input depth is exported."
        return text, self._behind

    def _turn(self) -> None:
        """Offer what belongs to the chosen frames and to where their depth is from."""
        from_files, is_this = bool(self.source.currentData()), self.scope.currentData() == THIS
        self.setWindowTitle(f"Export {self._run.frame.name}" if is_this and self._run is not None else "Export")
        self.tabs.setTabVisible(1, not from_files)
        self.tabs.setTabVisible(2, from_files)
        single = is_this and not from_files
        self.files.describe(self._run if single else None, self._completion if single else None)
        name = output_folder_name(self._run.frame.name) if single and self._run is not None else "export"
        last = str(QSettings().value(_BATCH_FOLDER, "")) if from_files else ""
        inputs = None if self._run is None else self._run.frame.inputs
        path = "" if inputs is None or is_address(inputs.rgb.path) else inputs.rgb.path
        if path and inputs is not None and Path(path).parent != Path(inputs.depth.path).parent:
            path = str(Path(path).parent)  # beside the folders of colour and depth
        if not is_this and self._run is not None and Path(path).parent.name == self._run.frame.name:
            path = str(Path(path).parent)  # beside the folders of the frames, not in one of them
        folder = save_folder(path, EXPORTS if is_this else EXPORTS_OF_FRAMES)
        proposed = last or str(folder / ("batch" if from_files else name))
        if self.folder_path.text() in ("", self._proposed):
            self.folder_path.setText(proposed)
        self._proposed = proposed
        self.update_message()

    def _allow(self) -> None:
        for part in (self._form, self.files, self.report_page, self.batch_page):
            part.setEnabled(not self._busy)
        self.export_button.setEnabled(not self._busy)
        self.show_button.setVisible(not self._busy and any(self._folder().glob(f"*/{RECORD_FILE}")))

    def _folder(self) -> Path:
        return Path(os.path.abspath(os.path.expanduser(self.folder_path.text().strip())))

    def _browse(self) -> None:
        folder = self._folder()
        start = next((place for place in (folder, *folder.parents) if place.is_dir()), folder)
        if path := QFileDialog.getExistingDirectory(self, "Choose target folder", str(start)):
            self.folder_path.setText(path)

    def _results(self) -> Any:
        hint = "What has come of each frame; double-click one to open it"
        rows = row_list("Results of the frames", hint, ("Frame", "Status", "Notes"), stretched=2)
        rows.itemActivated.connect(lambda item: self.opened.emit(item.data(0, Qt.ItemDataRole.UserRole)))
        return rows

    def _report_page(self) -> QWidget:
        self.report = QCheckBox("&Write a report on the frames")
        self.report.setToolTip("One self-contained page; several frames get an index with a row for each")
        about = Message(lines=3)
        about.show_message(
            "Pictures with scales, blocks with their figures, parameters that differ from the preset, curves, errors, "
            "run history, versions and the hashes of all files. Of frames that are not open, only those that have been "
            "worked on."
        )
        self.format = combo(_FORMATS, "File type of the report")
        self.hidden = QCheckBox("Measure the error on held-out known depth")
        self.hidden.setToolTip(
            "Run a hold-out test for every frame with results; takes about as long as a run per seed"
        )
        self.hold_out = HoldOutChoice()
        self.opens = QCheckBox("Open when done")
        self.opens.setChecked(True)
        self.opens.setToolTip("Open the report in the browser or the PDF viewer")
        page, fields = QWidget(), QWidget()
        test = ("Hold-out test", self.hidden), ("&Hide", self.hold_out)
        form(("Form&at", self.format), *test, ("", self.opens), parent=fields)
        stack(page, self.report, about, fields, QWidget())
        return page

    def _batch_page(self) -> QWidget:
        self.jobs = QSpinBox(minimum=1, maximum=available_cores(), value=spare_cores())
        self.jobs.setToolTip("Number of frames completed at the same time; they share the cores")
        self.sheet, self.video = QCheckBox("Contact sheet"), QCheckBox("Video")
        self.sheet.setToolTip("One picture of all frames, with their names, in one depth colour range")
        self.video.setToolTip("Colour, measured and completed depth of all frames in sequence")
        self.retry, self.anew = QCheckBox("Failed frames"), QCheckBox("Frames with changed settings or files")
        self.retry.setToolTip("Retry frames that failed before")
        self.anew.setToolTip("Complete frames again whose settings or files have changed since")
        page, fields = QWidget(), QWidget()
        also, redo = row(self.sheet, self.video), row(self.retry, self.anew)
        form(("&Processes", self.jobs), ("Also write", also), ("Redo", redo), parent=fields)
        stack(page, fields, QWidget())
        return page


def _user_property(field: QWidget) -> str:
    """Return the name of the property that a user sets: whether a box is checked, a number, or a text."""
    return str(field.metaObject().userProperty().name())
