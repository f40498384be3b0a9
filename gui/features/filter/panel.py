"""The panel of the filter: preset, scope of the parameters, form."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from enum import StrEnum

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QFormLayout, QHBoxLayout, QMenu, QToolButton, QVBoxLayout, QWidget

from ilf.data.parameters import DEFAULT_PRESET, PRESETS, Parameters, nearest_preset

from ...base import theme
from ...widgets.basics import Themed
from ...widgets.parameter_form import ParameterForm

# Which frames share the common parameters: all, or only the current one.


class Sharing(StrEnum):
    """Which frames share the common parameters of the current one."""

    EACH = "Separate for each frame"
    ALL = "All frames"
    ALONE = "This frame only"


_HINTS = {
    Sharing.EACH: "Every frame has its own parameters; a frame that is opened next starts with those of this one",
    Sharing.ALL: "These parameters apply to all frames of the list except those with parameters of their own",
    Sharing.ALONE: "This frame has its own parameters; the others share theirs",
}


class SharingRow(QWidget):
    """Row that shows which frames the parameters apply to, and changes it.

    Parameters
    ----------
    actions : iterable of QAction
        Further commands while a frame has its own parameters.

    Signals
    -------
    chosen(object)
        The user has chosen this `Sharing`.
    """

    chosen = Signal(object)

    def __init__(self, actions: Iterable[QAction]) -> None:
        super().__init__()
        self.box = QComboBox()
        self.box.setAccessibleName("Frames that the parameters apply to")
        for number, sharing in enumerate(Sharing):
            self.box.addItem(sharing.value, sharing)
            self.box.setItemData(number, _HINTS[sharing], Qt.ItemDataRole.ToolTipRole)
        self.box.activated.connect(lambda _: self.chosen.emit(Sharing(self.box.currentData())))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        row.addWidget(self.box, 1)
        self._buttons = []
        for action in actions:
            button = QToolButton(autoRaise=True)
            button.setDefaultAction(action)
            row.addWidget(button)
            self._buttons.append(button)
        self.show_sharing(Sharing.EACH)

    def show_sharing(self, sharing: Sharing) -> None:
        """Show which frames the parameters apply to."""
        self.box.setCurrentIndex(self.box.findData(sharing))
        self.box.setToolTip(_HINTS[sharing])
        model = self.box.model()
        if isinstance(model, QStandardItemModel):
            model.item(self.box.findData(Sharing.ALONE)).setEnabled(sharing is not Sharing.EACH)
        for button in self._buttons:
            button.setVisible(sharing is Sharing.ALONE)


# The list of presets: built-in ones and the user's, with the commands on the latter.

_ABOUT = "best: adapts to edges and noise. paper: as described in the paper. released-code: as in the authors' program."


class PresetBox(Themed, QWidget):
    """List that shows the preset of some parameters, or the preset they are based on, and selects another.

    Signals
    -------
    chosen(str)
        Name of the preset that the user has selected.
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
        """Show these commands on the user's presets in the menu."""
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
        """List these presets of the user beside the built-in ones."""
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
        self.names.setToolTip(_ABOUT + (" Below the line: your own presets." if own else ""))

    def show_parameters(self, parameters: Parameters, base: str) -> str:
        """Show the preset of these parameters, or else `base` as changed; return the name of the preset."""
        known = {**PRESETS, **self._own}
        base = base if base in known else nearest_preset(parameters, known).preset
        # of presets with the same values, the selected one
        same = [name for name, values in known.items() if values == parameters]
        shown = base if base in same or not same else same[0]
        for name in known:
            text = f"{name} (changed)" if name == shown and not same else name
            self.names.setItemText(self.names.findData(name), text)
        self.names.setCurrentIndex(self.names.findData(shown))
        return shown

    def _take_theme(self) -> None:
        if hasattr(self, "menu_button"):
            self._style()

    def _style(self) -> None:
        self.menu_button.setIcon(theme.icon("ph.dots-three-vertical", self.palette()))


class FilterPanel(QWidget):
    """Panel with the parameters of all blocks or of the selected ones.

    Signals
    -------
    edited(object)
        The user has edited the Parameters.
    preset_chosen(object)
        The user has selected a preset with these Parameters.
    scope_changed()
        The user has switched between the parameters of all blocks and those of the selected ones.
    """

    edited = Signal(object)
    preset_chosen = Signal(object)
    scope_changed = Signal()

    def __init__(
        self,
        own_actions: list[QAction],
        frame_actions: Sequence[QAction] = (),
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.presets = PresetBox()
        self._bases = {False: DEFAULT_PRESET, True: DEFAULT_PRESET}  # by for_selected
        self.presets.chosen.connect(self._choose_preset)
        self._scope = QComboBox()
        self._scope.addItems(["All blocks", "Selected blocks"])
        self._scope.setAccessibleName("Parameters for")
        self._scope.setToolTip("Whether the parameters below apply to all blocks, or to the selected ones only")
        self._scope.activated.connect(self.scope_changed)
        self.form = ParameterForm(Parameters)
        self.form.changed.connect(self.edited)

        choices = QFormLayout()
        choices.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        choices.addRow("Preset", self.presets)
        scope = QHBoxLayout()
        scope.setSpacing(2)
        scope.addWidget(self._scope, 1)
        self._own_buttons = [QToolButton(autoRaise=True) for _ in own_actions]
        for button, action in zip(self._own_buttons, own_actions, strict=True):
            button.setDefaultAction(action)
            scope.addWidget(button)
        choices.addRow("Parameters for", scope)
        choices.setRowVisible(scope, False)
        self._choices, self._scope_row = choices, scope
        self.frames = SharingRow(frame_actions)
        choices.addRow("Frames", self.frames)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 4, 4)
        layout.addLayout(choices)
        layout.addWidget(self.form, 1)

    def show_frames(self, several: bool) -> None:
        """Show which frames the parameters apply to, if there are several."""
        self._choices.setRowVisible(self.frames, several)

    @property
    def for_selected(self) -> bool:
        """Whether the parameters are those of the selected blocks."""
        return self._scope.currentIndex() == 1

    def set_scope(self, chosen: bool) -> None:
        """Show the parameters of the selected blocks, or of all."""
        self._scope.setCurrentIndex(int(chosen))
        self.scope_changed.emit()

    def show_parameters(
        self, parameters: Parameters, common: Parameters, chosen: Sequence[str], of_all: Parameters | None = None
    ) -> None:
        """Show parameters, those of the selected blocks relative to the common ones; `chosen` are the names of the
        selected blocks.

        With `of_all`, the common parameters are this frame's own, and are shown relative to those of all frames.
        """
        model = self._scope.model()
        if isinstance(model, QStandardItemModel):
            model.item(1).setEnabled(bool(chosen))
        self._choices.setRowVisible(self._scope_row, bool(chosen))
        names = {0: "Selected blocks", 1: f"{chosen[0]} only" if chosen else ""}
        self._scope.setItemText(1, names.get(len(chosen), f"{len(chosen)} selected blocks"))
        if not chosen:
            self._scope.setCurrentIndex(0)
        scope = self.for_selected
        for button in self._own_buttons:
            button.setVisible(scope)
        self._bases[scope] = self.presets.show_parameters(parameters, self._bases[scope])
        if scope:
            self.form.set_base(common, "all blocks")
        elif of_all is not None:
            self.form.set_base(of_all, "all frames")
        else:
            self.form.set_base(self.presets.parameters(self._bases[scope]))
        self.form.set_parameters(parameters)

    def set_base_preset(self, name: str) -> None:
        """Set the preset that the shown parameters are based on."""
        self._bases[self.for_selected] = name

    def _choose_preset(self, name: str) -> None:
        self.set_base_preset(name)
        self.preset_chosen.emit(self.presets.parameters(name))
