"""Base of dialogs that load one file: the file is read in a worker thread and previewed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt, QTimer
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QHBoxLayout,
    QLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ilf.drawing.colours import robust_depth_levels, to_indices
from ilf.errors import InputError

from ...views.colours import DEPTH_MAP, depth_table
from ...views.drawings import rgb_image
from ...widgets.basics import Message, PlainLabel, answers, lay_out
from ...widgets.notices import error_text
from ...work.latest_request import LatestRequest

# Preview picture of a dialog.

_SIZE = QSize(304, 204)


class PreviewPicture(QFrame):
    """Picture in a box of fixed size, with its name below."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name
        self.picture = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self.picture.setFixedSize(_SIZE)
        self.picture.setFrameShape(QFrame.Shape.StyledPanel)
        self._caption = Message()
        lay_out(QVBoxLayout(self), self.picture, self._caption, spacing=3)
        self.show_rgb(None)

    def show_rgb(self, rgb: NDArray[np.uint8] | None) -> None:
        """Show uint8 (H, W, 3), or nothing."""
        if rgb is None:
            self.picture.clear()
            self._caption.show_message(self._name)
            return
        height, width = rgb.shape[:2]
        self._caption.show_message(f"{self._name}, {width} x {height}")
        self.picture.setPixmap(
            QPixmap.fromImage(rgb_image(rgb)).scaled(
                _SIZE - QSize(4, 4), Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            )
        )

    def show_depth(self, depth: NDArray[np.generic] | None) -> None:
        """Show depth (H, W) in any unit with a colour map, missing pixels black, or nothing."""
        if depth is None:
            self.show_rgb(None)
            return
        values = depth.astype(np.float32)
        values[~(values > 0)] = np.nan
        self.show_rgb(depth_table(DEPTH_MAP)[to_indices(values, *robust_depth_levels(values))][..., :3])


_DELAY_MS = 200


Found = TypeVar("Found")


class PreviewDialog(QDialog, Generic[Found]):
    """Base of dialogs to choose a file, with a preview. *Load* is enabled once the chosen file has been read.

    The focus is on the button *File*, and moves to *Load* after a file was chosen there.

    Parameters
    ----------
    title, placeholder, nothing_selected, shown : str
        Title of the window, placeholder of the path, message while the path is empty, and title of the preview.
    questions : LatestRequest
        Reads files in a worker thread.
    """

    def __init__(
        self,
        title: str,
        placeholder: str,
        nothing_selected: str,
        shown: str,
        questions: LatestRequest,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._nothing_chosen = nothing_selected
        self._questions = questions
        self._found: Found | None = None
        self._delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._delay.timeout.connect(self.read)
        self.path = QLineEdit(placeholderText=placeholder)
        self.path.textChanged.connect(self.schedule)
        self.file_button = QPushButton("File…")
        self.file_button.clicked.connect(lambda _=False: self.browse())
        self._browsed = False
        """Whether the path was chosen in the file dialog, not typed."""
        self.preview = PreviewPicture(shown)
        self.message = Message(lines=5)
        self._buttons, self.load_button = answers(self, QDialogButtonBox.StandardButton.Open, "Load")

    def reader(self, path: str) -> Callable[[], Found]:
        """Return what reads a path, in a worker thread; InputError if another input of the dialog is wrong."""
        raise NotImplementedError

    def browse(self) -> None:
        """Open the file dialog, and `choose` the selected file."""
        raise NotImplementedError

    def show_found(self, found: Found) -> None:
        """Show the content that was read, with a description."""
        raise NotImplementedError

    def ask(self, *above: QLayout | QWidget) -> None:
        """Lay out the inputs above the preview, and start reading."""
        seen = lay_out(QHBoxLayout(), self.preview, self.message, spacing=12, stretched=self.message)
        lay_out(QVBoxLayout(self), *above, seen, None, self._buttons, margins=(14, 14, 14, 14), spacing=12)
        self.file_button.setFocus()
        self.read()

    def found(self) -> Found:
        """Return the content that was read; RuntimeError before that."""
        if self._found is None:
            raise RuntimeError("no file has been read")
        return self._found

    def done(self, result: int) -> None:
        self._delay.stop()
        self._questions.forget()
        super().done(result)

    def read(self) -> None:
        """Read the chosen file and describe it."""
        self._delay.stop()
        self._forget()
        path = self.path.text().strip()
        if not path:
            self.message.show_message(self._nothing_chosen)
            return
        try:
            read = self.reader(path)
        except InputError as error:
            self.message.show_message(str(error), "error")
            return
        self.message.show_message("Reading…")
        self._questions.ask(read, self._take, self._fail)

    def schedule(self) -> None:
        """Read after a short delay, because more may be typed."""
        self._forget()
        self._delay.start()

    def choose(self, path: str) -> None:
        """Set a path from the file dialog; "" for none."""
        if path:
            self.path.setText(path)
            self.read()
            self._browsed = True

    def _forget(self) -> None:
        self._found = None
        self._browsed = False
        self._questions.forget()
        self.load_button.setEnabled(False)
        self.preview.show_rgb(None)

    def _take(self, found: Found) -> None:
        self._found = found
        self.show_found(found)
        self.load_button.setEnabled(True)
        if self._browsed:
            self.load_button.setFocus()

    def _fail(self, error: Exception) -> None:
        folder = Path(self.path.text().strip()).parent
        self.message.show_message(error_text(error).replace(f"{folder}/", ""), "error")
