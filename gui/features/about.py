"""Commands on the window itself, and the dialog About ILF Studio."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QApplication,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ..base.commands import command
from ..base.versions import versions, versions_text
from ..widgets.basics import lay_out, open_once
from .context import Feature

_ICON = 64
_TEXT = (
    "<p>Completes the missing depth in RGB-D frames by iterative low-pass filtering.</p><p>After Wang, Yu, Yang, "
    "Huang, Zhu, Lau, Sun: <i>Depth Image Completion through Iterative Low-Pass Filtering</i>, Appl. Sci. 2024, "
    "14(2), 696, "
    '<a href="https://doi.org/10.3390/app14020696">doi:10.3390/app14020696</a>.</p><p>MIT licence.</p>'
)


class AboutDialog(QDialog):
    """The dialog with name, purpose, paper and all versions, which a button copies."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("About ILF Studio")
        known = versions()
        icon = QLabel()
        icon.setPixmap(QApplication.windowIcon().pixmap(_ICON))
        about = QLabel(f"<h2>ILF Studio {known['ILF Studio']}</h2>{_TEXT}")
        about.setWordWrap(True)
        about.setOpenExternalLinks(True)
        about.setMinimumWidth(360)
        numbers = QFormLayout()
        numbers.setHorizontalSpacing(14)
        numbers.setVerticalSpacing(3)
        for name, number in list(known.items())[1:]:
            value = QLabel(number)
            value.setWordWrap(True)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            numbers.addRow(name, value)
        column = QVBoxLayout()
        column.addWidget(about)
        column.addSpacing(6)
        column.addLayout(numbers)
        icon.setAlignment(Qt.AlignmentFlag.AlignTop)
        row = lay_out(QHBoxLayout(), icon, column, spacing=16, stretched=column)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        self.copy_button = QPushButton("&Copy versions")
        self.copy_button.setToolTip("Copy all versions, for a bug report")
        self.copy_button.clicked.connect(lambda: QGuiApplication.clipboard().setText(versions_text()))
        buttons.addButton(self.copy_button, QDialogButtonBox.ButtonRole.ActionRole)
        buttons.button(QDialogButtonBox.StandardButton.Close).setDefault(True)
        lay_out(QVBoxLayout(self), row, buttons, margins=(18, 18, 18, 14), spacing=14)


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

    @command("full_screen", "F&ull screen", icon="ph.corners-out", keys="F11", checkable=True)
    def _show_full_screen(self, on: bool) -> None:
        """Show the window in full screen."""
        window = self.context.window
        (window.showFullScreen if on else window.showNormal)()
