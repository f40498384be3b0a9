"""Dialog that loads blocks: from a file or folder, with optional filling of the gaps between them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from PySide6.QtWidgets import QCheckBox, QWidget

from ilf._runtime.formatting import covered
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import block_overlay
from ilf.io.block_files import read_blocks
from ilf.segmentation.reextraction import gaps_filled

from ...widgets.basics import label_of, row
from ...widgets.file_choice import choose_file, choose_folder
from ...work.latest_request import LatestRequest
from .file_dialogs import PreviewDialog
from .frame_files import Look


def look_at_blocks(frame: RGBDFrame, path: str, filling: BlockParameters | None) -> Look:
    """Read the blocks of a file or folder, and show them; with `filling`, an extraction with these parameters fills
    their gaps."""
    blocks = read_blocks(path, frame.shape, image=colour_file(frame))
    if filling is not None:
        blocks = gaps_filled(blocks, frame, filling)
    count = int(np.count_nonzero(np.bincount(blocks.labels.ravel())[1:]))
    named = f", {len(blocks.names)} of them named" if blocks.names else ""
    text = "\n".join((f"{covered(count, float((blocks.labels > 0).mean()))}{named}.", *blocks.notes))
    return Look(text, "warning" if blocks.notes else "good", block_overlay(frame.rgb, blocks.labels), found=blocks)


def colour_file(frame: RGBDFrame) -> str | None:
    """Return the path of a frame's colour file, which files of blocks name; None if it has none."""
    return None if frame.inputs is None else frame.inputs.rgb.path


_FOLDER_KEY = "blocks/folder"
_NOTHING_SELECTED = (
    "Choose a label map (PNG), a labelme or COCO file (JSON), masks of segment-anything (JSON), or a folder of masks "
    "(PNG)."
)


class LoadBlocksDialog(PreviewDialog):
    """Dialog to choose blocks, with a preview.

    Parameters
    ----------
    frame : RGBDFrame
    filling : BlockParameters
        Parameters of the extraction for the gaps.
    questions : LatestRequest
        Reads files in a worker thread.
    """

    def __init__(
        self,
        frame: RGBDFrame,
        filling: BlockParameters,
        questions: LatestRequest,
        parent: QWidget | None = None,
    ) -> None:
        placeholder = "Label map, labelme or COCO file, or folder of masks"
        super().__init__(f"Load blocks for {frame.name}", placeholder, ("Blocks", ""), "Load", questions, parent)
        self._frame = frame
        self._filling = filling
        self.fill_gaps = QCheckBox("&Fill gaps by extraction")
        self.fill_gaps.setToolTip(
            "Where the file has no block, extract blocks with the parameters of the tab Extraction"
        )
        self.fill_gaps.toggled.connect(self.read)
        self.setMinimumWidth(640)
        kinds = "Blocks (*.png *.json);;All files (*)"
        file = self.browse_button(
            "File…", lambda: choose_file(self, "Choose blocks", _FOLDER_KEY, kinds, frame), self.choose
        )
        folder = self.browse_button(
            "Folder…", lambda: choose_folder(self, "Choose folder of masks", _FOLDER_KEY), self.choose
        )
        self.ask(row(label_of("&Blocks", self.path), self.path, file, folder), self.fill_gaps)

    def look(self) -> Look | Callable[[], Look]:
        path = self.path.text().strip()
        if not path:
            return self.refused(_NOTHING_SELECTED, "muted")
        return partial(look_at_blocks, self._frame, path, self._filling if self.fill_gaps.isChecked() else None)
