"""A form for a ParameterSet, generated from its declarations."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

from PySide6.QtCore import QEvent, QLocale, QObject, QPoint, QSettings, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
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
        self._kind, self._step, self._log = declaration.kind, declaration.step, declaration.scale == "log"
        self._low, self._high = float(declaration.minimum or 0), float(declaration.maximum or 0)
        last = round((self._high - self._low) / self._step)
        if self._log:
            # 0 has no logarithm: it gets a separate position at the left end
            self._apart = int(self._low <= 0)
            finest = 1.0 if self._kind is int else _FINEST * self._step
            self._first = finest if self._apart else self._low
            self._decades = math.log10(self._high / self._first)
            last = _LOG_STEPS + self._apart
        self.setRange(0, last)
        self.setPageStep(max(last // 10, 1))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def value_at(self, position: int) -> Value:
        """Return the value at a position, rounded to a readable number."""
        if position <= 0:
            found = self._low
        elif position >= self.maximum():
            found = self._high
        elif self._log:
            exponent = self._decades * (position - self._apart) / _LOG_STEPS
            found = float(f"{self._first * 10**exponent:.2g}")
        else:
            found = round(self._low + position * self._step, 9)
        found = min(max(found, self._low), self._high)
        return round(found) if self._kind is int else found

    def position_of(self, value: Value) -> int:
        """Return the position nearest to a value."""
        number = float(value)
        if not self._log:
            return round((number - self._low) / self._step)
        if number < self._first:
            return 0
        return self._apart + round(_LOG_STEPS * math.log10(number / self._first) / self._decades)

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


class ParameterForm(Themed, QScrollArea):
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
        self._parameters = set_class()
        self._base = set_class()
        self._source = "the preset"
        self._declarations = declarations = set_class.declarations()
        self._places: dict[str, QWidget] = {}
        """The place of every parameter's row."""
        self._rows: dict[str, _Row] = {}
        """The rows that have been shown; most never are."""
        self._wheel_guard = _WheelGuard(self)
        self._controlling = {item.when[0] for item in declarations.values() if item.when}
        """Parameters that determine whether others have an effect."""

        self._groups = {name: declaration.group for name, declaration in declarations.items()}
        """The section that a parameter is in at present."""
        self._sections = {group: ParameterSection(group) for group in dict.fromkeys((_FIRST, *self._groups.values()))}
        for name, group in self._groups.items():
            self._places[name] = place = QWidget()
            self._sections[group].rows.addWidget(place)
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
        self._take_theme()

    def parameters(self) -> ParameterSet:
        """Return the current values."""
        return self._parameters

    def set_parameters(self, parameters: ParameterSet) -> None:
        """Show new values; `changed` is not emitted."""
        if parameters != self._parameters:
            self._parameters = parameters
            self._show()

    def set_base(self, parameters: ParameterSet, source: str = "the preset") -> None:
        """Set the base values, which rows are compared with and reset to, and their name."""
        if (parameters, source) != (self._base, self._source):
            self._base, self._source = parameters, source
            for name, row in self._rows.items():
                self._places[name].setToolTip(_tooltip(row.declaration, getattr(parameters, name), source))
            self._show()

    @property
    def shown(self) -> list[str]:
        """Names of the parameters that the form shows, in the order of their declaration."""
        return [name for name, place in self._places.items() if not place.isHidden()]

    def show_effects(self, effects: Mapping[str, str]) -> None:
        """Show what parameters did, beside them; nothing beside the others."""
        for name in effects:
            self._make_row(name)
        for name, row in self._rows.items():
            row.effect.show_message(effects.get(name, ""))
            row.effect.setVisible(name in effects)

    def put_first(self, names: Sequence[str]) -> None:
        """Put parameters first, in this order; the others have the order of their declarations."""
        self._groups = {name: _FIRST if name in names else item.group for name, item in self._declarations.items()}
        for name in (*names, *(name for name in self._places if name not in names)):
            for section in self._sections.values():
                section.rows.removeWidget(self._places[name])
            self._sections[self._groups[name]].rows.addWidget(self._places[name])
        self._update_visibility()

    def sizeHint(self) -> QSize:
        return QSize(300, 520)

    def _make_row(self, name: str) -> None:
        """Make the row of a parameter, when it is first shown; Tab reaches it after those before it."""
        if name in self._rows:
            return
        group = self._groups[name]
        earlier = takewhile(lambda other: other != name, self._places)
        made = [self._rows[other].reset for other in earlier if other in self._rows and self._groups[other] == group]
        last: QWidget = made[-1] if made else self._sections[group].header
        self._rows[name] = row = self._row(self._declarations[name], self._places[name])
        for control in filter(None, (row.editor, row.slider, row.reset)):
            QWidget.setTabOrder(last, control)
            last = control
        self._show_row(name)

    def _row(self, declaration: Declaration, widget: QWidget) -> _Row:
        name = declaration.name
        grid = QGridLayout(widget)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        editor, show = _editor(declaration, lambda value: self._edited(name, value))
        editor.setObjectName(name)
        editor.installEventFilter(self._wheel_guard)
        if isinstance(editor, QCheckBox):
            caption: QLabel | QCheckBox = editor
            grid.addWidget(editor, 0, 0, 1, 2)
        else:
            caption = PlainLabel(declaration.label, wordWrap=True)
            caption.setBuddy(editor)
            editor.setFixedWidth(_FIELD_WIDTH)
            grid.addWidget(caption, 0, 0)
            grid.addWidget(editor, 0, 1)
        slider = self._slider(declaration) if has_slider(declaration) else None
        if slider is not None:
            grid.addWidget(slider, 1, 0, 1, 2)
        reset = flat_button("", name=f"Reset {declaration.label}")
        reset.clicked.connect(lambda: self._edited(name, getattr(self._base, name)))
        reset.setFixedSize(_RESET_SIZE, _RESET_SIZE)
        reset.setObjectName(f"reset_{name}")
        reset.setIcon(self._reset_icon())
        policy = reset.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        reset.setSizePolicy(policy)
        grid.addWidget(reset, 0, 2)
        effect = Message()
        effect.setObjectName(f"effect_{name}")
        effect.hide()
        grid.addWidget(effect, 2, 0, 1, 2)
        widget.setToolTip(_tooltip(declaration, getattr(self._base, name), self._source))
        widget.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        widget.customContextMenuRequested.connect(lambda at: self.menu_requested.emit(name, widget.mapToGlobal(at)))
        return _Row(declaration, editor, caption, reset, slider, effect, show)

    def _slider(self, declaration: Declaration) -> ValueSlider:
        slider = ValueSlider(declaration)
        slider.setObjectName(f"slider_{declaration.name}")
        slider.setAccessibleName(declaration.label)
        slider.installEventFilter(self._wheel_guard)
        slider.valueChanged.connect(lambda _: self._edited(declaration.name, slider.shown_value))
        return slider

    def _edited(self, name: str, value: Value) -> None:
        current = getattr(self._parameters, name)
        # Enter in an unchanged field reports the rounded value that it shows
        if isinstance(current, float) and isinstance(value, float) and round(current, _DECIMALS) == value:
            self._show_row(name)
            return
        if value == current:
            return
        self._parameters = self._parameters.replace(**{name: value})
        self._show_row(name)
        if name in self._controlling:
            self._update_visibility()
        self.changed.emit(self._parameters)

    def _show(self) -> None:
        for name in self._rows:
            self._show_row(name)
        self._update_visibility()

    def _show_row(self, name: str) -> None:
        row = self._rows[name]
        value, base = getattr(self._parameters, name), getattr(self._base, name)
        with QSignalBlocker(row.editor):
            row.show(value)
        if row.slider is not None:
            row.slider.show_value(value)
        # not by palette, which a new application style sheet would reset
        accent = theme.colours(self.palette()).accent.name()
        style = "" if value == base else f"color: {accent}"
        if row.caption.styleSheet() != style:  # setting a style sheet is slow, even the same one
            row.caption.setStyleSheet(style)
        row.reset.setVisible(value != base)
        row.reset.setToolTip(literal_text(f"Reset to {row.declaration.to_text(base)}"))

    def _update_visibility(self) -> None:
        effective = {name for name in self._places if self._parameters.has_effect(name)}
        every = self.all_button.isChecked()
        shown = {name for name in effective if every or self._declarations[name].basic or self._differs(name)}
        for name, place in self._places.items():
            if name in shown:
                self._make_row(name)
            place.setVisible(name in shown)
        self.all_button.setText("Only the main parameters" if every else f"All {len(effective)} parameters")
        self.all_button.setArrowType(Qt.ArrowType.UpArrow if every else Qt.ArrowType.DownArrow)
        groups = {self._groups[name] for name in shown}
        for group, section in self._sections.items():
            section.header.setVisible(every)
            if not every:
                section.header.setChecked(True)
            section.setVisible(group in groups)

    def _differs(self, name: str) -> bool:
        return bool(getattr(self._parameters, name) != getattr(self._base, name))

    def _show_all(self, on: bool) -> None:
        QSettings().setValue(self._key, on)
        self._update_visibility()

    def _take_theme(self) -> None:
        for row in self._rows.values():
            row.reset.setIcon(self._reset_icon())
        self._show()

    def _reset_icon(self) -> QIcon:
        return theme.icon("ph.arrow-counter-clockwise", self.palette())


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


@dataclass(frozen=True)
class _Row:
    declaration: Declaration
    editor: QWidget
    caption: QLabel | QCheckBox
    reset: QToolButton
    slider: ValueSlider | None
    effect: Message
    show: Callable[[Any], None]


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
        box = _ChoiceBox(declaration.offers or (lambda: declaration.choices))
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
