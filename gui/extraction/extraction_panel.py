"""The panel of EBS: its parameters, their preview, and the button that extracts blocks again."""

from __future__ import annotations

import html

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from gui import theme
from gui.widgets.parameter_form import ParameterForm
from ilf.parameters import BlockParameters


class ExtractionPanel(QWidget):
    """Form of the extraction's parameters, and what is to be done with them.

    Signals
    -------
    edited(object)
        The user set other BlockParameters.
    preview_switched(bool)
        The user switched the preview on or off.
    keeping_switched(bool)
        The user wants blocks made by hand to stay, or not.
    view_wished()
        The user followed `offer_view` and wants to see what the values give.
    """

    edited = Signal(object)
    preview_switched = Signal(bool)
    keeping_switched = Signal(bool)
    view_wished = Signal()

    def __init__(self, extract: QAction, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        button = QToolButton()
        button.setDefaultAction(extract)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._preview = QCheckBox("Preview")
        self._preview.setChecked(True)
        self._preview.setToolTip("The view of the extraction follows the values below; the frame's blocks do not")
        self._preview.clicked.connect(self.preview_switched)
        self._keep = QCheckBox("Keep blocks made by hand")
        self._keep.setChecked(True)
        self._keep.setToolTip(
            "When blocks are extracted again, those that you made, enlarged, merged or erased from stay as they are, "
            "as locked ones do"
        )
        self._keep.clicked.connect(self.keeping_switched)
        self._summary = QLabel()
        self._summary.setObjectName("summary")
        self._summary.setWordWrap(True)
        self._summary.linkActivated.connect(lambda _: self.view_wished.emit())
        self._summary.hide()
        self._text = self._warning = self._layout = ""
        self.form = ParameterForm(BlockParameters)
        self.form.set_base(BlockParameters())
        self.form.changed.connect(self.edited)
        row = QHBoxLayout()
        row.setSpacing(10)
        row.addWidget(button)
        row.addWidget(self._preview)
        row.addStretch()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 4, 4)
        layout.addLayout(row)
        layout.addWidget(self._keep)
        layout.addWidget(self._summary)
        layout.addWidget(self.form, 1)

    @property
    def previews(self) -> bool:
        """Whether the view of the extraction is to follow the values."""
        return self._preview.isChecked()

    def show_summary(self, text: str, warning: str = "") -> None:
        """Say what the values give, and what should be known of it."""
        self._text, self._warning, self._layout = text, warning, ""
        self._write()

    def offer_view(self, layout: str) -> None:
        """Say in which layout there is to be seen what the values give, with a link to it."""
        self._text, self._warning, self._layout = "", "", layout
        self._write()

    def _write(self) -> None:
        colours = theme.colours(self.palette())
        pairs = ((self._text, colours.muted), (self._warning, colours.warning))
        # not by palette, which a new application style sheet would take away
        lines = [f'<span style="color: {tone.name()}">{html.escape(text)}</span>' for text, tone in pairs if text]
        if self._layout:
            link = f'<a href="view" style="color: {colours.accent.name()}">{html.escape(self._layout)}</a>'
            text = f"Choose the layout {link} to see what these values give."
            lines.append(f'<span style="color: {colours.muted.name()}">{text}</span>')
        self._summary.setText("<br>".join(lines))
        self._summary.setVisible(bool(lines))

    def changeEvent(self, event: QEvent) -> None:
        """Take the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "form"):
            self._write()
