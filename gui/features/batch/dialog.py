"""The batch dialog: frames, folder and options, progress, and results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import QModelIndex, QSettings, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QPaintEvent, QStandardItemModel
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QHeaderView,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QTableView,
    QWidget,
)

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf._runtime.threads import available_cores
from ilf.batch.frame_record import FrameOutcome, FrameStatus
from ilf.batch.pictures import write_contact_sheet, write_video
from ilf.completion.confidence.expected_error import MEDIAN_MEANING, MEDIAN_NAME
from ilf.run.options import RECORD_FILE

from ...base import theme
from ...widgets.basics import Message, label_of, literal_text, paint_hint, row, stack
from ...widgets.tables import Index, RowModel
from ...widgets.work_row import WorkRow
from ...work.jobs import spare_cores

# Results of the frames of a batch, a row each.

_HEADERS = (
    ("Frame", "Its name in the batch"),
    ("Status", "Whether the frame was completed"),
    ("Missing", "Share of pixels without depth, before and after"),
    (f"{MEDIAN_NAME} [mm]", MEDIAN_MEANING),
    ("Seconds", "Run time"),
    ("Message", "Reason for a failure, or notes on the result"),
)
_FRAME, _STATUS, _MISSING, _ERROR, _SECONDS, _MESSAGE = range(len(_HEADERS))
_WIDTHS = (150, 84, 110, 196, 70)


class OutcomeModel(RowModel[FrameOutcome]):
    """Model of outcomes, in order of arrival."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(len(_HEADERS), parent)
        self._parent = parent

    def key(self, row: FrameOutcome) -> str:
        return row.frame

    def look(self, row: FrameOutcome, column: int) -> str:
        looks = {
            _FRAME: row.frame,
            _STATUS: row.status.value,
            _MISSING: _missing(row),
            _ERROR: UNKNOWN if row.expected_error_median is None else millimetres(row.expected_error_median),
            _SECONDS: UNKNOWN if row.seconds is None else f"{row.seconds:.1f}",
            _MESSAGE: row.message,
        }
        return looks[column]

    def add(self, outcomes: list[FrameOutcome]) -> None:
        """Append outcomes."""
        first = len(self.rows)
        if outcomes:
            self.beginInsertRows(QModelIndex(), first, first + len(outcomes) - 1)
            self.rows += outcomes
            self.endInsertRows()

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        looks = {
            Qt.ItemDataRole.DisplayRole: _HEADERS[section][0],
            Qt.ItemDataRole.ToolTipRole: _HEADERS[section][1],
            Qt.ItemDataRole.TextAlignmentRole: _alignment(section),
        }
        return looks.get(Qt.ItemDataRole(role))

    def data(self, index: Index, role: int = 0) -> Any:
        row, column = self.rows[index.row()], index.column()
        if role == Qt.ItemDataRole.DisplayRole:
            return self.look(row, column)
        if role == Qt.ItemDataRole.ToolTipRole:
            return literal_text(row.message or row.frame)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.ForegroundRole and row.status is FrameStatus.FAILED and column == _STATUS:
            return QBrush(theme.colours(self._parent.palette()).error)
        return None


class OutcomeTable(QTableView):
    """Table of the outcomes.

    Signals
    -------
    opened(object)
        The outcome that was double-clicked, or that Enter was pressed on.
    """

    opened = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.outcomes = OutcomeModel(self)
        self.setModel(self.outcomes)
        self.setAccessibleName("Results of the frames")
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        self.horizontalHeader().setStretchLastSection(True)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        for column, width in enumerate(_WIDTHS):
            self.setColumnWidth(column, width)
        self.activated.connect(lambda index: self.opened.emit(self.outcomes.rows[index.row()]))

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self.outcomes.rows:
            paint_hint(self, "Results will be listed here; double-click a result to open it.")


def _alignment(column: int) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignRight if column in (_MISSING, _ERROR, _SECONDS) else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


def _missing(row: FrameOutcome) -> str:
    if row.missing_before is None or row.missing_after is None or not row.pixels:
        return UNKNOWN
    return f"{row.missing_before / row.pixels:.1%} → {row.missing_after / row.pixels:.1%}"


ALL_FRAMES, SELECTED_FRAMES = "all", "chosen"
_KEY = "batch/"
_SIZE = QSize(760, 620)


class BatchDialog(QDialog):
    """Dialog of a batch; emits the user's requests. It may be closed while frames are being completed.

    Signals
    -------
    begun()
        The user started the batch.
    cancelled()
    opened(object)
        The user opened the outcome of a frame.
    results_requested()
        The user requested the completed frames in the list.
    """

    begun = Signal()
    cancelled = Signal()
    opened = Signal(object)
    results_requested = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Batch")
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.resize(_SIZE)
        about = Message(lines=3)
        about.show_message(
            "Completes frames from their files, each into its own folder, with the current values of Filter and "
            "Extraction and the file types of the last export. Blocks edited in this window are not used. Starting "
            "again resumes the batch; manifest.csv lists the result of each frame."
        )
        self.scope = QComboBox()
        self.scope.setToolTip("Frames of the list to complete")
        self._scopes = QStandardItemModel(self)
        self.scope.setModel(self._scopes)
        self.scope.addItem("", ALL_FRAMES)
        self.scope.addItem("", SELECTED_FRAMES)
        self.folder = QLineEdit()
        self.folder.setToolTip("Each frame gets a subfolder; a batch already in the folder is resumed")
        browse = QPushButton("Browse…", autoDefault=False)
        browse.setToolTip("Select the folder for the results")
        browse.clicked.connect(self._browse)
        self.jobs = QSpinBox(minimum=1, maximum=available_cores(), value=spare_cores())
        self.jobs.setToolTip("Number of frames completed at the same time; they share the cores")
        self.sheet = QCheckBox("Contact sheet")
        self.sheet.setToolTip("One picture of all frames, with their names, in one depth colour range")
        self.video = QCheckBox("Video")
        self.video.setToolTip("Colour, measured and completed depth of all frames in sequence")
        self.retry = QCheckBox("Failed frames")
        self.retry.setToolTip("Retry frames that failed before")
        self.anew = QCheckBox("Frames with changed settings or files")
        self.anew.setToolTip("Complete frames again whose settings or files have changed since")
        self.state = Message(lines=2)
        self.work = WorkRow("batch", "completed frames stay, and starting again resumes the batch")
        self.table = OutcomeTable()
        self.table.opened.connect(self.opened)

        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Close)
        self.start_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.start_button.setText("&Start")
        self.start_button.setToolTip("Complete the frames, in the background")
        self.show_button = buttons.addButton("Open &results", QDialogButtonBox.ButtonRole.ActionRole)
        self.show_button.setAutoDefault(False)
        self.show_button.setToolTip("Add the completed frames to the list")
        self.show_button.clicked.connect(self.results_requested)
        buttons.accepted.connect(self.begun)
        buttons.rejected.connect(self.reject)
        self.work.cancelled.connect(self.cancelled)
        self.folder.textChanged.connect(lambda _: self._allow())

        self._form = QWidget()
        form = QFormLayout(self._form)
        form.setContentsMargins(0, 0, 0, 0)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Frames", self.scope)
        form.addRow(label_of("F&older", self.folder), row(self.folder, browse))
        form.addRow("&Processes", self.jobs)
        form.addRow("Also write", row(self.sheet, self.video))
        form.addRow("Redo", row(self.retry, self.anew))
        self.folder.setAccessibleName("Folder of the results")
        stack(self, about, self._form, self.state, self.work, self.table, buttons, stretched=self.table)
        self._busy = False
        self._restore()
        self._allow()

    def set_frames(self, count: int, chosen: int) -> None:
        """Set the number of frames in the list and of selected rows."""
        self.scope.setItemText(0, f"All frames of the list: {count}")
        self.scope.setItemText(1, f"Selected rows of the list: {chosen}")
        self._scopes.item(1).setEnabled(chosen > 0)
        if not chosen:
            self.scope.setCurrentIndex(0)

    def chosen_folder(self) -> Path:
        """Return the folder for the results."""
        return Path(self.folder.text().strip()).expanduser().absolute()

    def pictures(self) -> Sequence[Callable[[Path, Sequence[FrameOutcome]], Path]]:
        """Return what writes the pictures that the user wants."""
        return [write_contact_sheet] * self.sheet.isChecked() + [write_video] * self.video.isChecked()

    def begin(self) -> None:
        """Show that the batch has started."""
        self._keep()
        self._busy = True
        self.table.outcomes.set_rows([])
        self.retry.setChecked(False)
        self.anew.setChecked(False)
        self.state.show_message("Checking existing results…")
        self.work.begin()
        self._allow()

    def end(self, text: str, tone: str = "muted") -> None:
        """Show that the batch has ended, with a message."""
        self._busy = False
        self.work.end()
        self.state.show_message(text, tone)
        self._allow()

    def _allow(self) -> None:
        folder = self.folder.text().strip()
        self._form.setEnabled(not self._busy)
        self.start_button.setEnabled(not self._busy and bool(folder))
        self.show_button.setEnabled(not self._busy and bool(folder) and any(Path(folder).glob(f"*/{RECORD_FILE}")))

    def _browse(self) -> None:
        path = QFileDialog.getExistingDirectory(self, "Folder for the results", self.folder.text())
        if path:
            self.folder.setText(path)

    def _restore(self) -> None:
        settings = QSettings()
        self.folder.setText(str(settings.value(_KEY + "folder", "")))
        for name, box in (("sheet", self.sheet), ("video", self.video)):
            box.setChecked(bool(settings.value(_KEY + name, False, bool)))

    def _keep(self) -> None:
        settings = QSettings()
        settings.setValue(_KEY + "folder", self.folder.text())
        for name, box in (("sheet", self.sheet), ("video", self.video)):
            settings.setValue(_KEY + name, box.isChecked())
