"""The dialog that asks which frames are completed where, and shows how far that is and what has come."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSettings, QSize, Qt, Signal
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from gui.batch.outcome_table import OutcomeTable
from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel
from gui.widgets.work_row import WorkRow
from gui.work.cores import spare_cores
from ilf.run.options import RECORD_FILE
from ilf.threads import available_cores

ALL_FRAMES, CHOSEN_FRAMES = "all", "chosen"
_KEY = "batch/"
_SIZE = QSize(760, 620)


class BatchDialog(QDialog):
    """Shows and reports wishes; what is completed is the part's. It may be closed while frames are being completed.

    Signals
    -------
    begun()
        The user wants what is chosen to be completed.
    cancelled()
    opened(object)
        The user wants to see what came of a frame.
    results_wished()
        The user wants the completed frames in the list.
    """

    begun = Signal()
    cancelled = Signal()
    opened = Signal(object)
    results_wished = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Batch")
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.resize(_SIZE)
        about = Message(lines=3)
        about.say(
            "Completes frames from their files, each into a folder of its own, with the present values of Filter and "
            "Extraction and the kinds of files that the last export had. Blocks edited here have no part in it. "
            "Begun again, it does what is not done yet; manifest.csv says what came of each frame."
        )
        self.scope = QComboBox()
        self.scope.setToolTip("Which frames of the list are completed")
        self._scopes = QStandardItemModel(self)
        self.scope.setModel(self._scopes)
        self.scope.addItem("", ALL_FRAMES)
        self.scope.addItem("", CHOSEN_FRAMES)
        self.folder = QLineEdit()
        self.folder.setToolTip("Each frame has a folder in it; what others have begun there goes on")
        browse = QPushButton("Browse…", autoDefault=False)
        browse.setToolTip("Choose the folder of the results")
        browse.clicked.connect(self._browse)
        self.jobs = QSpinBox(minimum=1, maximum=available_cores(), value=spare_cores())
        self.jobs.setToolTip("Frames that are completed at the same time; they share the cores")
        self.sheet = QCheckBox("Contact sheet")
        self.sheet.setToolTip("One picture of all frames, with their names; the same colour is the same depth in all")
        self.video = QCheckBox("Video")
        self.video.setToolTip("Colour, measured and completed depth of all frames, one after the other")
        self.retry = QCheckBox("Failed frames")
        self.retry.setToolTip("Try those again that failed before")
        self.anew = QCheckBox("Frames of other settings or files")
        self.anew.setToolTip(
            "Complete those anew that were completed with other values, or whose files have changed since"
        )
        self.state = Message(lines=2)
        self.work = WorkRow("batch", "frames that are done stay, the others are done when it is begun again")
        self.table = OutcomeTable()
        self.table.opened.connect(self.opened)

        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Close)
        self.start_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.start_button.setText("&Start")
        self.start_button.setToolTip("Complete the frames, in the background")
        self.show_button = buttons.addButton("Open &results", QDialogButtonBox.ButtonRole.ActionRole)
        self.show_button.setAutoDefault(False)
        self.show_button.setToolTip("Put the completed frames into the list")
        self.show_button.clicked.connect(self.results_wished)
        buttons.accepted.connect(self.begun)
        buttons.rejected.connect(self.reject)
        self.work.cancelled.connect(self.cancelled)
        self.folder.textChanged.connect(lambda _: self._allow())

        self._form = QWidget()
        form = QFormLayout(self._form)
        form.setContentsMargins(0, 0, 0, 0)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Frames", self.scope)
        label = PlainLabel("F&older")
        label.setBuddy(self.folder)
        form.addRow(label, _row(self.folder, browse))
        form.addRow("&Processes", self.jobs)
        form.addRow("Also write", _row(self.sheet, self.video))
        form.addRow("Again", _row(self.retry, self.anew))
        self.folder.setAccessibleName("Folder of the results")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        for widget in (about, self._form, self.state, self.work):
            layout.addWidget(widget)
        layout.addWidget(self.table, 1)
        layout.addWidget(buttons)
        self._busy = False
        self._restore()
        self._allow()

    def set_frames(self, count: int, chosen: int) -> None:
        """How many frames the list has, and how many of its rows are chosen."""
        self.scope.setItemText(0, f"All frames of the list: {count}")
        self.scope.setItemText(1, f"The chosen rows of the list: {chosen}")
        self._scopes.item(1).setEnabled(chosen > 0)
        if not chosen:
            self.scope.setCurrentIndex(0)

    def begin(self) -> None:
        """Frames are being completed."""
        self._keep()
        self._busy = True
        self.table.outcomes.set_rows([])
        self.retry.setChecked(False)
        self.anew.setChecked(False)
        self.state.say("Looking at what is there…")
        self.work.begin()
        self._allow()

    def end(self, text: str, tone: str = "muted") -> None:
        """They are done, or will not be."""
        self._busy = False
        self.work.end()
        self.state.say(text, tone)
        self._allow()

    def _allow(self) -> None:
        folder = self.folder.text().strip()
        self._form.setEnabled(not self._busy)
        self.start_button.setEnabled(not self._busy and bool(folder))
        self.show_button.setEnabled(not self._busy and bool(folder) and _has_results(Path(folder)))

    def _browse(self) -> None:
        path = QFileDialog.getExistingDirectory(self, "Folder of the results", self.folder.text())
        if path:
            self.folder.setText(path)

    def _restore(self) -> None:
        settings = QSettings()
        self.folder.setText(str(settings.value(_KEY + "folder", "")))
        self.sheet.setChecked(bool(settings.value(_KEY + "sheet", False, bool)))
        self.video.setChecked(bool(settings.value(_KEY + "video", False, bool)))

    def _keep(self) -> None:
        settings = QSettings()
        settings.setValue(_KEY + "folder", self.folder.text())
        settings.setValue(_KEY + "sheet", self.sheet.isChecked())
        settings.setValue(_KEY + "video", self.video.isChecked())


def _has_results(folder: Path) -> bool:
    """Whether a frame has been completed into it, also if the batch has not come to its end."""
    return any(folder.glob(f"*/{RECORD_FILE}"))


def _row(*widgets: QWidget) -> QHBoxLayout:
    row = QHBoxLayout()
    for widget in widgets:
        row.addWidget(widget, 1 if isinstance(widget, QLineEdit) else 0)
    if not any(isinstance(widget, QLineEdit) for widget in widgets):
        row.addStretch(1)
    return row
