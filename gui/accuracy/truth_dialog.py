"""The dialog that loads a truth: which file, in which units, and what that makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QSettings, QTimer
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gui.dialogs.preview import Preview
from gui.widgets.messages import Message, last_folder
from gui.widgets.problems import error_text
from gui.work.latest_question import LatestQuestion
from ilf.drawing.levels import sample
from ilf.errors import InputError
from ilf.frame import RGBDFrame
from ilf.io import with_truth_file
from ilf.io.frames import DEPTH_FILE_SUFFIXES

_FOLDER_KEY = "truth/folder"
_DELAY_MS = 200
_AUTOMATIC = "Automatic (those of the depth, if both are whole numbers)"
_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "1 (metres)", "256 (KITTI)")
_NOTHING_CHOSEN = "Choose depth of the same pixels that is known to be right: a 16-bit or float image, or NPY."


class TruthSource(NamedTuple):
    """A file with the truth of a frame, and its units per metre if they are stated."""

    frame: RGBDFrame
    path: str
    units: float | None = None


def frame_with(source: TruthSource) -> RGBDFrame:
    """The frame with the truth of the file; called off the GUI's thread."""
    return with_truth_file(source.frame, source.path, source.units)


class TruthDialog(QDialog):
    """Choose a truth, and see what it is before it is taken. Load is enabled once it has been read.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestQuestion
        Which reads a `TruthSource`.
    """

    def __init__(
        self, frame: RGBDFrame, questions: LatestQuestion[TruthSource, RGBDFrame], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Load Truth for {frame.name}")
        self._frame = frame
        self._questions = questions
        self._wanted: TruthSource | None = None
        self._found: RGBDFrame | None = None
        self._delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._delay.timeout.connect(self.read)
        questions.answered.connect(self._take)
        questions.failed.connect(self._fail)
        self.path = QLineEdit(placeholderText="True depth: PNG, TIFF, PGM or NPY")
        self.path.setToolTip("The file with the true depth")
        self.units = QComboBox(editable=True)
        self.units.addItems([_AUTOMATIC, *_UNITS])
        self.units.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.units.setToolTip(
            "How many file units make one metre. Automatic: as the frame's depth, if both are whole numbers; otherwise "
            "1000 for whole numbers and 1 for floating-point depth."
        )
        self.preview = Preview("Truth")
        self.message = Message(lines=5)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Open | QDialogButtonBox.StandardButton.Cancel)
        self.load_button = buttons.button(QDialogButtonBox.StandardButton.Open)
        self.load_button.setText("Load")
        self.load_button.setToolTip("Judge the frame's results by this truth")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        shown = QHBoxLayout()
        shown.setSpacing(12)
        shown.addWidget(self.preview)
        shown.addWidget(self.message, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(12)
        layout.addLayout(self._form())
        layout.addLayout(shown)
        layout.addStretch(1)
        layout.addWidget(buttons)
        self.setMinimumWidth(600)
        self.path.textChanged.connect(self._schedule)
        self.units.editTextChanged.connect(self._schedule)
        self.read()

    def frame(self) -> RGBDFrame:
        """The frame with its truth; only to be asked for once it was read."""
        if self._found is None:
            raise RuntimeError("no truth has been read")
        return self._found

    def done(self, result: int) -> None:
        self._delay.stop()
        self._questions.forget()
        super().done(result)

    def read(self) -> None:
        """Read what is chosen now, and say what it is."""
        self._delay.stop()
        self._forget()
        path = self.path.text().strip()
        if not path:
            self.message.say(_NOTHING_CHOSEN)
            return
        try:
            units = _units(self.units.currentText())
        except InputError as error:
            self.message.say(str(error), "error")
            return
        self.message.say("Reading…")
        self._wanted = TruthSource(self._frame, str(Path(path).expanduser().absolute()), units)
        self._questions.ask(self._wanted)

    def _form(self) -> QGridLayout:
        browse = QPushButton("File…", autoDefault=False)
        browse.setToolTip("Choose the file with the true depth")
        browse.clicked.connect(lambda _=False: self._browse())
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(8)
        grid.setColumnStretch(1, 1)
        for row, (text, field) in enumerate((("&Truth", self.path), ("&Units per metre", self.units))):
            label = QLabel(text)
            label.setBuddy(field)
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1, 1, 1 if field is self.path else 2)
        grid.addWidget(browse, 0, 2)
        return grid

    def _browse(self) -> None:
        patterns = " ".join(f"*{suffix}" for suffix in DEPTH_FILE_SUFFIXES)
        path, _ = QFileDialog.getOpenFileName(
            self, "Choose truth", last_folder(_FOLDER_KEY), f"Depth ({patterns});;All files (*)"
        )
        if path:
            QSettings().setValue(_FOLDER_KEY, str(Path(path).parent))
            self.path.setText(path)
            self.read()

    def _schedule(self) -> None:
        self._forget()
        self._delay.start()

    def _forget(self) -> None:
        self._wanted = self._found = None
        self._questions.forget()
        self.load_button.setEnabled(False)
        self.preview.show_rgb(None)

    def _take(self, source: TruthSource, frame: RGBDFrame) -> None:
        if source is not self._wanted or frame.truth is None:
            return
        self._found = frame
        self.preview.show_depth(frame.truth)
        self.message.say(described(frame), "good")
        self.load_button.setEnabled(True)

    def _fail(self, source: TruthSource, error: Exception) -> None:
        if source is self._wanted:
            self.message.say(error_text(error).replace(f"{Path(source.path).parent}/", ""), "error")


def described(frame: RGBDFrame) -> str:
    """How much of a frame its truth says, in words; of a sample of its pixels."""
    if frame.truth is None:
        return "There is no truth."
    truth, depth = sample(frame.truth), sample(frame.depth)
    known, missing = np.isfinite(truth), np.isnan(depth)
    share = known[missing].mean() if missing.any() else known.mean()
    text = f"It is known at {share:.0%} of the pixels{' without depth' if missing.any() else ''}"
    both = known & ~missing
    if not both.any():
        return f"{text}."
    off = float(np.median(np.abs(truth[both] - depth[both])))
    return f"{text}, and {1000 * off:.1f} mm from the known depth (median)."


def _units(text: str) -> float | None:
    """Of the field; None for automatic."""
    if text.strip() in ("", _AUTOMATIC):
        return None
    try:
        units = float(text.split("(")[0])
    except ValueError:
        units = 0.0
    if not 0 < units < float("inf"):
        raise InputError(f"Units per metre must be a number above 0, such as 1000, not {text!r:.30}.")
    return units
