"""The splash screen, shown while the window is imported and made."""

from __future__ import annotations

import time

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFrame, QHBoxLayout, QLabel, QWidget

from ilf._runtime.installation import __version__

from ..base import theme
from ..widgets.basics import lay_out

_ICON, _MARGIN = 72, 24
_PATIENCE_S = 0.3
"""How long the system may take to show it."""


def show_splash(app: QApplication) -> QWidget:
    """Show the splash screen at once: nothing can be drawn while modules are imported.

    A frame, not a `QSplashScreen`, which waits for a second until it is mapped under some systems.
    """
    splash = QFrame(frameShape=QFrame.Shape.Box)
    splash.setWindowFlags(Qt.WindowType.SplashScreen | Qt.WindowType.FramelessWindowHint)
    icon, muted = QLabel(), theme.colours(app.palette()).muted.name()
    icon.setPixmap(app.windowIcon().pixmap(_ICON))
    text = QLabel(f"<h1>ILF Studio</h1><span style='color: {muted}'>{__version__}&nbsp;&nbsp; Starting…</span>")
    lay_out(QHBoxLayout(splash), icon, text, margins=(_MARGIN, _MARGIN, _MARGIN, _MARGIN), spacing=_MARGIN)
    splash.adjustSize()
    splash.move(splash.screen().availableGeometry().center() - splash.rect().center())
    splash.show()
    until = time.monotonic() + _PATIENCE_S
    app.processEvents()
    while not splash.windowHandle().isExposed() and time.monotonic() < until:
        time.sleep(0.005)
        app.processEvents()
    return splash
