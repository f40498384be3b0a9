"""Choice of files and folders in the system's dialogs, which open where the last one of their kind was chosen."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QBuffer, QSettings
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QFileDialog, QWidget

from ilf._runtime.installation import is_asset
from ilf._runtime.writing import write_bytes
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError

from .notes import Notes

EXPORTS = "export/folder"
"""The kind of all that is written, except projects, presets, and exports of several frames."""
EXPORTS_OF_FRAMES = "export/folder_of_frames"
"""The kind of exports of several frames: a folder of one of the frames is no place for them."""


def last_folder(kind: str, frame: RGBDFrame | None = None) -> str:
    """Return the last folder of a kind of files if it still exists; else that of a frame, or the home folder."""
    beside = "" if frame is None or frame.inputs is None else os.path.dirname(frame.inputs.rgb.path)
    folders = str(QSettings().value(kind, "")), beside
    return next((folder for folder in folders if os.path.isdir(folder)), str(Path.home()))


def remember_folder(kind: str, path: str | os.PathLike[str]) -> None:
    """Remember the folder of a chosen file, or the one that contains a chosen folder."""
    QSettings().setValue(kind, str(Path(path).absolute().parent))


def choose_file(parent: QWidget, title: str, kind: str, filters: str, frame: RGBDFrame | None = None) -> str:
    """Ask for an existing file, at first beside those of a frame; return "" if the user cancels."""
    path, _ = QFileDialog.getOpenFileName(parent, title, last_folder(kind, frame), filters)
    return _remembered(kind, path)


def choose_folder(parent: QWidget, title: str, kind: str) -> str:
    """Ask for an existing folder; return "" if the user cancels."""
    return _remembered(kind, QFileDialog.getExistingDirectory(parent, title, last_folder(kind)))


def _remembered(kind: str, path: str) -> str:
    if path:
        remember_folder(kind, path)
    return path


def save_folder(beside: str = "", kind: str = EXPORTS) -> Path:
    """Return the default folder for files: that of the last export of a kind, if any, of the file `beside` unless it is
    the program's own, or the working folder."""
    last = QSettings().value(kind) if kind else None
    folder = Path(str(last)) if last else Path(beside).parent if beside and not is_asset(beside) else Path.cwd()
    return folder if os.path.isdir(folder) and os.access(folder, os.W_OK) else Path.home()


def ask_path(window: QWidget, title: str, name: str, kinds: str) -> str:
    """Ask for the file to write, as `ask_file`, and return it alone."""
    return ask_file(window, title, name, kinds)[0]


def ask_file(window: QWidget, title: str, name: str, kinds: str) -> tuple[str, str]:
    """Ask for the file to write, and return it and its kind, one of `kinds` ("Table (*.csv);;…"), whose suffix is added
    if none was typed; the file is "" if the user cancels."""
    path, kind = QFileDialog.getSaveFileName(window, title, str(save_folder() / name), kinds)
    kind = kind or kinds.partition(";;")[0]  # some systems do not tell which was selected
    suffix = kind.partition("*")[2].rstrip(")")  # none of "Folder (*)"
    if path and not Path(path).suffix and suffix:
        path += suffix
        if Path(path).exists():  # the dialog has asked about the name without the suffix: it asks about the whole one
            return ask_file(window, title, path, kinds)
    return path, kind


def save(notes: Notes, path: str, write: Callable[[], None]) -> bool:
    """Write a file and report it; return False, with an error message, if it cannot be written."""
    try:
        write()
    except IlfError as error:
        notes.report("Not saved", error)
        return False
    notes.show_message(f"Saved {path}")
    return True


def write_picture(path: str | Path, picture: QPixmap) -> None:
    """Write a picture as PNG."""
    content = QBuffer()
    content.open(QBuffer.OpenModeFlag.WriteOnly)
    picture.save(content, "PNG")
    write_bytes(path, bytes(content.data().data()))
