"""A form for a ParameterSet, generated from its declarations."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

from PySide6.QtCore import QEvent, QLocale, QObject, QPoint, QSettings, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QScrollArea,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ilf.data.declarations import Declaration, ParameterSet, Value

from ..base import theme
from .basics import Message, PlainLabel, Themed, flat_button, lay_out, literal_text

# Sliders of parameters: which parameters have one, and the mapping of positions to values.

_LINEAR_STEPS = 200
"""Maximum number of steps that can be set by hand."""

_LOG_STEPS = 240
_FINEST = 0.1
"""Smallest value above the left end of a logarithmic slider whose minimum is not above 0, in steps."""


def has_slider(declaration: Declaration) -> bool:
    """Return whether a slider makes sense: a number with two bounds and not too many steps between them."""
    if declaration.choices or declaration.kind is bool or declaration.minimum is None or declaration.maximum is None:
        return False
    return declaration.scale == "log" or declaration.maximum - declaration.minimum <= _LINEAR_STEPS * declaration.step


class ValueSlider(QSlider):
    """A slider with positions 0, 1, ... for ascending values; whole numbers for an int.

    Parameters
    ----------
    declaration : Declaration
        One for which `has_slider` holds.
    """

    def __init__(self, declaration: Declaration) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        kind, step = declaration.kind, declaration.step
        low, high = float(declaration.minimum or 0), float(declaration.maximum or 0)
        if declaration.scale == "log":
            # 0 has no logarithm: it gets a separate position at the left end
            finest = 1.0 if kind is int else _FINEST * step
            first = finest if low <= 0 else low
            decades = math.log10(high / first)
            exact = [first * 10 ** (decades * position / _LOG_STEPS) for position in range(_LOG_STEPS + 1)]
            self._exact = [low] * (low <= 0) + exact
            values = [float(f"{value:.2g}") for value in self._exact]
        else:
            self._exact = [low + position * step for position in range(round((high - low) / step) + 1)]
            values = [round(value, 9) for value in self._exact]
        values[0], values[-1] = low, high
        within = [min(max(value, low), high) for value in values]
        self._values: list[Value] = [round(value) for value in within] if kind is int else list(within)
        self.setRange(0, len(values) - 1)
        self.setPageStep(max((len(values) - 1) // 10, 1))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def value_at(self, position: int) -> Value:
        """Return the value at a position, a readable number."""
        return self._values[position]

    def position_of(self, value: Value) -> int:
        """Return the position nearest to a value."""
        return min(range(len(self._exact)), key=lambda position: abs(self._exact[position] - float(value)))

    @property
    def shown_value(self) -> Value:
        """The value at the current position."""
        return self.value_at(self.value())

    def show_value(self, value: Value) -> None:
        """Move to a value without a signal; the handle does not move if its position already has that value."""
        if self.shown_value != value:
            with QSignalBlocker(self):
                self.setValue(self.position_of(value))


_DECIMALS = 9
_UNBOUNDED = 1_000_000_000
_FIELD_WIDTH = 120
_RESET_SIZE = 18
_FIRST = "With most effect here"
"""The section of the parameters that `show_effects` puts first."""


class ParameterForm(QScrollArea):
    """A form that edits one ParameterSet; editors and limits come from the declarations.

    Parameters that have no effect with the current values of others are hidden. At first the form shows the basic ones
    and those that differ from the base values; the button at its end shows all. The choice is remembered.

    Beside a parameter, the form can show what it did, and parameters can come first in a section of their own.

    The editors only display the set: a value with more digits than an editor shows is preserved unless the user
    changes it.

    Parameters
    ----------
    set_class : type of ParameterSet
        The form starts with this class's defaults, which are also the first base values.

    Signals
    -------
    changed(ParameterSet)
        After every change by the user, with the new values.
    menu_requested(str, QPoint)
        The user right-clicked a parameter, at this screen position.
    """

    changed = Signal(object)
    menu_requested = Signal(str, QPoint)

    def __init__(self, set_class: type[ParameterSet]) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its fields have it
        self._parameters = self._base = set_class()
        self._source = "the preset"
        self._first: Sequence[str] = ()
        """The parameters in the first section."""
        declarations = set_class.declarations()
        self._controlling = {item.when[0] for item in declarations.values() if item.when}
        """Parameters that determine whether others have an effect."""
        guard = _WheelGuard(self)
        self._rows = {
            name: ParameterRow(item, partial(self._edited, name), guard) for name, item in declarations.items()
        }
        for name, row in self._rows.items():
            row.customContextMenuRequested.connect(partial(self._ask_menu, name))
        groups = dict.fromkeys((_FIRST, *(item.group for item in declarations.values())))
        self._sections = {group: ParameterSection(group) for group in groups}
        self._key = f"parameters/all_{set_class.__name__}"
        self.all_button = QToolButton(autoRaise=True)
        self.all_button.setCheckable(True)
        self.all_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.all_button.setChecked(QSettings().value(self._key, False, bool) is True)
        self.all_button.toggled.connect(self._show_all)
        self.footer = lay_out(QHBoxLayout(), self.all_button, None)
        content, sections = QWidget(), self._sections.values()
        lay_out(QVBoxLayout(content), *sections, self.footer, None, margins=(8, 6, 4, 10), spacing=2)
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.put_first(())

    def parameters(self) -> ParameterSet:
        """Return the current values."""
        return self._parameters

    def set_parameters(
        self, parameters: ParameterSet, base: ParameterSet | None = None, source: str = "the preset"
    ) -> None:
        """Show new values; `changed` is not emitted. Rows are compared with the `base` values, which are from `source`,
        and reset to them; if they are left out, they stay."""
        if base is None:
            base, source = self._base, self._source
        shown = parameters, base, source
        if shown != (self._parameters, self._base, self._source):
            self._parameters, self._base, self._source = shown
            self._show()

    @property
    def shown(self) -> list[str]:
        """Names of the parameters that the form shows, in the order of their declaration."""
        return [name for name, row in self._rows.items() if not row.isHidden()]

    def show_effects(self, effects: Mapping[str, str]) -> None:
        """Show what parameters did, beside them; nothing beside the others."""
        for name, row in self._rows.items():
            if name in effects:
                self._show_row(name)
            if row.made:
                row.effect.show_message(effects.get(name, ""))
                row.effect.setVisible(name in effects)

    def put_first(self, names: Sequence[str]) -> None:
        """Put parameters first, in this order; the others have the order of their declarations."""
        self._first = names
        for name in (*names, *(name for name in self._rows if name not in names)):
            self._sections[self._group(name)].rows.addWidget(self._rows[name])  # as the last one, also if it was there
        self._show()

    def _group(self, name: str) -> str:
        """The section that a parameter is in at present."""
        return _FIRST if name in self._first else self._rows[name].declaration.group

    def sizeHint(self) -> QSize:
        return QSize(300, 520)

    def _ask_menu(self, name: str, at: QPoint) -> None:
        self.menu_requested.emit(name, self._rows[name].mapToGlobal(at))

    def _edited(self, name: str, value: Value | None) -> None:
        """Take a value of the user; None resets it."""
        current = getattr(self._parameters, name)
        value = getattr(self._base, name) if value is None else value
        # Enter in an unchanged field reports the rounded value that it shows
        if isinstance(current, float) and isinstance(value, float) and round(current, _DECIMALS) == value:
            value = current
        changed = value != current
        self._parameters = self._parameters.replace(**{name: value})
        self._show_row(name)
        if changed and (name in self._controlling or self._rows[name].isHidden()):
            self._show()
        if changed:
            self.changed.emit(self._parameters)

    def _show_row(self, name: str) -> None:
        self._rows[name].show_value(getattr(self._parameters, name), getattr(self._base, name), self._source)

    def _show(self) -> None:
        """Show the values, of the parameters that have an effect now."""
        effective = {name for name in self._rows if self._parameters.has_effect(name)}
        every = self.all_button.isChecked()
        changed = self._parameters.differences_from(self._base)
        shown = {name for name in effective if every or self._rows[name].declaration.basic or name in changed}
        for name, row in self._rows.items():
            if name in shown or row.made:
                self._show_row(name)
            row.setVisible(name in shown)
        self.all_button.setText("Only the main parameters" if every else f"All {len(effective)} parameters")
        self.all_button.setArrowType(Qt.ArrowType.UpArrow if every else Qt.ArrowType.DownArrow)
        groups = {self._group(name) for name in shown}
        for group, section in self._sections.items():
            section.header.setVisible(every)
            if not every:
                section.header.setChecked(True)
            section.setVisible(group in groups)
            section.order_tabs()

    def _show_all(self, on: bool) -> None:
        QSettings().setValue(self._key, on)
        self._show()


class ParameterRow(Themed, QWidget):
    """The row of a parameter. Its controls are made when it first shows a value: most parameters are never shown.

    Parameters
    ----------
    declaration : Declaration
    edited : callable
        Called with a value of the user, or None if the parameter is reset.
    guard : QObject
        Event filter of the controls.
    """

    effect: Message

    def __init__(self, declaration: Declaration, edited: Callable[[Value | None], None], guard: QObject) -> None:
        super().__init__()
        self.declaration = declaration
        self._edited, self._guard = edited, guard
        self.controls: list[QWidget] = []
        """In the order of the Tab key."""
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)

    @property
    def made(self) -> bool:
        """Whether it has its controls."""
        return bool(self.controls)

    def _make(self) -> None:
        name, label = self.declaration.name, self.declaration.label
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        self._editor, self._show_in_editor = _editor(self.declaration, self._edited)
        self._editor.setObjectName(name)
        if isinstance(self._editor, QCheckBox):
            self._caption: QWidget = self._editor
            grid.addWidget(self._editor, 0, 0, 1, 2)
        else:
            self._caption = caption = PlainLabel(label, wordWrap=True)
            caption.setBuddy(self._editor)
            self._editor.setFixedWidth(_FIELD_WIDTH)
            grid.addWidget(caption, 0, 0)
            grid.addWidget(self._editor, 0, 1)
        self._slider = self._made_slider() if has_slider(self.declaration) else None
        if self._slider is not None:
            grid.addWidget(self._slider, 1, 0, 1, 2)
        reset = f"Reset {label}"
        self._reset = flat_button("", lambda: self._edited(None), name=reset, icon="ph.arrow-counter-clockwise")
        self._reset.setFixedSize(_RESET_SIZE, _RESET_SIZE)
        self._reset.setObjectName(f"reset_{name}")
        policy = self._reset.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self._reset.setSizePolicy(policy)
        grid.addWidget(self._reset, 0, 2)
        self.effect = Message()
        self.effect.setObjectName(f"effect_{name}")
        self.effect.hide()
        grid.addWidget(self.effect, 2, 0, 1, 2)
        self.controls = [*filter(None, (self._editor, self._slider, self._reset))]
        for control in self.controls[:-1]:
            control.installEventFilter(self._guard)

    def _made_slider(self) -> ValueSlider:
        slider = ValueSlider(self.declaration)
        slider.setObjectName(f"slider_{self.declaration.name}")
        slider.setAccessibleName(self.declaration.label)
        slider.valueChanged.connect(lambda _: self._edited(slider.shown_value))
        return slider

    def show_value(self, value: Value, base: Value, source: str) -> None:
        """Show a value, and the base value that it is reset to, which is from `source`."""
        if not self.made:
            self._make()
        self._shown = value, base, source
        with QSignalBlocker(self._editor):
            self._show_in_editor(value)
        if self._slider is not None:
            self._slider.show_value(value)
        # not by palette, which a new application style sheet would reset
        accent = theme.colours(self.palette()).accent.name()
        style = "" if value == base else f"color: {accent}"
        if self._caption.styleSheet() != style:  # setting a style sheet is slow, even the same one
            self._caption.setStyleSheet(style)
        self._reset.setVisible(value != base)
        self._reset.setToolTip(literal_text(f"Reset to {self.declaration.to_text(base)}"))
        self.setToolTip(_tooltip(self.declaration, base, source))

    def _take_theme(self) -> None:
        if self.made:
            self.show_value(*self._shown)


class ParameterSection(QWidget):
    """A titled group of rows, which can be folded."""

    def __init__(self, title: str) -> None:
        super().__init__()
        body, self.header = QWidget(), QToolButton(autoRaise=True)
        lay_out(QVBoxLayout(self), self.header, body, margins=(0, 0, 0, 6), spacing=2)
        self.rows = lay_out(QVBoxLayout(body), margins=(2, 2, 0, 2), spacing=5)
        self.header.setText(title)
        self.header.setCheckable(True)
        self.header.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.header.setStyleSheet("QToolButton { border: none; padding: 3px 0; }")
        self.header.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        font = self.header.font()
        font.setBold(True)
        self.header.setFont(font)

        def fold(opened: bool) -> None:
            body.setVisible(opened)
            self.header.setArrowType(Qt.ArrowType.DownArrow if opened else Qt.ArrowType.RightArrow)

        self.header.toggled.connect(fold)
        self.header.setChecked(True)

    def order_tabs(self) -> None:
        """Let the Tab key reach its rows from top to bottom, in whatever order they were made."""
        rows = sorted(self.findChildren(ParameterRow), key=self.rows.indexOf)
        controls = [control for row in rows for control in row.controls]
        for control, following in pairwise([self.header, *controls]):
            QWidget.setTabOrder(control, following)


class _WheelGuard(QObject):
    """Event filter that passes the wheel to the scroll area unless the editor has the focus."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Wheel and isinstance(watched, QWidget) and not watched.hasFocus():
            event.ignore()
            return True
        return False


class FloatBox(QDoubleSpinBox):
    """A spin box that shows the decimals of its step, and more only if the value has more."""

    def __init__(self, step: float) -> None:
        super().__init__()
        self._step_decimals = _decimals(step)
        # same number format as on the command line and in files
        self.setLocale(QLocale.c())
        self.setDecimals(_DECIMALS)
        self.setSingleStep(step)

    def textFromValue(self, value: float) -> str:
        return f"{value:.{max(self._step_decimals, _decimals(value))}f}"


class _ChoiceBox(QComboBox):
    """A combo box with a list of values that may change: it is updated whenever it shows one or opens.

    Signals
    -------
    chosen(str)
        After every change by the user.
    """

    chosen = Signal(str)

    def __init__(self, offers: Callable[[], tuple[str, ...]]) -> None:
        super().__init__()
        self._offers = offers
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.currentIndexChanged.connect(lambda _: self.chosen.emit(self.currentData()))

    def show_value(self, value: Value) -> None:
        offered = self._offers()
        missing = value not in offered
        with QSignalBlocker(self):
            self.clear()
            for name in offered:
                self.addItem(name, name)
            if missing:
                self.addItem(f"missing: {value}", value)
            self.setCurrentIndex(self.findData(value))
        # without its own tooltip it shows that of the row
        self.setToolTip(literal_text(f"{value} is not on this computer. Select another, or add it.") if missing else "")

    def showPopup(self) -> None:
        self.show_value(self.currentData())
        # names may be longer than the field
        self.view().setMinimumWidth(
            self.view().sizeHintForColumn(0) + self.view().verticalScrollBar().sizeHint().width()
        )
        super().showPopup()


def _editor(declaration: Declaration, edited: Callable[[Value], None]) -> tuple[QWidget, Callable[[Any], None]]:
    """Return the editor of one parameter and the function that shows a value in it."""
    if declaration.choices or declaration.offers is not None:
        box = _ChoiceBox(declaration.offers or (lambda: tuple(declaration.choices)))
        box.chosen.connect(edited)
        return box, box.show_value
    if declaration.kind is bool:
        tick = QCheckBox(declaration.label)
        tick.toggled.connect(edited)
        return tick, tick.setChecked
    if declaration.kind is int:
        spin: QSpinBox | QDoubleSpinBox = QSpinBox()
        spin.setSingleStep(max(1, int(declaration.step)))
    else:
        spin = FloatBox(declaration.step)
    low, high = declaration.minimum, declaration.maximum
    spin.setMinimum(declaration.kind(-_UNBOUNDED if low is None else low))
    spin.setMaximum(declaration.kind(_UNBOUNDED if high is None else high))
    spin.setSpecialValueText(declaration.special)
    spin.setSuffix(f" {declaration.unit}" if declaration.unit else "")
    spin.setAlignment(Qt.AlignmentFlag.AlignRight)
    spin.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    spin.setKeyboardTracking(False)
    spin.setAccelerated(True)
    spin.setCorrectionMode(QAbstractSpinBox.CorrectionMode.CorrectToNearestValue)
    spin.valueChanged.connect(edited)
    return spin, spin.setValue


def _decimals(value: float) -> int:
    """Return the number of decimals that `value` needs, up to the maximum of an editor."""
    return len(f"{value:.{_DECIMALS}f}".rstrip("0").partition(".")[2])


def _tooltip(declaration: Declaration, usual: Value, whose: str) -> str:
    """Return help, base value and source as rich text, which wraps."""
    facts = [html.escape(f"In {whose}: {declaration.to_text(usual)}")]
    if declaration.source:
        facts.append(f"Source: {declaration.source}")
    lines = [declaration.help, "<br>".join(facts), f"<code>{declaration.name}</code>"]
    return "".join(f"<p>{line}</p>" for line in lines)
