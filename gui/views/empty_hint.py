"""What the views show while no frame is open."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QVBoxLayout, QWidget

from gui import theme
from gui.widgets.plain_text import PlainLabel

_HINT = (
    "Drop a colour and a depth file, a folder of frames, a recording or a project here, or open one by the menu File, "
    "which has a sample, too"
)


class EmptyHint(QWidget):
    """What to do while no frame is open."""

    def __init__(self) -> None:
        super().__init__()
        self._picture = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        self._text = PlainLabel(_HINT, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(24, 24, 24, 24)
        layout.setSpacing(12)
        layout.addStretch()
        layout.addWidget(self._picture)
        layout.addWidget(self._text)
        layout.addStretch()

    def set_colours(self, colours: theme.Colours) -> None:
        """Take the colours of the theme."""
        # a style sheet, because the application's replaces palettes of single widgets
        self._text.setStyleSheet(f"color: {colours.muted.name()};")
        palette = QPalette(self.palette())
        palette.setColor(QPalette.ColorRole.WindowText, colours.muted)
        self._picture.setPixmap(theme.icon("ph.image", palette).pixmap(QSize(48, 48)))
