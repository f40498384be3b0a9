"""The dialog that asks for the file of a project, and whether to include the frames' own files."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QLocale
from PySide6.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QFileDialog, QLineEdit, QPushButton, QWidget

from ilf.errors import InputError
from ilf.sources.frame_ref import FrameRef

from ...base.paths import PROJECT_SUFFIX
from ...widgets.basics import Message, answers, label_of, row, stack
from ...widgets.file_choice import last_folder, remember_folder

FOLDER_KEY = "project/folder"
FILE_FILTER = f"Project of ILF Studio (*{PROJECT_SUFFIX})"
_NOT_EMBEDDED = "The frames' files are not included: copy them, too, when you move the project to another computer."
_BEFORE_WHOLE_PATH = re.compile(r"^.*[/\\](?=/|~/|[A-Za-z]:[/\\])")
"""What stands before a whole path that was typed over the name."""
_MAX_SIZED = 500
"""Maximum number of frames whose file sizes are added up for the dialog."""


class SaveAsDialog(QDialog):
    """Dialog to choose the project file, and whether it includes the frames' files.

    Parameters
    ----------
    proposed : Path
        Default file.
    embedded : bool
        Whether the project includes the frames' files now.
    sources : collection of FrameRef
        Sources of its frames.
    why : str
        Why the project is not saved to its former file, "" for no message.
    parent : QWidget
    """

    def __init__(
        self, proposed: Path, embedded: bool, sources: Collection[FrameRef], why: str, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save Project As")
        size = f" ({_size_text(sources)})" if len(sources) <= _MAX_SIZED else ""
        self.path = QLineEdit(str(proposed))
        self.path.setSelection(len(str(proposed)) - len(proposed.name), len(proposed.stem))  # to type another name
        self.path.setMinimumWidth(380)
        self.path.setToolTip(f"The project file; {PROJECT_SUFFIX} is added if it has no suffix")
        browse = QPushButton("&Browse…")
        browse.setToolTip("Choose the file")
        browse.clicked.connect(self._browse)
        self.embed = QCheckBox(f"&Include the frames' own files{size}")
        self.embed.setToolTip(
            "Include the colour, depth and ground truth files of all frames, so that the project can be opened on any "
            "computer; otherwise it contains their paths and hashes. Recordings are never included"
        )
        self.embed.setChecked(embedded)
        self.message = Message(lines=3)
        buttons, self.save_button = answers(self, QDialogButtonBox.StandardButton.Save)
        self._why = why
        self.path.textEdited.connect(self._start_anew)
        self.path.textChanged.connect(lambda _: self._check())
        self.embed.toggled.connect(lambda _: self._check())

        stack(self, row(label_of("&File", self.path), self.path, browse), self.embed, self.message, buttons)
        self._check()

    def chosen(self) -> Path:
        """Return the file, with its suffix."""
        path = Path(os.path.expanduser(self.path.text().strip())).absolute()
        return path if path.suffix or not path.name else path.with_name(path.name + PROJECT_SUFFIX)

    def accept(self) -> None:
        """Remember the folder."""
        remember_folder(FOLDER_KEY, self.chosen())
        super().accept()

    def _browse(self) -> None:
        path, _ = QFileDialog.getSaveFileName(
            self, "Save Project As", str(self.chosen()), FILE_FILTER, options=QFileDialog.Option.DontConfirmOverwrite
        )
        if path:
            self.path.setText(path)

    def _start_anew(self, text: str) -> None:
        """Drop the folder before a whole path that is typed over the name."""
        behind = len(text) - self.path.cursorPosition()
        whole = _BEFORE_WHOLE_PATH.sub("", text)
        if whole != text:
            self.path.setText(whole)
            self.path.setCursorPosition(len(whole) - behind)

    def _check(self) -> None:
        """Show what is wrong with the file, or that an existing one will be replaced."""
        problem, path = self._problem(), self.chosen()
        replaces = not problem and path.exists()
        self.save_button.setEnabled(not problem)
        self.save_button.setText("&Replace" if replaces else "&Save")
        if problem:
            self.message.show_message(problem, "error")
        elif replaces:
            self.message.show_message(f"{path.name} exists already and will be replaced.", "warning")
        elif not path.parent.exists():
            self.message.show_message(f"The folder {path.parent} will be created.", "warning")
        else:
            self.message.show_message(self._why or ("" if self.embed.isChecked() else _NOT_EMBEDDED))

    def _problem(self) -> str:
        """Return why the file cannot be written, and what to do; "" if it can."""
        path = self.chosen()
        if not self.path.text().strip():
            return "Enter a file name."
        there = next(folder for folder in (path.parent, *path.parent.parents) if folder.exists())
        if not there.is_dir() or not os.access(there, os.W_OK):
            return f"{there} cannot be written: choose another folder."
        if path.is_dir():
            return f"{path.name or path} is a folder: choose another name."
        if path.exists() and not os.access(path, os.W_OK):
            return f"{path.name} is write-protected: choose another name."
        return ""


def proposed_path(name: str) -> Path:
    """Return the default file of a project, in the folder of the last one."""
    safe = "".join(letter if letter.isalnum() or letter in "-_. " else "-" for letter in name).strip(" .")
    return Path(last_folder(FOLDER_KEY)) / f"{safe or 'project'}{PROJECT_SUFFIX}"


def _size_text(sources: Collection[FrameRef]) -> str:
    size = sum(map(_size_of, sources))
    return QLocale.c().formattedDataSize(size, 1, QLocale.DataSizeFormat.DataSizeSIFormat)


def _size_of(source: FrameRef) -> int:
    """Return the size of a frame's existing files [bytes]; 0 for recordings, which are never included."""
    with suppress(InputError, OSError):
        source = source.allowed()
        named = [Path(path) for path in (source.rgb, source.depth, source.options.ground_truth) if path is not None]
        files = (file for path in named for file in (path.iterdir() if path.is_dir() else [path]))
        return 0 if source.frame is not None else sum(file.stat().st_size for file in files if file.is_file())
    return 0
