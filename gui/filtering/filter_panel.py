"""The filter's panel: preset, whose parameters are shown, the form, the run buttons."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QFormLayout, QHBoxLayout, QToolButton, QVBoxLayout, QWidget

from gui.filtering.frames_row import FramesRow
from gui.filtering.preset_box import PresetBox
from gui.widgets.parameter_form import ParameterForm
from ilf.parameters import DEFAULT_PRESET, Parameters


class FilterPanel(QWidget):
    """Parameters of all blocks or of the chosen ones.

    Signals
    -------
    edited(object)
        The user set other Parameters, one by one.
    preset_chosen(object)
        The user chose a preset's Parameters.
    scope_changed()
        The user asked for the parameters of all blocks or of the chosen ones.
    """

    edited = Signal(object)
    preset_chosen = Signal(object)
    scope_changed = Signal()

    def __init__(
        self,
        run_actions: list[QAction],
        own_actions: list[QAction],
        frame_actions: Sequence[QAction] = (),
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.presets = PresetBox()
        self._bases = {False: DEFAULT_PRESET, True: DEFAULT_PRESET}  # by for_chosen
        self.presets.chosen.connect(self._choose_preset)
        self._scope = QComboBox()
        self._scope.addItems(["All blocks", "Chosen blocks"])
        self._scope.setAccessibleName("Values for")
        self._scope.setToolTip("Whether the values below go for all blocks, or for the chosen ones alone")
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
        choices.addRow("Values for", scope)
        self.frames = FramesRow(frame_actions)
        choices.addRow("Frames", self.frames)
        buttons = QHBoxLayout()
        buttons.setSpacing(4)
        for action in run_actions:
            button = QToolButton()
            button.setDefaultAction(action)
            if action is run_actions[0]:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            else:
                button.setAutoRaise(True)  # else one cannot see which are switched on
            buttons.addWidget(button)
        buttons.addStretch()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 4, 4)
        layout.addLayout(buttons)
        layout.addLayout(choices)
        layout.addWidget(self.form, 1)

    @property
    def for_chosen(self) -> bool:
        """Whether the values are those of the chosen blocks."""
        return self._scope.currentIndex() == 1

    def set_scope(self, chosen: bool) -> None:
        """Show the values of the chosen blocks, or of all."""
        self._scope.setCurrentIndex(int(chosen))
        self.scope_changed.emit()

    def show_parameters(
        self, parameters: Parameters, common: Parameters, chosen: Sequence[str], of_all: Parameters | None = None
    ) -> None:
        """Show values, those of the chosen blocks against the common ones; `chosen` are the chosen blocks' names.

        With `of_all`, the common values are this frame's own, and are shown against those of all frames.
        """
        model = self._scope.model()
        if isinstance(model, QStandardItemModel):
            model.item(1).setEnabled(bool(chosen))
        names = {0: "Chosen blocks", 1: f"{chosen[0]} only" if chosen else ""}
        self._scope.setItemText(1, names.get(len(chosen), f"{len(chosen)} chosen blocks"))
        if not chosen:
            self._scope.setCurrentIndex(0)
        scope = self.for_chosen
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

    def note_base(self, name: str) -> None:
        """The values that show are those of this preset from now on, as it has just got them or its name."""
        self._bases[self.for_chosen] = name

    def _choose_preset(self, name: str) -> None:
        self.note_base(name)
        self.preset_chosen.emit(self.presets.parameters(name))
