"""What dialogs share that load one file: it is read off the GUI's thread, and shown before it is taken."""

from __future__ import annotations

from pathlib import Path
from typing import Generic, Protocol, TypeVar

from PySide6.QtCore import QSettings, QTimer
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from gui.dialogs.preview import Preview
from gui.widgets.messages import Message
from gui.widgets.problems import error_text
from gui.work.latest_question import LatestQuestion
from ilf.errors import InputError

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
