"""A form for a ParameterSet, generated from its declarations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QLocale, QObject, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFrame,
    QGridLayout,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QSpinBox,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from gui import theme
from ilf.declarations import Declaration, ParameterSet, Value

_DECIMALS = 9
_UNBOUNDED = 1_000_000_000
_FIELD_WIDTH = 120
_RESET_SIZE = 18


class ParameterForm(QScrollArea):
    """Edits one ParameterSet; what it shows and allows comes from the declarations alone.

    The set itself is the truth and the editors only show it: a value that an editor cannot show to its last
    digit survives unless the user changes it.

    Parameters
    ----------
    set_class : type of ParameterSet
        The form starts with this class's defaults, which also are the first base values.

    Signals
    -------
    changed(ParameterSet)
        After every change by the user, with the new values.
    """

    changed = Signal(object)

    def __init__(self, set_class: type[ParameterSet], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parameters = set_class()
        self._base = set_class()
        self._rows: dict[str, _Row] = {}
        self._wheel_guard = _WheelGuard(self)

        content = QWidget()
        column = QVBoxLayout(content)
        column.setContentsMargins(8, 6, 4, 10)
        column.setSpacing(2)
        groups: dict[str, list[Declaration]] = {}
        for declaration in set_class.declarations().values():
            groups.setdefault(declaration.group, []).append(declaration)
        for group, members in groups.items():
            column.addWidget(self._section(group, members))
        column.addStretch(1)

        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self._style()

    def parameters(self) -> ParameterSet:
        """The values as they stand."""
        return self._parameters

    def set_parameters(self, parameters: ParameterSet) -> None:
        """Show other values; `changed` is not emitted."""
        self._parameters = parameters
        self._show()

    def set_base(self, parameters: ParameterSet) -> None:
        """Set the values (of a preset) that rows are marked against and reset to."""
        self._base = parameters
        self._show()

    def sizeHint(self) -> QSize:
        return QSize(300, 520)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._style()

    def _section(self, group: str, members: list[Declaration]) -> QWidget:
        section = QWidget()
        column = QVBoxLayout(section)
        column.setContentsMargins(0, 0, 0, 6)
        column.setSpacing(2)
        header = QToolButton(text=group, checkable=True, checked=True, autoRaise=True)
        header.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        header.setArrowType(Qt.ArrowType.DownArrow)
        header.setStyleSheet("QToolButton { border: none; padding: 3px 0; }")
        header.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        font = header.font()
        font.setBold(True)
        header.setFont(font)
        body = QWidget()
        grid = QGridLayout(body)
        grid.setContentsMargins(2, 2, 0, 2)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(5)
        grid.setColumnStretch(0, 1)
        for number, declaration in enumerate(members):
            self._rows[declaration.name] = self._add_row(grid, number, declaration)

        def fold(opened: bool) -> None:
            body.setVisible(opened)
            header.setArrowType(Qt.ArrowType.DownArrow if opened else Qt.ArrowType.RightArrow)

        header.toggled.connect(fold)
        column.addWidget(header)
        column.addWidget(body)
        return section

    def _add_row(self, grid: QGridLayout, number: int, declaration: Declaration) -> _Row:
        name = declaration.name
        editor, show = _editor(declaration, lambda value: self._edited(name, value))
        editor.setObjectName(name)
        editor.installEventFilter(self._wheel_guard)
        if isinstance(editor, QCheckBox):
            caption: QLabel | QCheckBox = editor
            grid.addWidget(editor, number, 0, 1, 2)
        else:
            caption = QLabel(declaration.label, wordWrap=True)
            caption.setBuddy(editor)
            editor.setFixedWidth(_FIELD_WIDTH)
            grid.addWidget(caption, number, 0)
            grid.addWidget(editor, number, 1)
        reset = QToolButton(autoRaise=True)
        reset.setFixedSize(_RESET_SIZE, _RESET_SIZE)
        reset.setObjectName(f"reset_{name}")
        reset.clicked.connect(lambda: self._edited(name, getattr(self._base, name)))
        policy = reset.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        reset.setSizePolicy(policy)
        grid.addWidget(reset, number, 2)
        for widget in (caption, editor):
            widget.setToolTip(_tooltip(declaration))
        return _Row(declaration, caption, reset, show)

    def _edited(self, name: str, value: Value) -> None:
        current = getattr(self._parameters, name)
        # Enter in a field that nobody touched reports the value as the field shows it
        if isinstance(current, float) and isinstance(value, float) and round(current, _DECIMALS) == value:
            self._rows[name].show(current)
            return
        if value == current:
            return
        self._parameters = self._parameters.replace(**{name: value})
        self._show_row(name)
        self.changed.emit(self._parameters)

    def _show(self) -> None:
        for name in self._rows:
            self._show_row(name)

    def _show_row(self, name: str) -> None:
        row = self._rows[name]
        value, base = getattr(self._parameters, name), getattr(self._base, name)
        row.show(value)
        # not by palette, which a new application style sheet would take away
        accent = theme.colours(self.palette()).accent.name()
        row.caption.setStyleSheet("" if value == base else f"color: {accent}")
        row.reset.setVisible(value != base)
        row.reset.setToolTip(f"Back to {_value_text(row.declaration, base)}")

    def _style(self) -> None:
        icon = theme.icon("ph.arrow-counter-clockwise", self.palette())
        for row in self._rows.values():
            row.reset.setIcon(icon)
        self._show()


@dataclass(frozen=True)
class _Row:
    declaration: Declaration
    caption: QLabel | QCheckBox
    reset: QToolButton
    show: Callable[[Value], None]


class _WheelGuard(QObject):
    """Leaves the wheel to the scroll area unless the editor under it has the focus."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Wheel and not watched.hasFocus():
            event.ignore()
            return True
        return False


class _FloatBox(QDoubleSpinBox):
    """Shows as many decimals as its step has, and more only where the value has more."""

    def __init__(self, step: float) -> None:
        super().__init__()
        self._step_decimals = _decimals(step)
        # one way to write numbers, the same as on the command line and in files
        self.setLocale(QLocale.c())
        self.setDecimals(_DECIMALS)
        self.setSingleStep(step)

    def textFromValue(self, value: float) -> str:
        return f"{value:.{max(self._step_decimals, _decimals(value))}f}"


def _editor(declaration: Declaration, edited: Callable[[Value], None]) -> tuple[QWidget, Callable[[Value], None]]:
    """The editor of one parameter and the function that shows a value in it without a signal."""
    if declaration.choices:
        combo = QComboBox()
        combo.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        combo.addItems(declaration.choices)
        combo.currentTextChanged.connect(edited)
        return combo, _silently(combo, combo.setCurrentText)
    if declaration.kind is bool:
        box = QCheckBox(declaration.label)
        box.toggled.connect(edited)
        return box, _silently(box, box.setChecked)
    if declaration.kind is int:
        spin: QSpinBox | QDoubleSpinBox = QSpinBox()
        spin.setSingleStep(max(1, int(declaration.step)))
    else:
        spin = _FloatBox(declaration.step)
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
    return spin, _silently(spin, spin.setValue)


def _silently(widget: QWidget, setter: Callable[[Value], None]) -> Callable[[Value], None]:
    def show(value: Value) -> None:
        with QSignalBlocker(widget):
            setter(value)

    return show


def _decimals(value: float) -> int:
    """Decimals that `value` needs, up to what an editor can hold."""
    return len(f"{value:.{_DECIMALS}f}".rstrip("0").partition(".")[2])


def _value_text(declaration: Declaration, value: Value) -> str:
    if declaration.special and value == declaration.minimum:
        return declaration.special
    if isinstance(value, bool):
        return "on" if value else "off"
    number = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{number} {declaration.unit}".strip()


def _tooltip(declaration: Declaration) -> str:
    """Help, default and source as rich text, which wraps."""
    facts = [f"Default: {_value_text(declaration, declaration.default)}"]
    if declaration.source:
        facts.append(f"Source: {declaration.source}")
    lines = [declaration.help, "<br>".join(facts), f"<code>{declaration.name}</code>"]
    return "".join(f"<p>{line}</p>" for line in lines)
