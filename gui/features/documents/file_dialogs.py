"""What dialogs share that load one file: it is read off the GUI's thread, and shown before it is taken."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSettings, QSize, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFrame,
    QHBoxLayout,
    QLayout,
    QLineEdit,
    QMessageBox,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ilf.drawing.colours import robust_depth_levels, to_indices
from ilf.errors import IlfError, InputError

from ...views.colours import depth_table
from ...views.pixel_items import rgb_image
from ...widgets.basics import Message, PlainLabel, as_it_is
from ...widgets.notices import Notes, error_text
from ...work.latest_question import LatestQuestion

# A picture of what a dialog is about to open.

_SIZE = QSize(304, 204)


class Preview(QFrame):
    """A picture in a box of fixed size, with its name below."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name
        self.picture = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.picture.setFixedSize(_SIZE)
        self.picture.setFrameShape(QFrame.Shape.StyledPanel)
        self._caption = Message()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addWidget(self.picture)
        column.addWidget(self._caption)
        self.show_rgb(None)

    def show_rgb(self, rgb: NDArray[np.uint8] | None) -> None:
        """Show uint8 (H, W, 3), or nothing."""
        if rgb is None:
            self.picture.clear()
            self._caption.say(self._name)
            return
        height, width = rgb.shape[:2]
        self._caption.say(f"{self._name}, {width} x {height}")
        self.picture.setPixmap(
            QPixmap.fromImage(rgb_image(rgb)).scaled(
                _SIZE - QSize(4, 4), Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            )
        )

    def show_depth(self, depth: NDArray[np.generic] | None) -> None:
        """Show depth (H, W) in any unit by its colours, missing pixels black, or nothing."""
        if depth is None:
            self.show_rgb(None)
            return
        values = depth.astype(np.float32)
        values[~(values > 0)] = np.nan
        self.show_rgb(depth_table("turbo")[to_indices(values, *robust_depth_levels(values))][..., :3])


_DELAY_MS = 200


class FileSource(Protocol):
    """What is to be read."""

    @property
    def path(self) -> str:
        """The file."""
        ...


Source = TypeVar("Source", bound=FileSource)
Found = TypeVar("Found")


class ReadingDialog(QDialog, Generic[Source, Found]):
    """Choose a file, and see what it is before it is taken. Load is enabled only while what is chosen has been read.

    The focus is at the button that opens a file, and goes on to Load with what was chosen there.

    Parameters
    ----------
    title, placeholder, nothing_chosen, shown : str
        Of the window, of the field for the path, what is said while that is empty, and of the preview.
    folder_key : str
        Where the settings have the folder that was chosen from last.
    questions : LatestQuestion
        Which reads what `source` gives.
    """

    def __init__(
        self,
        title: str,
        placeholder: str,
        nothing_chosen: str,
        shown: str,
        folder_key: str,
        questions: LatestQuestion[Source, Found],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._nothing_chosen = nothing_chosen
        self._folder_key = folder_key
        self._questions = questions
        self._wanted: Source | None = None
        self._found: Found | None = None
        self._delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._delay.timeout.connect(self.read)
        questions.answered.connect(self._take)
        questions.failed.connect(self._fail)
        self.path = QLineEdit(placeholderText=placeholder)
        self.path.textChanged.connect(self.schedule)
        self.file_button = QPushButton("File…")
        self.file_button.clicked.connect(lambda _=False: self.browse())
        self._browsed = False
        """Whether what is being read was browsed to, and not typed."""
        self.preview = Preview(shown)
        self.message = Message(lines=5)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Open | QDialogButtonBox.StandardButton.Cancel)
        self.load_button = buttons.button(QDialogButtonBox.StandardButton.Open)
        self.load_button.setText("Load")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(14, 14, 14, 14)
        self._column.setSpacing(12)
        seen = QHBoxLayout()
        seen.setSpacing(12)
        seen.addWidget(self.preview)
        seen.addWidget(self.message, 1)
        self._column.addLayout(seen)
        self._column.addStretch(1)
        self._column.addWidget(buttons)

    def source(self, path: str) -> Source:
        """What is to be read of a path; InputError if something beside it is wrong."""
        raise NotImplementedError

    def browse(self) -> None:
        """Ask for a file, and `choose` it."""
        raise NotImplementedError

    def show_found(self, found: Found) -> None:
        """Show what has been read, and say what it is."""
        raise NotImplementedError

    def ask(self, *above: QLayout | QWidget) -> None:
        """Put what is to be chosen above the preview, and begin."""
        for place, part in enumerate(above):
            if isinstance(part, QWidget):
                self._column.insertWidget(place, part)
            else:
                self._column.insertLayout(place, part)
        self.file_button.setFocus()
        self.read()

    def found(self) -> Found:
        """What was read; only to be asked for once it was."""
        if self._found is None:
            raise RuntimeError("nothing has been read")
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
            self.message.say(self._nothing_chosen)
            return
        try:
            self._wanted = self.source(path)
        except InputError as error:
            self.message.say(str(error), "error")
            return
        self.message.say("Reading…")
        self._questions.ask(self._wanted)

    def schedule(self) -> None:
        """Read in a moment: more may be typed until then."""
        self._forget()
        self._delay.start()

    def choose(self, path: str) -> None:
        """Take a path that was browsed to; "" for none."""
        if path:
            QSettings().setValue(self._folder_key, str(Path(path).parent))
            self.path.setText(path)
            self.read()
            self._browsed = True

    def _forget(self) -> None:
        self._wanted = self._found = None
        self._browsed = False
        self._questions.forget()
        self.load_button.setEnabled(False)
        self.preview.show_rgb(None)

    def _take(self, source: Source, found: Found) -> None:
        if source is self._wanted:
            self._found = found
            self.show_found(found)
            self.load_button.setEnabled(True)
            if self._browsed:
                self.load_button.setFocus()

    def _fail(self, source: Source, error: Exception) -> None:
        if source is self._wanted:
            self.message.say(error_text(error).replace(f"{Path(source.path).parent}/", ""), "error")


# Where files go that the user saves.


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
