"""The dialog that asks for files that are missing or have changed."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QHeaderView,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gui.widgets.messages import Message
from gui.widgets.plain_text import as_it_is
from gui.widgets.work_row import WorkRow
from ilf.number_words import grouped
from ilf.project.finding import LostFile

_NUMBER = Qt.ItemDataRole.UserRole
_ABOUT = (
    "Some frames cannot be opened: their files are not where they were, or are not what they were. Say where they are "
    "now; what is found is checked by its content, and whatever else is missing is looked for in the same place. The "
    "work on these frames stays in the project, whatever you do here."
)


@dataclass(frozen=True)
class LostRow:
    """A lost file, with the name of its frame."""

    name: str
    lost: LostFile


class MissingDialog(QDialog):
    """Lost files, with what is known of them, and what can be done.

    Signals
    -------
    file_given(object, object), folder_given(object)
        Where the user says that a LostFile is; where all of them may be.
    new_wished(object)
        The frame of a LostFile that has changed is to be opened anew, without the work.
    cancelled()
        The search is to end.
    """

    file_given = Signal(object, object)
    folder_given = Signal(object)
    new_wished = Signal(object)
    cancelled = Signal()

    def __init__(self, project: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Missing Files of {project}")
        self._rows: list[LostRow] = []
        about = Message(lines=3)
        about.say(_ABOUT, "text")
        self.files = QTreeWidget()
        self.files.setStyleSheet("QTreeView::item { padding: 3px 0; }")
        self.files.setAccessibleName("Missing and changed files")
        self.files.setToolTip("Files that frames were read from, and what is wrong with them")
        self.files.setHeaderLabels(["Frame", "File", "What is wrong"])
        self.files.setRootIsDecorated(False)
        self.files.setUniformRowHeights(True)
        self.files.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        header = self.files.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        for column in (0, 2):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        self.file_button = QPushButton("Locate &file…", autoDefault=False)
        self.file_button.setToolTip("Choose the file that is marked, where it is now; others are looked for beside it")
        self.folder_button = QPushButton("Locate f&older…", autoDefault=False)
        self.folder_button.setToolTip("Choose a folder: all files are looked for in it and below it, by their content")
        self.new_button = QPushButton("Open as &new frame", autoDefault=False)
        self.new_button.setToolTip(
            "Open the changed file as a frame of its own: without the blocks and results, which would not be of it"
        )
        self.work = WorkRow("search")
        self.message = Message(lines=2)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setToolTip("Leave these frames as they are for now")
        buttons.rejected.connect(self.reject)
        self.files.currentItemChanged.connect(lambda *_: self._allow())
        self.file_button.clicked.connect(self._ask_file)
        self.folder_button.clicked.connect(self._ask_folder)
        self.new_button.clicked.connect(self._wish_new)
        self.work.cancelled.connect(self.cancelled)

        row = QHBoxLayout()
        row.setSpacing(8)
        for button in (self.file_button, self.folder_button, self.new_button):
            row.addWidget(button)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addWidget(self.files, 1)
        layout.addLayout(row)
        layout.addWidget(self.work)
        layout.addWidget(self.message)
        layout.addWidget(buttons)
        self.resize(760, 430)

    def show_rows(self, rows: Sequence[LostRow]) -> None:
        """What is missing now."""
        chosen = self.chosen()
        self._rows = list(rows)
        self.files.clear()
        for number, (name, lost) in enumerate((row.name, row.lost) for row in rows):
            item = QTreeWidgetItem([name, lost.wanted.path, "changed" if lost.changed else "not there"])
            item.setData(0, _NUMBER, number)
            item.setToolTip(1, as_it_is(_details(lost)))
            item.setToolTip(2, as_it_is(_details(lost)))
            self.files.addTopLevelItem(item)
            if number == 0 or lost == chosen:
                self.files.setCurrentItem(item)
        self._allow()

    def chosen(self) -> LostFile | None:
        """The marked file."""
        item = self.files.currentItem()
        number = None if item is None else item.data(0, _NUMBER)
        return None if number is None or number >= len(self._rows) else self._rows[number].lost

    def choose(self, frame: str) -> None:
        """Mark the first file of a frame, by its id."""
        for number, row in enumerate(self._rows):
            if row.lost.frame == frame:
                item = self.files.topLevelItem(number)
                if item is not None:
                    self.files.setCurrentItem(item)
                return

    def show_search(self, share: float | None) -> None:
        """How far the search is; None: none is under way."""
        if share is None:
            self.work.end()
        elif self.work.isHidden():
            self.work.begin()
            self.message.say("")
        else:
            self.work.show_share(share)
        self._allow()

    def _allow(self) -> None:
        lost, idle = self.chosen(), self.work.isHidden()
        self.file_button.setEnabled(idle and lost is not None)
        self.folder_button.setEnabled(idle and bool(self._rows))
        self.new_button.setEnabled(idle and lost is not None and lost.changed is not None)
        if lost is not None and idle and self.message.tone() != "error":
            self.message.say(_details(lost))

    def _ask_file(self) -> None:
        lost = self.chosen()
        if lost is None:
            return
        name = Path(lost.wanted.path).name
        path, _ = QFileDialog.getOpenFileName(self, f"Locate {name}", str(_nearest(lost.wanted.path)))
        if path:
            self.file_given.emit(lost, Path(path))

    def _ask_folder(self) -> None:
        lost = self.chosen()
        start = _nearest(lost.wanted.path if lost is not None else "")
        folder = QFileDialog.getExistingDirectory(self, "Locate Files in Folder", str(start))
        if folder:
            self.folder_given.emit(Path(folder))

    def _wish_new(self) -> None:
        lost = self.chosen()
        if lost is not None and lost.changed is not None:
            self.new_wished.emit(lost)


def _details(lost: LostFile) -> str:
    """What is known of a lost file."""
    wanted = f"{lost.wanted.path}" + (f" (SHA-256 {lost.wanted.sha256[:12]}…)" if lost.wanted.sha256 else "")
    if lost.changed is None:
        return f"{wanted} is not there any more."
    try:
        status = lost.changed.stat()
        when = datetime.datetime.fromtimestamp(status.st_mtime)
        known = f", {grouped(status.st_size)} bytes, of {when:%Y-%m-%d %H:%M},"
    except OSError:
        known = ""
    return (
        f"{lost.changed}{known} has another content than the file that the work was done on. It is not opened in its "
        "place: results would not be of it."
    )


def _nearest(path: str) -> Path:
    """The folder of a path, or the next above it that is there."""
    folder = Path(path).parent
    return next((one for one in (folder, *folder.parents) if one.is_dir()), Path.home())
