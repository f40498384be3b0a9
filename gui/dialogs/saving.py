"""Where files go that the user saves."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QFileDialog, QMessageBox, QWidget

from gui.widgets.notes import Notes
from gui.widgets.plain_text import as_it_is
from ilf.errors import IlfError


def save_folder() -> Path:
    """Where files go unless the user says otherwise: beside the last export, or into the working folder."""
    last = QSettings().value("export/folder")
    folder = Path(str(last)) if last else Path.cwd()
    return folder if os.path.isdir(folder) and os.access(folder, os.W_OK) else Path.home()


def ask_path(window: QWidget, title: str, name: str, kinds: str) -> str:
    """The file to write, with the suffix of the chosen one of some kinds ("Table (*.csv);;…") if none was typed; "" if
    the user does not want to."""
    path, kind = QFileDialog.getSaveFileName(window, title, str(save_folder() / name), kinds)
    if path and not Path(path).suffix and "*" in kind:
        path += kind.split("*", 1)[1].rstrip(")")
        if Path(path).exists():  # the dialog has asked about the name without the suffix
            text = f"{path} is there already. Write over it?"
            if QMessageBox.question(window, title, as_it_is(text)) != QMessageBox.StandardButton.Yes:
                return ""
    return path


def save(notes: Notes, path: str, write: Callable[[], None]) -> bool:
    """Write a file and say so; False, with what went wrong said, if it cannot be written."""
    try:
        write()
    except IlfError as error:
        notes.report("Not saved", error)
        return False
    notes.tell(f"Saved {path}")
    return True
