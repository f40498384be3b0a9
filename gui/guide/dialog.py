"""The dialog that loads a guide: which file, and what the known depth makes of it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QWidget

from gui.dialogs.frame_files import GUIDE_FILES
from gui.dialogs.reading_dialog import ReadingDialog
from gui.widgets.messages import last_folder
from gui.widgets.plain_text import PlainLabel
from gui.work.latest_question import LatestQuestion
from ilf.filter.edge_aware.guiding import FittedGuide, fit_guide
from ilf.frame import RGBDFrame
from ilf.io import load_guide

_FOLDER_KEY = "guide/folder"
_NOTHING_CHOSEN = (
    "Choose depth or inverse depth of this frame, in any unit: from a network that guesses depth from colour, or "
    "another sensor. Zero and NaN say nothing."
)


class GuideSource(NamedTuple):
    """A file with a guide of a frame."""

    frame: RGBDFrame
    path: str


class Guided(NamedTuple):
    """The frame with its guide, and that in metres."""

    frame: RGBDFrame
    fitted: FittedGuide


def guided(source: GuideSource) -> Guided:
    """Read the file, and fit it to the known depth; called off the GUI's thread."""
    frame = source.frame.with_guide(load_guide(source.path, source.frame.shape))
    fitted = fit_guide(frame)
    assert fitted is not None
    return Guided(frame, fitted)


class GuideDialog(ReadingDialog[GuideSource, Guided]):
    """Choose a guide, and see what it is before it is taken.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestQuestion
        Which reads a `GuideSource`.
    """

    def __init__(
        self, frame: RGBDFrame, questions: LatestQuestion[GuideSource, Guided], parent: QWidget | None = None
    ) -> None:
        placeholder = "Depth or inverse depth: PNG, TIFF, PGM, NPY or NPZ"
        title = f"Load Guide for {frame.name}"
        super().__init__(title, placeholder, _NOTHING_CHOSEN, "Guide, fitted", _FOLDER_KEY, questions, parent)
        self._frame = frame
        self.path.setToolTip("The file with the guide")
        self.load_button.setToolTip("Follow this guide in the runs to come")
        self.file_button.setToolTip("Choose the file with the guide")
        label = PlainLabel("&Guide")
        label.setBuddy(self.path)
        row = QHBoxLayout()
        row.setSpacing(8)
        row.addWidget(label)
        row.addWidget(self.path, 1)
        row.addWidget(self.file_button)
        self.setMinimumWidth(600)
        self.ask(row)

    def source(self, path: str) -> GuideSource:
        return GuideSource(self._frame, str(Path(path).expanduser().absolute()))

    def show_found(self, found: Guided) -> None:
        self.preview.show_depth(found.fitted.depth)
        self.message.say(described(found.fitted), "good" if found.fitted.belief else "warning")

    def browse(self) -> None:
        path, _ = QFileDialog.getOpenFileName(self, "Choose guide", last_folder(_FOLDER_KEY), GUIDE_FILES)
        self.choose(path)


def described(fitted: FittedGuide) -> str:
    """How much a guide says, and how far it is believed."""
    said = f"It says something of {(fitted.confidence > 0).mean():.0%} of the pixels"
    return f"{said}, and is {fitted.in_words()}."
