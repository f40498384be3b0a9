"""The splash screen, shown while the window is imported and made."""

from __future__ import annotations

import time

from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QPainter, QPixmap
from PySide6.QtWidgets import QApplication, QLabel, QWidget

from ilf._runtime.installation import __version__

from ..base import theme

_WIDTH, _HEIGHT, _ICON, _MARGIN = 360, 120, 72, 24
_PATIENCE_S = 0.3
"""How long the system may take to show it."""


def show_splash(app: QApplication) -> QWidget:
    """Show the splash screen at once: nothing can be drawn while modules are imported.

    A label, not a `QSplashScreen`, which waits for a second until it is mapped under some systems.
    """
    splash = QLabel()
    splash.setWindowFlags(Qt.WindowType.SplashScreen | Qt.WindowType.FramelessWindowHint)
    splash.setPixmap(_picture(app))
    splash.adjustSize()
    splash.move(splash.screen().availableGeometry().center() - splash.rect().center())
    splash.show()
    until = time.monotonic() + _PATIENCE_S
    app.processEvents()
    while not splash.windowHandle().isExposed() and time.monotonic() < until:
        time.sleep(0.005)
        app.processEvents()
    return splash


def _picture(app: QApplication) -> QPixmap:
    """Draw icon, name and version in the colours of the theme."""
    colours, ratio = theme.colours(app.palette()), app.devicePixelRatio()
    picture = QPixmap(round(_WIDTH * ratio), round(_HEIGHT * ratio))
    picture.setDevicePixelRatio(ratio)
    picture.fill(colours.panel)
    painter = QPainter(picture)
    app.windowIcon().paint(painter, QRect(_MARGIN, (_HEIGHT - _ICON) // 2, _ICON, _ICON))
    left, font = 2 * _MARGIN + _ICON, app.font()
    painter.setPen(colours.muted)
    painter.drawText(QRect(left, _HEIGHT // 2, _WIDTH - left, 30), f"{__version__}   Starting…")
    font.setPointSizeF(1.8 * font.pointSizeF())
    painter.setFont(font)
    painter.setPen(colours.text)
    painter.drawText(QRect(left, 0, _WIDTH - left, _HEIGHT // 2), Qt.AlignmentFlag.AlignBottom, "ILF Studio")
    painter.setPen(colours.grid)
    painter.drawRect(0, 0, _WIDTH - 1, _HEIGHT - 1)
    painter.end()
    return picture
