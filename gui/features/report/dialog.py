"""The report dialog: frames, format, hold-out test and progress."""

from __future__ import annotations

from PySide6.QtCore import QSettings, Signal
from PySide6.QtGui import QStandardItemModel
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

from ilf.evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest

from ...widgets.basics import Message
from ...widgets.work_row import WorkRow

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
