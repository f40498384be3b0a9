"""A word in the status bar as long as the work cannot be saved by itself."""

from __future__ import annotations

import html

from PySide6.QtCore import QEvent
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QWidget

from gui import theme
from gui.widgets.plain_text import PlainLabel

MEANING = (
    "What you do is kept in memory only, until this works again, which is tried every few seconds. Save the project to "
    "be safe."
)


class UnkeptLabel(PlainLabel):
    """To be seen while there is something to say."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Not autosaved", parent)
        self.setAccessibleName("State of the autosave")
        self._paint()
        self.hide()

    def say(self, why: str) -> None:
        """The reason, in a sentence; "" when all is well again."""
        self.setVisible(bool(why))
        self.setToolTip(f"<p>{html.escape(why)}</p><p>{MEANING}</p>")
        self.setAccessibleDescription(why)

    def changeEvent(self, event: QEvent) -> None:
        """Keep the colour, in any theme."""
        super().changeEvent(event)
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange):
            self._paint()

    def _paint(self) -> None:
        palette = QPalette()
        palette.setColor(QPalette.ColorRole.WindowText, theme.colours(palette).warning)
        self.setPalette(palette)
