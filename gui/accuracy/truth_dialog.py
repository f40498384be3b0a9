"""The dialog that loads a truth: which file, in which units, and what that makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtWidgets import QComboBox, QFileDialog, QGridLayout, QWidget

from gui.dialogs.reading_dialog import ReadingDialog
from gui.widgets.messages import last_folder
from gui.widgets.plain_text import PlainLabel
from gui.work.latest_question import LatestQuestion
from ilf.drawing.levels import sample
from ilf.errors import InputError
from ilf.frame import RGBDFrame
from ilf.io import with_truth_file
from ilf.io.frames import DEPTH_FILE_SUFFIXES

_FOLDER_KEY = "truth/folder"
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


class TruthDialog(ReadingDialog[TruthSource, RGBDFrame]):
    """Choose a truth, and see what it is before it is taken.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestQuestion
        Which reads a `TruthSource`.
    """

    def __init__(
        self, frame: RGBDFrame, questions: LatestQuestion[TruthSource, RGBDFrame], parent: QWidget | None = None
    ) -> None:
        placeholder = "True depth: PNG, TIFF, PGM or NPY"
        title = f"Load Truth for {frame.name}"
        super().__init__(title, placeholder, _NOTHING_CHOSEN, "Truth", _FOLDER_KEY, questions, parent)
        self._frame = frame
        self.path.setToolTip("The file with the true depth")
        self.load_button.setToolTip("Judge the frame's results by this truth")
        self.units = QComboBox(editable=True)
        self.units.addItems([_AUTOMATIC, *_UNITS])
        self.units.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.units.setToolTip(
            "How many file units make one metre. Automatic: as the frame's depth, if both are whole numbers; otherwise "
            "1000 for whole numbers and 1 for floating-point depth."
        )
        self.units.editTextChanged.connect(self.schedule)
        self.setMinimumWidth(600)
        self.ask(self._form())

    def source(self, path: str) -> TruthSource:
        units = _units(self.units.currentText())
        return TruthSource(self._frame, str(Path(path).expanduser().absolute()), units)

    def show_found(self, found: RGBDFrame) -> None:
        if found.truth is not None:
            self.preview.show_depth(found.truth)
        self.message.say(described(found), "good")

    def _form(self) -> QGridLayout:
        self.file_button.setToolTip("Choose the file with the true depth")
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(8)
        grid.setColumnStretch(1, 1)
        for row, (text, field) in enumerate((("&Truth", self.path), ("&Units per metre", self.units))):
            label = PlainLabel(text)
            label.setBuddy(field)
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1, 1, 1 if field is self.path else 2)
        grid.addWidget(self.file_button, 0, 2)
        return grid

    def browse(self) -> None:
        patterns = " ".join(f"*{suffix}" for suffix in DEPTH_FILE_SUFFIXES)
        path, _ = QFileDialog.getOpenFileName(
            self, "Choose truth", last_folder(_FOLDER_KEY), f"Depth ({patterns});;All files (*)"
        )
        self.choose(path)


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
