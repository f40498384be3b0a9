"""The panel of EBS: its parameters, and the button that extracts blocks again."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolButton, QVBoxLayout, QWidget

from gui.panels.parameter_form import ParameterForm
from ilf.parameters import BlockParameters


class ExtractionPanel(QWidget):
    """Form of the extraction's parameters.

    Signals
    -------
    edited(object)
        The user set other BlockParameters.
    """

    edited = Signal(object)

    def __init__(self, extract: QAction, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        button = QToolButton()
        button.setDefaultAction(extract)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.form = ParameterForm(BlockParameters)
        self.form.set_base(BlockParameters())
        self.form.changed.connect(self.edited)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 4, 4)
        layout.addWidget(button)
        layout.addWidget(self.form, 1)
        layout.setAlignment(button, Qt.AlignmentFlag.AlignLeft)
