"""Base of dialogs that choose files: what is chosen is read and shown before it is taken."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

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
from ilf.errors import IlfError

from ...views.colours import DEPTH_MAP, depth_table
from ...views.drawings import rgb_image
from ...widgets.basics import Message, PlainLabel, answers, lay_out
from ...widgets.notices import error_text
from ...work.latest_request import LatestRequest
from .frame_files import Look

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


class PreviewDialog(QDialog):
    """Base of dialogs to choose files: what is chosen is read, described and shown; then it can be taken.

    Parameters
    ----------
    title, placeholder : str
        Title of the window, and placeholder of the path.
    pictures : (str, str)
        Names of the pictures of colour and depth; "" for none.
    accept : str
        Text of the button that takes the choice; "" for *Open*.
    questions : LatestRequest
        Reads files in a worker thread.
    """

    meanwhile = Look("Reading…", "muted", can_be_opened=False)
    """What is shown while a worker reads."""

    def __init__(
        self,
        title: str,
        placeholder: str,
        pictures: tuple[str, str],
        accept: str,
        questions: LatestRequest,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self._questions = questions
        self.seen = self.meanwhile
        """What is seen of the choice."""
        self._delay = QTimer(self, singleShot=True, interval=_DELAY_MS)
        self._delay.timeout.connect(self.read)
        self.path = QLineEdit(placeholderText=placeholder)
        self.previews = self.colour_preview, self.depth_preview = (
            PreviewPicture(pictures[0]),
            PreviewPicture(pictures[1]),
        )
        for name, preview in zip(pictures, self.previews, strict=True):
            if not name:
                preview.hide()
        self.message = Message(lines=5)
        self.buttons, self.accept_button = answers(self, QDialogButtonBox.StandardButton.Open, accept)

    def look(self) -> Look | Callable[[], Look]:
        """Return what is seen of the choice, or what finds it in a worker thread; raises IlfError if it cannot be
        read."""
        raise NotImplementedError

    def files(self) -> Sequence[str]:
        """Return the chosen paths."""
        return (self.path.text().strip(),)

    def refused(self, text: str, tone: str) -> Look:
        """Return what is seen of a choice that cannot be taken."""
        return Look(text, tone, can_be_opened=False)

    def ask(self, *above: QLayout | QWidget) -> None:
        """Lay out the inputs above the preview, and start reading."""
        self.path.textChanged.connect(self.schedule)
        seen = lay_out(QHBoxLayout(), *self.previews, self.message, spacing=12, stretched=self.message)
        lay_out(QVBoxLayout(self), *above, seen, None, self.buttons, margins=(14, 14, 14, 14), spacing=12)
        self.read()

    def browse_button(self, text: str, choose: Callable[[], str], take: Callable[[str], object]) -> QPushButton:
        """Return a button that asks for a path, and takes it."""

        def browse() -> None:
            if path := choose():
                take(path)
                self.path.setFocus()  # Enter takes the choice

        button = QPushButton(text)
        button.clicked.connect(browse)
        return button

    def choose(self, path: str) -> None:
        """Set the path, and read it."""
        self.path.setText(path)
        self.read()

    def done(self, result: int) -> None:
        self._delay.stop()
        self._questions.forget()
        super().done(result)

    def schedule(self) -> None:
        """Read after a short delay, because more may be typed."""
        self.accept_button.setEnabled(False)
        self._delay.start()

    def read(self) -> None:
        """Read the choice, and show what is seen of it."""
        self._delay.stop()
        self._questions.forget()
        try:
            seen = self.look()
        except IlfError as error:
            self.fail(error)
            return
        if isinstance(seen, Look):
            self.show_look(seen)
        else:
            self.show_look(self.meanwhile)
            self._questions.ask(seen, self.show_look, self.fail)

    def fail(self, error: Exception) -> None:
        """Say why the choice cannot be taken, without the folders of its files."""
        text = error_text(error)
        for folder in {str(Path(file).parent) for file in self.files()} - {"."}:
            text = text.replace(f"{folder}/", "")
        self.show_look(self.refused(text, "error"))

    def show_look(self, look: Look) -> None:
        """Show what is seen of the choice."""
        self.seen = look
        self.colour_preview.show_rgb(look.colour)
        self.depth_preview.show_depth(look.depth)
        self.message.show_message(look.text, look.tone)
        self.accept_button.setEnabled(look.can_be_opened)
