"""The dialog that loads blocks: from which file or folder, and what becomes of the gaps between them."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QCheckBox, QFileDialog, QHBoxLayout, QPushButton, QWidget

from gui.dialogs.block_files import BlockSource
from gui.dialogs.reading_dialog import ReadingDialog
from gui.extraction.found_blocks import describe_blocks
from gui.widgets.messages import last_folder
from gui.widgets.plain_text import PlainLabel
from gui.work.latest_question import LatestQuestion
from ilf.drawing.block_pictures import block_overlay
from ilf.frame import RGBDFrame
from ilf.io import LoadedBlocks
from ilf.parameters import BlockParameters

_FOLDER_KEY = "blocks/folder"
_NOTHING_CHOSEN = (
    "Choose a label map (PNG), a labelme or COCO file (JSON), masks of segment-anything (JSON), or a folder of masks, "
    "a PNG each."
)


class LoadBlocksDialog(ReadingDialog[BlockSource, LoadedBlocks]):
    """Choose blocks, and see what they are before they are taken.

    Parameters
    ----------
    frame : RGBDFrame
    filling : BlockParameters
        What an extraction for the gaps is made with.
    questions : LatestQuestion
        Which reads a `BlockSource`.
    """

    def __init__(
        self,
        frame: RGBDFrame,
        filling: BlockParameters,
        questions: LatestQuestion[BlockSource, LoadedBlocks],
        parent: QWidget | None = None,
    ) -> None:
        placeholder = "Label map, labelme or COCO file, or folder of masks"
        title = f"Load Blocks for {frame.name}"
        super().__init__(title, placeholder, _NOTHING_CHOSEN, "Blocks", _FOLDER_KEY, questions, parent)
        self._frame = frame
        self._filling = filling
        self.fill_gaps = QCheckBox("&Fill gaps by the extraction")
        self.fill_gaps.setToolTip(
            "Where the file has no block, take what the extraction finds with the values of the tab Extraction"
        )
        self.fill_gaps.toggled.connect(self.read)
        self.setMinimumWidth(640)
        self.ask(self._row(), self.fill_gaps)

    def source(self, path: str) -> BlockSource:
        return BlockSource(self._frame, path, self._filling if self.fill_gaps.isChecked() else None)

    def show_found(self, found: LoadedBlocks) -> None:
        self.preview.show_rgb(block_overlay(self._frame.rgb, found.labels))
        count = int(np.count_nonzero(np.bincount(found.labels.ravel())[1:]))
        named = f", {len(found.names)} of them named" if found.names else ""
        text = f"{describe_blocks(count, found.labels)}{named}."
        self.message.say("\n".join([text, *found.notes]), "warning" if found.notes else "good")

    def _row(self) -> QHBoxLayout:
        label = PlainLabel("&Blocks")
        label.setBuddy(self.path)
        folder = QPushButton("Folder…", autoDefault=False)
        folder.clicked.connect(self._browse_folder)
        row = QHBoxLayout()
        row.setSpacing(8)
        for widget in (label, self.path, self.file_button, folder):
            row.addWidget(widget, 1 if widget is self.path else 0)
        return row

    def browse(self) -> None:
        path, _ = QFileDialog.getOpenFileName(
            self, "Choose blocks", last_folder(_FOLDER_KEY), "Blocks (*.png *.json);;All files (*)"
        )
        self.choose(path)

    def _browse_folder(self) -> None:
        self.choose(QFileDialog.getExistingDirectory(self, "Choose folder of masks", last_folder(_FOLDER_KEY)))
