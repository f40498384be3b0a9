"""The dialog that asks what a report is about, and shows how far it is."""

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

from gui.widgets.messages import Message
from gui.widgets.work_row import WorkRow
from ilf.judgement import HIDDEN_PATTERNS, HiddenTest

THIS_FRAME, ALL_FRAMES = "frame", "all"
_FORMATS = {"html": "HTML page, one file for any browser", "pdf": "PDF, to print or to send"}
_PATTERNS = {"areas": "areas, like the holes that cameras leave", "random": "random pixels"}
_KEY = "report/"
_SEEDS, _MOST_SEEDS = 3, 20


class ReportDialog(QDialog):
    """What, in which format, and whether on hidden depth, too. It stays open until the report is written.

    Signals
    -------
    wished()
        The user wants it written.
    cancelled()
        The user wants no more of it.
    """

    wished = Signal()
    cancelled = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Report")
        about = Message(lines=3)
        about.say(
            "Pictures with their scales, blocks with their figures, parameters that differ from the preset, curves, "
            "errors, kept runs, versions and the hashes of all files, in one file that needs no other."
        )
        self.scope = QComboBox()
        self.scope.setToolTip("Which frames the report is about; several have an index with a row for each")
        self._scopes = QStandardItemModel(self)
        self.scope.setModel(self._scopes)
        self.scope.addItem("", THIS_FRAME)
        self.scope.addItem("", ALL_FRAMES)
        self.format = QComboBox()
        self.format.setToolTip("What kind of file is written")
        for name, text in _FORMATS.items():
            self.format.addItem(text, name)
        self.hidden = QCheckBox("Hide known depth and say how well it comes back")
        self.hidden.setToolTip(
            "Test every frame that has results on hidden depth; takes about as long as running it, once for each seed"
        )
        self.pattern = QComboBox()
        self.pattern.setToolTip("Which known depth is hidden")
        for name in sorted(HIDDEN_PATTERNS):
            self.pattern.addItem(_PATTERNS.get(name, name), name)
        self.seeds = QSpinBox(minimum=1, maximum=_MOST_SEEDS, value=_SEEDS)
        self.seeds.setToolTip("How often other depth is hidden; the errors are pooled, and shown for each")
        self.opens = QCheckBox("Open it when it is done")
        self.opens.setToolTip("Show the report in the browser, or in the program that shows PDF files")
        self.state = Message()
        self.work = WorkRow("report", "nothing is written")

        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Close)
        self.write_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.write_button.setText("&Write…")
        self.write_button.setToolTip("Choose the file and write the report, in the background")
        buttons.accepted.connect(self.wished)
        buttons.rejected.connect(self.reject)
        self.work.cancelled.connect(self.cancelled)
        self.hidden.toggled.connect(lambda _: self._allow())

        test = QHBoxLayout()
        test.addWidget(self.pattern, 1)
        test.addWidget(self.seeds)
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&About", self.scope)
        form.addRow("&Format", self.format)
        form.addRow("Hidden depth", self.hidden)
        form.addRow("Pattern and seeds", test)
        form.addRow("", self.opens)
        self.pattern.setAccessibleName("Pattern in which depth is hidden")
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
        """What there is to report on: the present frame, and how many have been worked on."""
        self.scope.setItemText(0, f"This frame: {name}")
        self.scope.setItemText(1, f"All frames that have been worked on: {worked_on}")
        item = self._scopes.item(1)
        item.setEnabled(worked_on > 0)
        if not worked_on:
            self.scope.setCurrentIndex(0)
        self.state.say("")

    @property
    def test(self) -> HiddenTest | None:
        """How depth is hidden; None for no test."""
        if not self.hidden.isChecked():
            return None
        return HiddenTest(str(self.pattern.currentData()), tuple(range(self.seeds.value())))

    def begin(self) -> None:
        """The report is being written."""
        self._keep()
        self._form.setEnabled(False)
        self.write_button.setEnabled(False)
        self.state.say("")
        self.work.begin()

    def show_step(self, share: float, text: str) -> None:
        """So much is done, 0-1, and this is under way."""
        self.work.show_share(share)
        self.state.say(text)

    def end(self, text: str = "", tone: str = "muted") -> None:
        """It is written, or will not be."""
        self.work.end()
        self._form.setEnabled(True)
        self.write_button.setEnabled(True)
        self.state.say(text, tone)

    def reject(self) -> None:
        self.cancelled.emit()  # however it is closed
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
