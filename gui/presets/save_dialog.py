"""The dialog that keeps values as a preset of one's own."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox, QDialog, QDialogButtonBox, QLineEdit, QVBoxLayout, QWidget

from gui.widgets.plain_text import PlainLabel


class SavePresetDialog(QDialog):
    """Name, and whether the extraction's values belong to it."""

    def __init__(self, proposed: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save Preset")
        self.name = QLineEdit(proposed)
        self.name.setToolTip("What the preset is called in the box of presets, and by --preset")
        self.name.selectAll()
        self.with_extraction = QCheckBox("With the values of the tab &Extraction")
        self.with_extraction.setToolTip("Choosing the preset then sets what blocks are extracted with, too")
        label = PlainLabel("&Name")
        label.setBuddy(self.name)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel)
        self.save_button = buttons.button(QDialogButtonBox.StandardButton.Save)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self.name.textChanged.connect(self._allow)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(8)
        for widget in (label, self.name, self.with_extraction, buttons):
            layout.addWidget(widget)
        self.setMinimumWidth(340)
        self._allow()

    def _allow(self) -> None:
        self.save_button.setEnabled(bool(self.name.text().strip()))
