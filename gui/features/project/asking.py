"""The question whether a place that a file names is opened."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from ilf._runtime.named_places import NotAllowed, note_opened


def ask_to_open(parent: QWidget, error: NotAllowed, yes: Callable[[], None], no: Callable[[], None]) -> None:
    """Ask whether to open a place; call `yes` after it was noted as opened by the user, else `no`."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setIcon(QMessageBox.Icon.Warning)
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setWindowTitle("Open this place?")
    box.setText(f"A file names {error.place}, which lies outside its own folder and was never opened here.")
    box.setInformativeText("Open it only if you trust the file: opening may contact another computer.")
    box.setStandardButtons(QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No)
    box.setDefaultButton(QMessageBox.StandardButton.No)

    def answer(result: int) -> None:
        if result == QMessageBox.StandardButton.Yes:
            note_opened(error.place)
            yes()
        else:
            no()

    box.finished.connect(answer)
    box.open()
