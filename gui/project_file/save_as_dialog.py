"""The dialog that asks where a project is saved, and whether the frames' own files go in."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gui.frames.paths import PROJECT_SUFFIX
from gui.widgets.messages import Message, last_folder
from gui.widgets.plain_text import PlainLabel
from ilf.io.frame_source import FrameSource

FOLDER_KEY = "project/folder"
_BY_PLACE = "The frames' files stay where they are: take them along when you move the project to another machine."
_MOST_SIZED = 500
"""Frames whose files are looked at, to say how large they are."""
KINDS = f"Project of ILF Studio (*{PROJECT_SUFFIX})"


class SaveAsDialog(QDialog):
    """Choose the file, and whether it holds the frames' files, too.

    Parameters
    ----------
    proposed : Path
        The file, unless the user says otherwise.
    embedded : bool
        Whether the frames' files are in the project now.
    sources : collection of FrameSource
        Of its frames.
    why : str
        Why it is not saved where it was, "" if there is nothing to say.
    parent : QWidget
    """

    def __init__(
        self, proposed: Path, embedded: bool, sources: Collection[FrameSource], why: str, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save Project As")
        size = f" ({_words(sum(map(_size_of, sources)))})" if len(sources) <= _MOST_SIZED else ""
        self.path = QLineEdit(str(proposed))
        self.path.setMinimumWidth(380)
        self.path.setToolTip(f"The file that holds the project; {PROJECT_SUFFIX} is added if it has no suffix")
        browse = QPushButton("&Browse…", autoDefault=False)
        browse.setToolTip("Choose the file")
        browse.clicked.connect(self._browse)
        self.embed = QCheckBox(f"&Include the frames' own files{size}")
        self.embed.setToolTip(
            "Put the colour, depth and truth files of all frames into the project, so that it can be opened anywhere "
            "by itself; without, it notes where they are and what they hold. Recordings stay where they are"
        )
        self.embed.setChecked(embedded)
        self.message = Message(lines=3)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel)
        self.save_button = buttons.button(QDialogButtonBox.StandardButton.Save)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self._why = why
        self.path.textChanged.connect(lambda _: self._check())
        self.embed.toggled.connect(lambda _: self._check())

        label = PlainLabel("&File")
        label.setBuddy(self.path)
        row = QHBoxLayout()
        row.setSpacing(8)
        for widget in (label, self.path, browse):
            row.addWidget(widget)
        column = QVBoxLayout(self)
        column.setContentsMargins(14, 14, 14, 14)
        column.setSpacing(10)
        column.addLayout(row)
        column.addWidget(self.embed)
        column.addWidget(self.message)
        column.addStretch(1)
        column.addWidget(buttons)
        self._check()

    def chosen(self) -> Path:
        """The file, with its suffix."""
        path = Path(os.path.expanduser(self.path.text().strip())).absolute()
        return path if path.suffix or not path.name else path.with_name(path.name + PROJECT_SUFFIX)

    def accept(self) -> None:
        """Remember the folder."""
        QSettings().setValue(FOLDER_KEY, str(self.chosen().parent))
        super().accept()

    def _browse(self) -> None:
        path, _ = QFileDialog.getSaveFileName(
            self, "Save Project As", str(self.chosen()), KINDS, options=QFileDialog.Option.DontConfirmOverwrite
        )
        if path:
            self.path.setText(path)

    def _check(self) -> None:
        """Say what is wrong with the file, or what becomes of one that is there."""
        problem, replaces = "", False
        if not self.path.text().strip():
            problem = "Name a file."
        else:
            path = self.chosen()
            if not path.parent.is_dir():
                problem = f"{path.parent} does not exist: make this folder, or choose another."
            elif not os.access(path.parent, os.W_OK):
                problem = f"{path.parent} cannot be written: choose another folder."
            elif path.is_dir():
                problem = f"{path.name or path} is a folder: choose another name."
            elif path.exists() and not os.access(path, os.W_OK):
                problem = f"{path.name} is write-protected: choose another name."
            replaces = not problem and path.exists()
        self.save_button.setEnabled(not problem)
        self.save_button.setText("&Replace" if replaces else "&Save")
        if problem:
            self.message.say(problem, "error")
        elif replaces:
            self.message.say(f"{self.chosen().name} is there already, and will be replaced.", "warning")
        else:
            self.message.say(self._why or ("" if self.embed.isChecked() else _BY_PLACE))


def proposed_path(name: str) -> Path:
    """Where a project goes unless the user says otherwise: where the last one went."""
    safe = "".join(letter if letter.isalnum() or letter in "-_. " else "-" for letter in name).strip(" .")
    return Path(last_folder(FOLDER_KEY)) / f"{safe or 'project'}{PROJECT_SUFFIX}"


def _size_of(source: FrameSource) -> int:
    """Bytes of a frame's files, as far as they are there; recordings stay where they are."""
    size = 0
    if source.frame is not None:
        return size
    for path in (source.rgb, source.depth, source.truth):
        if path is None:
            continue
        try:
            files = [entry for entry in os.scandir(path) if entry.is_file()] if os.path.isdir(path) else [Path(path)]
            size += sum(file.stat().st_size for file in files)
        except OSError:
            continue
    return size


def _words(size: int) -> str:
    return f"{size / 1e6:.0f} MB" if size >= 1e7 else f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"
