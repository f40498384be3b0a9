"""The dialog that loads blocks: from which file or folder, and what becomes of the gaps between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtCore import QSettings, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gui.dialogs.block_files import BlockSource
from gui.dialogs.preview import Preview
from gui.extraction.found_blocks import describe_blocks
from gui.widgets.messages import Message, last_folder
from gui.widgets.problems import error_text
from gui.work.latest_question import LatestQuestion
from ilf.drawing.block_pictures import block_overlay
from ilf.frame import RGBDFrame
from ilf.io import LoadedBlocks
from ilf.parameters import BlockParameters

_FOLDER_KEY = "blocks/folder"
_DELAY_MS = 200
_NOTHING_CHOSEN = (
    "Choose a label map (PNG), a labelme or COCO file (JSON), masks of segment-anything (JSON), or a folder of masks, "
    "a PNG each."
)


class LoadBlocksDialog(QDialog):
    """Choose blocks, and see what they are before they are taken.

    Load is enabled only while what is chosen has been read. Reading goes on off the GUI's thread.

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
        super().__init__(parent)
        self.setWindowTitle(f"Load Blocks for {frame.name}")
        self._frame = frame
        self._filling = filling
        self._questions = questions
        self._wanted: BlockSource | None = None
        self._found: LoadedBlocks | None = None
        self._delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._delay.timeout.connect(self.read)
        questions.answered.connect(self._take)
        questions.failed.connect(self._fail)

        self.path = QLineEdit(placeholderText="Label map, labelme or COCO file, or folder of masks")
        self.fill_gaps = QCheckBox("&Fill gaps by the extraction")
        self.fill_gaps.setToolTip(
            "Where the file has no block, take what the extraction finds with the values of the tab Extraction"
        )
        self.preview = Preview("Blocks")
        self.message = Message(lines=5)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Open | QDialogButtonBox.StandardButton.Cancel)
        self.load_button = buttons.button(QDialogButtonBox.StandardButton.Open)
        self.load_button.setText("Load")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)

        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(12)
        layout.addLayout(self._row())
        layout.addWidget(self.fill_gaps)
        shown = QHBoxLayout()
        shown.setSpacing(12)
        shown.addWidget(self.preview)
        shown.addWidget(self.message, 1)
        layout.addLayout(shown)
        layout.addStretch(1)
        layout.addWidget(buttons)
        self.setMinimumWidth(640)
        self.path.textChanged.connect(self._schedule)
        self.fill_gaps.toggled.connect(self.read)
        self.read()

    def blocks(self) -> LoadedBlocks:
        """What was loaded; only to be asked for once it was."""
        if self._found is None:
            raise RuntimeError("no blocks have been read")
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
        self.message.say("Reading…")
        self._wanted = BlockSource(self._frame, path, self._filling if self.fill_gaps.isChecked() else None)
        self._questions.ask(self._wanted)

    def _row(self) -> QHBoxLayout:
        label = QLabel("&Blocks")
        label.setBuddy(self.path)
        file, folder = QPushButton("File…", autoDefault=False), QPushButton("Folder…", autoDefault=False)
        file.clicked.connect(self._browse_file)
        folder.clicked.connect(self._browse_folder)
        row = QHBoxLayout()
        row.setSpacing(8)
        for widget in (label, self.path, file, folder):
            row.addWidget(widget, 1 if widget is self.path else 0)
        return row

    def _schedule(self) -> None:
        self._forget()
        self._delay.start()

    def _forget(self) -> None:
        self._wanted = self._found = None
        self._questions.forget()
        self.load_button.setEnabled(False)
        self.preview.show_rgb(None)

    def _browse_file(self) -> None:
        path, _ = QFileDialog.getOpenFileName(
            self, "Choose blocks", last_folder(_FOLDER_KEY), "Blocks (*.png *.json);;All files (*)"
        )
        self._choose(path)

    def _browse_folder(self) -> None:
        self._choose(QFileDialog.getExistingDirectory(self, "Choose folder of masks", last_folder(_FOLDER_KEY)))

    def _choose(self, path: str) -> None:
        if path:
            QSettings().setValue(_FOLDER_KEY, str(Path(path).parent))
            self.path.setText(path)
            self.read()

    def _take(self, source: BlockSource, blocks: LoadedBlocks) -> None:
        if source is not self._wanted:
            return
        self._found = blocks
        self.preview.show_rgb(block_overlay(self._frame.rgb, blocks.labels))
        count = int(np.count_nonzero(np.bincount(blocks.labels.ravel())[1:]))
        named = f", {len(blocks.names)} of them named" if blocks.names else ""
        text = f"{describe_blocks(count, blocks.labels)}{named}."
        self.message.say("\n".join([text, *blocks.notes]), "warning" if blocks.notes else "good")
        self.load_button.setEnabled(True)

    def _fail(self, source: BlockSource, error: Exception) -> None:
        if source is self._wanted:
            self.message.say(error_text(error).replace(f"{Path(source.path).parent}/", ""), "error")
