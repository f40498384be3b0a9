"""What an empty list says instead of nothing."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QAbstractItemView

from gui import theme


def paint_hint(view: QAbstractItemView, text: str) -> None:
    """Paint `text` in the middle of a view's empty viewport; call it from the view's paintEvent."""
    painter = QPainter(view.viewport())
    painter.setPen(theme.colours(view.palette()).muted)
    area = view.viewport().rect().adjusted(16, 8, -16, -8)
    painter.drawText(area, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, text)
    painter.end()
