"""The dialog that loads ground truth: file, units and preview."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QWidget

from ilf.data.frame import RGBDFrame
from ilf.drawing.colours import sample
from ilf.errors import InputError
from ilf.io.frame_additions import with_ground_truth_file
from ilf.sources.named_places import note_opened
from ilf.sources.naming import DEPTH_FILE_SUFFIXES

from ...widgets.basics import form, label_of, row, typed_list
from ...widgets.file_choice import choose_file
from ...work.latest_request import LatestRequest
from ..documents.file_dialogs import PreviewDialog
from ..documents.frame_files import Look, files_of

_FOLDER_KEY = "truth/folder"
_AUTOMATIC = "Automatic (those of the depth, if both are whole numbers)"
_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "1 (metres)", "256 (KITTI)")
_NOTHING_SELECTED = "Select the true depth of the same pixels: a 16-bit or float image, or NPY."


class GroundTruthDialog(PreviewDialog):
    """Dialog to select a ground truth file, with a preview.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestRequest
        Reads files in a worker thread.
    """

    def __init__(self, frame: RGBDFrame, questions: LatestRequest, parent: QWidget | None = None) -> None:
        placeholder = "True depth: PNG, TIFF, PGM or NPY"
        title = f"Load ground truth for {frame.name}"
        super().__init__(title, placeholder, ("", "Ground truth"), "Load", questions, parent)
        self._frame = frame
        self.path.setToolTip("The file with the true depth")
        self.accept_button.setToolTip("Evaluate the frame's results against this ground truth")
        self.units = typed_list()
        self.units.addItems([_AUTOMATIC, *_UNITS])
        self.units.setToolTip(
            "File units per metre. Automatic: those of the frame's depth if both are whole numbers; otherwise 1000 for "
            "whole numbers and 1 for floating-point depth."
        )
        self.units.editTextChanged.connect(self.schedule)
        self.setMinimumWidth(600)
        kinds = files_of("Depth", DEPTH_FILE_SUFFIXES)
        file = self.browse_button(
            "File…", lambda: choose_file(self, "Select ground truth", _FOLDER_KEY, kinds, frame), self.choose
        )
        file.setToolTip("Select the file with the true depth")
        path = label_of("Ground &truth", self.path), row(self.path, file)
        self.ask(form(path, ("&Units per metre", self.units)))

    def look(self) -> Look | Callable[[], Look]:
        path = self.path.text().strip()
        if not path:
            return self.refused(_NOTHING_SELECTED, "muted")
        file = str(Path(path).expanduser().absolute())
        return partial(_look_at, self._frame, file, _units(self.units.currentText()))


def _look_at(frame: RGBDFrame, file: str, units: float | None) -> Look:
    """Read ground truth, and show it."""
    found = with_ground_truth_file(frame, file, units)
    note_opened(file)
    left_out = found.notes[len(frame.notes) :]
    text, tone = " ".join((described(found), *left_out)), "warning" if left_out else "good"
    return Look(text, tone, depth=found.ground_truth, found=found)


def described(frame: RGBDFrame) -> str:
    """Describe the coverage and deviation of a frame's ground truth, from a sample of its pixels."""
    if frame.ground_truth is None:
        return "There is no ground truth."
    ground_truth, depth = sample(frame.ground_truth), sample(frame.depth)
    known, missing = np.isfinite(ground_truth), np.isnan(depth)
    share = known[missing].mean() if missing.any() else known.mean()
    text = f"Known at {share:.0%} of the pixels{' without depth' if missing.any() else ''}"
    both = known & ~missing
    if not both.any():
        return f"{text}."
    off = float(np.median(np.abs(ground_truth[both] - depth[both])))
    return f"{text}; median deviation from the known depth: {1000 * off:.1f} mm."


def _units(text: str) -> float | None:
    """Units per metre from the text of the field; None for automatic."""
    if text.strip() in ("", _AUTOMATIC):
        return None
    try:
        return float(text.split("(")[0])
    except ValueError:
        raise InputError(f"Units per metre must be a number above 0, such as 1000, not {text!r:.30}.") from None
