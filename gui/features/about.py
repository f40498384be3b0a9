"""Commands on the window itself, and the dialog About ILF Studio."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QApplication, QMessageBox, QWidget

from ..base.commands import command
from ..base.versions import versions, versions_text
from ..widgets.basics import open_once
from .context import Feature

_ICON = 64
_TEXT = (
    "<p>Completes the missing depth in RGB-D frames by iterative low-pass filtering.</p><p>After Wang, Yu, Yang, "
    "Huang, Zhu, Lau, Sun: <i>Depth Image Completion through Iterative Low-Pass Filtering</i>, Appl. Sci. 2024, "
    "14(2), 696, "
    '<a href="https://doi.org/10.3390/app14020696">doi:10.3390/app14020696</a>.</p><p>MIT licence.</p>'
)


class AboutDialog(QMessageBox):
    """The dialog with name, purpose, paper and all versions, which a button copies."""

    def __init__(self, parent: QWidget | None = None) -> None:
        known = versions()
        heading = f"<h2>ILF Studio {known.pop('ILF Studio')}</h2>"
        rows = (f"<tr><td>{name}&nbsp;&nbsp;</td><td>{number}</td></tr>" for name, number in known.items())
        text = f"{heading}{_TEXT}<table>{''.join(rows)}</table>"
        super().__init__(QMessageBox.Icon.NoIcon, "About ILF Studio", text, QMessageBox.StandardButton.Close, parent)
        self.setIconPixmap(QApplication.windowIcon().pixmap(_ICON))
        self.setTextInteractionFlags(Qt.TextInteractionFlag.TextBrowserInteraction)
        self.copy_button = self.addButton("&Copy versions", QMessageBox.ButtonRole.ActionRole)
        self.copy_button.setToolTip("Copy all versions, for a bug report")
        self.copy_button.clicked.disconnect()  # it would close the box
        self.copy_button.clicked.connect(lambda: QGuiApplication.clipboard().setText(versions_text()))
        self.setDefaultButton(QMessageBox.StandardButton.Close)


class WindowFeature(Feature):
    """Closes the window, shows it in full screen, hides its panels, and tells what it is."""

    @command("quit", "&Quit", icon="ph.sign-out", keys="Ctrl+Q")
    def _quit(self) -> None:
        self.context.window.close()

    @command("toggle_panels", "S&how or hide all panels", icon="ph.arrows-in-line-horizontal", keys="F9")
    def _toggle_panels(self) -> None:
        """Hide all panels to leave the window to the images, or show them again."""
        self.context.panels.toggle_all()

    @command("about", "&About ILF Studio", icon="ph.info")
    def _show_about(self) -> None:
        open_once(AboutDialog(self.context.window))

    @command("full_screen", "Full screen", icon="ph.corners-out", keys="F11", checkable=True)
    def _show_full_screen(self, on: bool) -> None:
        """Show the window in full screen."""
        window = self.context.window
        (window.showFullScreen if on else window.showNormal)()
