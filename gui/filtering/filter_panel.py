"""The filter's panel: preset, whose parameters are shown, the form, the run buttons."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction, QStandardItemModel
from PySide6.QtWidgets import QComboBox, QFormLayout, QHBoxLayout, QToolButton, QVBoxLayout, QWidget

from gui.widgets.parameter_form import ParameterForm
from ilf.parameters import DEFAULT_PRESET, PRESETS, Parameters


class FilterPanel(QWidget):
    """Parameters of all blocks or of the chosen one.

    Signals
    -------
    edited(object)
        The user set other Parameters.
    scope_changed()
        The user asked for the parameters of all blocks or of the chosen block.
    """

    edited = Signal(object)
    scope_changed = Signal()

    def __init__(self, run_actions: list[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.presets = QComboBox()
        for name in PRESETS:
            self.presets.addItem(name, name)
        self._bases = {False: DEFAULT_PRESET, True: DEFAULT_PRESET}  # by for_chosen_block
        self.presets.setToolTip(
            "best: follows edges and noise. paper: as the text describes it. "
            "released-code: as the authors' program does it."
        )
        self.presets.activated.connect(lambda _: self.edited.emit(PRESETS[self.presets.currentData()]))
        self._scope = QComboBox()
        self._scope.addItems(["All blocks", "Chosen block"])
        self._scope.setToolTip("Whether the values below go for all blocks, or for the chosen one alone")
        self._scope.activated.connect(self.scope_changed)
        self.form = ParameterForm(Parameters)
        self.form.changed.connect(self.edited)

        choices = QFormLayout()
        choices.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        choices.addRow("Preset", self.presets)
        choices.addRow("Values for", self._scope)
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
    def for_chosen_block(self) -> bool:
        """Whether the values are those of the chosen block."""
        return self._scope.currentIndex() == 1

    def set_scope(self, chosen_block: bool) -> None:
        """Show the values of the chosen block, or of all."""
        self._scope.setCurrentIndex(int(chosen_block))
        self.scope_changed.emit()

    def show_parameters(self, parameters: Parameters, block_name: str | None) -> None:
        """Show values; `block_name` is the chosen block's, None while none is chosen."""
        model = self._scope.model()
        if isinstance(model, QStandardItemModel):
            model.item(1).setEnabled(block_name is not None)
        self._scope.setItemText(1, f"{block_name} only" if block_name else "Chosen block")
        if block_name is None:
            self._scope.setCurrentIndex(0)
        scope = self.for_chosen_block
        base = next((name for name, values in PRESETS.items() if values == parameters), self._bases[scope])
        self._bases[scope] = base
        changed = parameters != PRESETS[base]
        for position, name in enumerate(PRESETS):
            self.presets.setItemText(position, f"{name} (changed)" if changed and name == base else name)
        self.presets.setCurrentIndex(self.presets.findData(base))
        self.form.set_base(PRESETS[base])
        self.form.set_parameters(parameters)
