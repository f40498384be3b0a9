"""Options of a sweep: one or two parameters with their ranges, the criterion, and the blocks."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QGroupBox,
    QSizePolicy,
    QSpinBox,
    QWidget,
)

from ilf.data.declarations import Declaration, Value
from ilf.data.parameters import Parameters
from ilf.evaluation.hold_out import HoldOutTest
from ilf.evaluation.sweep import MAX_STEPS, MIN_STEPS, can_be_swept, spread, suggested_range

from ...widgets.basics import combo, form, label_of
from ...widgets.hold_out_choice import HoldOutChoice
from ...widgets.parameter_form import FloatBox

DEFAULT_STEPS, DEFAULT_STEPS_OF_TWO = 7, 4
_DECIMALS = 6
_LARGEST = 1e9
_FIELD = 84


class RangeBox(QGroupBox):
    """Box with one parameter and its values to test.

    Signals
    -------
    changed()
        Another parameter or other values were set.
    """

    changed = Signal()

    def __init__(self, title: str, optional: bool = False) -> None:
        super().__init__(title)
        self.setCheckable(optional)
        self.setChecked(not optional)
        self._parameters = Parameters()
        self.names = QComboBox()
        self.names.setToolTip("The parameter to sweep")
        self.names.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.low, self.high = _number("First value"), _number("Last value")
        self.steps = QSpinBox(
            minimum=MIN_STEPS, maximum=MAX_STEPS, value=DEFAULT_STEPS_OF_TWO if optional else DEFAULT_STEPS
        )
        self.steps.setToolTip("Number of values; the current value is added if it lies in the range")
        self.scale = combo(["linear", "log"], "linear: equal differences. log: equal ratios.")
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 6, 8, 8)
        grid.setSpacing(4)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(3, 1)
        for text, field, row, column, span in (
            ("&Parameter", self.names, 0, 0, 3),
            ("&From", self.low, 1, 0, 1),
            ("&to", self.high, 1, 2, 1),
            ("&Values", self.steps, 2, 0, 1),
            ("sca&le", self.scale, 2, 2, 1),
        ):
            label = label_of(text, field)
            field.setAccessibleName(f"{title}: {text.replace('&', '').lower()}")
            grid.addWidget(label, row, column)
            grid.addWidget(field, row, column + 1, 1, span)
        self.names.activated.connect(lambda _: self._set_usual_range())
        for spin in (self.low, self.high, self.steps):
            spin.valueChanged.connect(lambda _: self.changed.emit())
        self.scale.currentIndexChanged.connect(lambda _: self.changed.emit())
        self.toggled.connect(lambda _: self.changed.emit())
        self.set_parameters(self._parameters)

    @property
    def declaration(self) -> Declaration:
        """Declaration of the selected parameter."""
        return Parameters.declarations()[str(self.names.currentData())]

    @property
    def logarithmic(self) -> bool:
        """Whether the values have equal ratios."""
        return self.scale.currentText() == "log"

    def values(self) -> tuple[Value, ...]:
        """Values to test; raises ParameterError with a message for an invalid range."""
        declaration, low, high = self.declaration, self.low.value(), self.high.value()
        present = getattr(self._parameters, declaration.name)
        return spread(declaration, low, high, self.steps.value(), self.logarithmic, present)

    def set_parameters(self, parameters: Parameters) -> None:
        """Offer the parameters that have an effect with these values, the main ones first; keep the range if its
        parameter is offered."""
        self._parameters = parameters
        declarations = Parameters.declarations()
        offered = [name for name, one in declarations.items() if can_be_swept(one) and parameters.has_effect(name)]
        offered.sort(key=lambda name: not declarations[name].basic)
        if offered == [self.names.itemData(position) for position in range(self.names.count())]:
            return
        chosen = self.names.currentData()
        with QSignalBlocker(self.names):
            self.names.clear()
            for name in offered:
                self.names.addItem(f"{declarations[name].label}", name)
                self.names.setItemData(self.names.count() - 1, declarations[name].help, 3)
        first = offered[int(self.isCheckable())]  # the optional box is for another parameter than the other box
        self.choose(chosen if chosen in offered else first, again=chosen not in offered)

    def choose(self, name: str, again: bool = True) -> None:
        """Select a parameter with its usual range; without `again`, keep the range."""
        position = self.names.findData(name)
        if position >= 0:
            self.names.setCurrentIndex(position)
            if again:
                self._set_usual_range()

    def cover_present(self) -> None:
        """Take the usual range if the present value lies outside the range."""
        if not self.low.value() <= getattr(self._parameters, self.declaration.name) <= self.high.value():
            self._set_usual_range()

    def _set_usual_range(self) -> None:
        declaration = self.declaration
        low, high = suggested_range(declaration, getattr(self._parameters, declaration.name))
        for spin, value in ((self.low, low), (self.high, high)):
            with QSignalBlocker(spin):
                least = declaration.minimum if declaration.minimum is not None else -_LARGEST
                most = declaration.maximum if declaration.maximum is not None else _LARGEST
                spin.setRange(least, most)
                spin.setDecimals(0 if declaration.kind is int else _DECIMALS)
                spin.setSingleStep(declaration.step)
                spin.setValue(value)
        with QSignalBlocker(self.scale):
            self.scale.setCurrentText("log" if declaration.scale == "log" and low > 0 else "linear")
        self.changed.emit()


class CriterionBox(QWidget):
    """Criterion of the sweep, and the blocks.

    Signals
    -------
    changed()
        The user changed the criterion or the blocks.
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        hint = "Criterion: error against ground truth, or on held-out known depth"
        self.kind = combo(["Ground truth", "Hold-out"], hint)
        self.hold_out = HoldOutChoice()
        hint = "Blocks to sweep and evaluate; an applied value is set for the same blocks"
        self.blocks = combo(["All blocks", "Selected block"], hint)
        self._form = form(("&Criterion", self.kind), ("&Hide", self.hold_out), ("&Blocks", self.blocks), parent=self)
        self.kind.currentIndexChanged.connect(self._take)
        self.set_frame(False, "")
        self.hold_out.changed.connect(self.changed)
        self.blocks.activated.connect(lambda _: self.changed.emit())

    @property
    def by_ground_truth(self) -> bool:
        """Whether the criterion is ground truth."""
        return self.kind.currentIndex() == 0

    @property
    def for_selected(self) -> bool:
        """Whether only the selected block is swept."""
        return self.blocks.currentIndex() == 1

    def test(self) -> HoldOutTest | None:
        """The hold-out test; None for ground truth."""
        return None if self.by_ground_truth else self.hold_out.test()

    def set_frame(self, has_ground_truth: bool, chosen: str) -> None:
        """Set whether the frame has ground truth, which is the criterion as soon as it is there, and the name of its
        selected block; "" for none."""
        truth = self.kind.model().item(0)  # type: ignore[attr-defined]
        if has_ground_truth != truth.isEnabled():
            truth.setEnabled(has_ground_truth)
            truth.setText("Ground truth" if has_ground_truth else "Ground truth (none loaded)")
            self.kind.setCurrentIndex(int(not has_ground_truth))
        with QSignalBlocker(self.blocks):
            self.blocks.setItemText(1, f"{chosen} only" if chosen else "Selected block (none selected)")
            model = self.blocks.model()
            model.item(1).setEnabled(bool(chosen))  # type: ignore[attr-defined]
            if not chosen:
                self.blocks.setCurrentIndex(0)

    def _take(self) -> None:
        self._form.setRowVisible(self.hold_out, not self.by_ground_truth)
        self.changed.emit()


def _number(hint: str) -> FloatBox:
    spin = FloatBox(1.0)
    spin.setKeyboardTracking(False)
    spin.setMinimumWidth(_FIELD)
    spin.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
    spin.setToolTip(hint)
    return spin
