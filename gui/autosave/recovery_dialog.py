"""The dialog that offers work which a window has left behind at a sudden end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel

_PICTURE = 160
_MOST_ROWS_SHOWN = 3
_ABOUT = (
    "ILF Studio came to a sudden end, or the machine did. This is the work that is in no project file yet. Nothing of "
    "it is lost until you discard it."
)
_ADDED = "This window has a project: the frames that are restored now are added to it."


@dataclass(frozen=True)
class OfferedWork:
    """What there is to say of left work.

    Attributes
    ----------
    name : str
        Of its project, or of its frames.
    changed : datetime or None
        When it was changed last.
    details : tuple of str
        What it is, a line each.
    picture : bytes or None
        A JPEG image.
    problem : str
        Why it cannot be restored; "" if it can.
    """

    name: str
    changed: datetime | None
    details: tuple[str, ...]
    picture: bytes | None = None
    problem: str = ""


class RecoveryDialog(QDialog):
    """Left work, a row each, to be restored, discarded, or left for another time.

    Signals
    -------
    restore_wished(int), discard_wished(int)
        The number of the work.
    """

    restore_wished = Signal(int)
    discard_wished = Signal(int)

    def __init__(self, works: Sequence[OfferedWork], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Restore Unsaved Work")
        about = Message(lines=2)
        about.say(_ABOUT, "text")
        self.added = Message()
        self.rows = {number: _Row(work) for number, work in enumerate(works)}
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        for number, row in self.rows.items():
            row.restore_button.clicked.connect(lambda _=False, number=number: self._restore(number))
            row.discard_button.clicked.connect(lambda _=False, number=number: self.discard_wished.emit(number))
            row.later_button.clicked.connect(lambda _=False, number=number: self.remove(number))
            row.later_button.setVisible(len(works) > 1)  # the dialog's own says the same of all
            column.addWidget(row)
        column.addStretch(1)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setWidget(inside)
        shown = list(self.rows.values())[:_MOST_ROWS_SHOWN]
        area.setMinimumHeight(sum(row.sizeHint().height() + 8 for row in shown))
        buttons = QDialogButtonBox()
        later = buttons.addButton("Decide &later", QDialogButtonBox.ButtonRole.RejectRole)
        later.setToolTip("Close this, and offer all that is left here again at the next start")
        buttons.rejected.connect(self.reject)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(14, 14, 14, 14)
        outer.setSpacing(10)
        outer.addWidget(about)
        outer.addWidget(self.added)
        outer.addWidget(area, 1)
        outer.addWidget(buttons)
        self.setMinimumWidth(600)
        self.say_added(False)

    def say_added(self, on: bool) -> None:
        """Say whether what is restored is added to what is there."""
        self.added.setVisible(on)
        self.added.say(_ADDED if on else "")

    def remove(self, number: int) -> None:
        """It has been restored or discarded, or is not wanted now."""
        row = self.rows.pop(number, None)
        if row is not None:
            row.hide()
            row.deleteLater()
        if not self.rows:
            self.accept()

    def _restore(self, number: int) -> None:
        for row in self.rows.values():
            row.wait(row is self.rows[number])
        self.restore_wished.emit(number)

    def go_on(self) -> None:
        """What was to be restored is: the others can be."""
        for row in self.rows.values():
            row.go_on()


class _Row(QFrame):
    """One piece of work."""

    def __init__(self, work: OfferedWork) -> None:
        super().__init__()
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self._problem = work.problem
        picture = PlainLabel()
        picture.setAlignment(Qt.AlignmentFlag.AlignCenter)
        picture.setFixedWidth(_PICTURE)
        picture.setAccessibleName(f"Picture of {work.name}")
        pixels = QPixmap()
        if work.picture is not None and pixels.loadFromData(work.picture):
            mode = Qt.TransformationMode.SmoothTransformation
            picture.setPixmap(pixels.scaled(_PICTURE, _PICTURE, Qt.AspectRatioMode.KeepAspectRatio, mode))
        else:
            picture.setText("No picture")
            picture.setEnabled(False)
        name = PlainLabel(work.name)
        name.setTextFormat(Qt.TextFormat.PlainText)
        name.setWordWrap(True)
        bold = name.font()
        bold.setBold(True)
        name.setFont(bold)
        when, what = Message(), Message()
        when.say("" if work.changed is None else f"Last change {when_in_words(work.changed)}", "muted")
        what.say(work.problem or "\n".join(work.details), "error" if work.problem else "text")
        self.restore_button = QPushButton("Restore", autoDefault=False)
        self.restore_button.setToolTip("Open it as it was left; save it then as a project")
        self.discard_button = QPushButton("Discard…", autoDefault=False)
        self.discard_button.setToolTip("Delete this work for good")
        self.later_button = QPushButton("Later", autoDefault=False)
        self.later_button.setToolTip("Leave it where it is: it is offered again at the next start")
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        for button in (self.restore_button, self.discard_button, self.later_button):
            button.setAccessibleName(f"{button.text().rstrip('…')} {work.name}")
            buttons.addWidget(button)
        grid = QGridLayout(self)
        grid.setColumnStretch(1, 1)
        grid.setHorizontalSpacing(12)
        grid.addWidget(picture, 0, 0, 4, 1)
        for line, widget in enumerate((name, when, what)):
            grid.addWidget(widget, line, 1)
        grid.setRowStretch(2, 1)
        grid.addLayout(buttons, 3, 1)
        self.go_on()

    def wait(self, is_this: bool) -> None:
        """Something is being restored."""
        for button in (self.restore_button, self.discard_button, self.later_button):
            button.setEnabled(False)
        if is_this:
            self.restore_button.setText("Restoring…")

    def go_on(self) -> None:
        """Nothing is being restored any more."""
        self.restore_button.setText("Restore")
        self.restore_button.setEnabled(not self._problem)
        self.discard_button.setEnabled(True)
        self.later_button.setEnabled(True)


def when_in_words(moment: datetime, now: datetime | None = None) -> str:
    """How long ago, and when.

    Examples
    --------
    >>> noon = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
    >>> when_in_words(noon, noon.replace(minute=5)).split(",")[0]
    '5 minutes ago'
    """
    passed = ((now or datetime.now(UTC)) - moment).total_seconds()
    for seconds, unit in ((86400, "day"), (3600, "hour"), (60, "minute")):
        count = int(passed // seconds)
        if count:
            ago = f"{count} {unit}{'s' * (count != 1)} ago"
            break
    else:
        ago = "just now"
    return f"{ago}, {moment.astimezone():%d %B %Y at %H:%M:%S}"
