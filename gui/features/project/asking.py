"""The question whether places that a file names are opened."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from ilf._runtime.named_places import NotAllowed, note_opened
from ilf.errors import one_line


def ask_to_open(parent: QWidget, error: NotAllowed, yes: Callable[[], None], no: Callable[[], None]) -> None:
    """Ask whether to open places; call `yes` after they were noted as opened by the user, else `no`."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setIcon(QMessageBox.Icon.Warning)
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setWindowTitle("Open what a file names?")
    places = "\n".join(map(one_line, error.places))
    box.setText(f"A file names this outside its own folder, which was never opened here:\n{places}")
    box.setInformativeText(
        "Open it, and files beside it that are named, only if you trust the file: opening may contact another computer."
    )
    box.setStandardButtons(QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No)
    box.setDefaultButton(QMessageBox.StandardButton.No)

    def answer(result: int) -> None:
        if result == QMessageBox.StandardButton.Yes:
            note_opened(*error.places, beside=True)
            yes()
        else:
            no()

    box.finished.connect(answer)
    box.open()
