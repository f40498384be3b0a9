"""The choice of a preset: the built-in ones, those of the user, and what can be done with these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QEvent, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QMenu, QToolButton, QWidget

from gui import theme
from ilf.parameters import DEFAULT_PRESET, PRESETS, Parameters
from ilf.preset_words import likeness

_ABOUT = (
    "best: follows edges and noise. paper: as the text describes it. released-code: as the authors' program does it."
)


class PresetBox(QWidget):
    """Says which preset some parameters are, or come from, and chooses another.

    Signals
    -------
    chosen(str)
        Name of the preset that the user chose.
    """

    chosen = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._own: dict[str, Parameters] = {}
        self.names = QComboBox()
        self.names.setAccessibleName("Preset")
        self.names.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.names.activated.connect(lambda _: self.chosen.emit(self.present))
        self.menu_button = QToolButton(autoRaise=True)
        self.menu_button.setAccessibleName("Own presets")
        self.menu_button.setToolTip("Save, rename, delete, import or export presets of your own")
        self.menu_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.menu_button.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        self.menu_button.hide()
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        row.addWidget(self.names, 1)
        row.addWidget(self.menu_button)
        self.set_own({})
        self._style()

    def set_commands(self, commands: Sequence[QAction]) -> None:
        """Offer what can be done with presets of one's own."""
        menu = QMenu(self.menu_button)
        menu.addActions(list(commands))
        self.menu_button.setMenu(menu)
        self.menu_button.show()

    @property
    def present(self) -> str:
        """Name of the preset that shows."""
        return str(self.names.currentData())

    def parameters(self, name: str) -> Parameters:
        """The values of a preset, built in or one's own; of the default preset if there is none of that name."""
        return {**self._own, **PRESETS}.get(name, PRESETS[DEFAULT_PRESET])

    def set_own(self, own: Mapping[str, Parameters]) -> None:
        """Offer these presets of the user beside the built-in ones."""
        present = self.names.currentData()
        self._own = dict(own)
        self.names.clear()
        for name in PRESETS:
            self.names.addItem(name, name)
        if own:
            self.names.insertSeparator(len(PRESETS))
        for name in own:
            self.names.addItem(name, name)
        self.names.setCurrentIndex(max(self.names.findData(present), 0))
        self.names.setToolTip(_ABOUT + (" Below the line: your own." if own else ""))

    def show_parameters(self, parameters: Parameters, base: str) -> str:
        """Show which preset these are, or else that they are `base`, changed; the preset's name is returned."""
        known = {**PRESETS, **self._own}
        base = base if base in known else likeness(parameters, known).preset
        # of presets with the same values, the one that was chosen
        same = [name for name, values in known.items() if values == parameters]
        shown = base if base in same or not same else same[0]
        for name in known:
            text = f"{name} (changed)" if name == shown and not same else name
            self.names.setItemText(self.names.findData(name), text)
        self.names.setCurrentIndex(self.names.findData(shown))
        return shown

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "menu_button"):
            self._style()

    def _style(self) -> None:
        self.menu_button.setIcon(theme.icon("ph.dots-three-vertical", self.palette()))
