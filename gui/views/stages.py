"""The stage of the extraction that the views show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction

from ilf.drawing.blocks import STAGES, stage_count, stage_legend
from ilf.segmentation.extraction import Extraction


class StageModel(QObject):
    """The stage shown in all extraction cells, and its picture.

    Signals
    -------
    changed()
        The picture, text or stage changed.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.stage = "blocks"
        self.actions: Sequence[QAction] = ()
        """The commands that select a stage."""
        self.picture: NDArray[np.uint8] | None = None
        """Picture from `stage_picture`; None while there is only `message`."""
        self.message = ""
        self.text = ""
        """Text about the picture."""
        self.legend: list[tuple[tuple[int, int, int], str]] = []

    def set_stage(self, name: str) -> None:
        """Select the stage; the picture stays until the stage's own is shown."""
        if name not in STAGES:
            raise ValueError(f"stage must be one of {', '.join(STAGES)}, not {name!r}")
        if name != self.stage:
            self.stage = name
            self.changed.emit()

    def show_picture(self, stage: str, picture: NDArray[np.uint8], extraction: Extraction) -> None:
        """Show the picture of a stage of an extraction, from `stage_picture`."""
        self.picture, self.legend = picture, stage_legend(stage, extraction)
        self.show_text(stage_count(stage, extraction))

    def show_message(self, message: str) -> None:
        """Show a message in place of the picture."""
        self.message, self.picture, self.legend = message, None, []
        self.show_text("")

    def show_text(self, text: str) -> None:
        """Change the text about the picture."""
        self.text = text
        self.changed.emit()
