"""The options of the active tool, in the tool bar."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QSizePolicy, QSlider, QSpinBox, QToolButton, QWidget

from ilf.data.frame import FARTHEST_DEPTH

from ..base.commands import Actions
from ..widgets.basics import TEXT_BESIDE_ICON, PlainLabel, command_button, lay_out
from .base import BRUSH_RADII, LARGEST_AMOUNT, LARGEST_LEASH, ToolOptions

_SLIDER_WIDTH = 60
_GAP = 4

BY_HAND = "fill_by_hand continue_plane nearer_surface farther_surface | remove_by_hand"
"""The commands of the tool Depth by hand."""


class OptionsRow(QWidget):
    """Editors of `ToolOptions`; only those of the active tool are visible.

    Signals
    -------
    changed(str, object)
        Name of an option of `ToolOptions`, and its new value.
    """

    changed = Signal(str, object)

    def __init__(self, actions: Actions) -> None:
        super().__init__()
        by_amount = [actions[name] for name in ("grow_blocks", "shrink_blocks", "smooth_blocks")]
        self._brush_text, self._leash_text = PlainLabel(), PlainLabel()
        self.brush = _slider("Brush", 1, round(BRUSH_RADII[-1]))
        self.leash = _slider("Snap", 0, LARGEST_LEASH)
        self._switches = {name: actions[name] for name in ("similar_only", "to_no_block")}
        self.amount = QSpinBox(minimum=1, maximum=LARGEST_AMOUNT, prefix="by ", suffix=" px")
        self.amount.setAccessibleName("Amount")
        self.hand_depth = QDoubleSpinBox(decimals=3, maximum=FARTHEST_DEPTH, singleStep=0.01, suffix=" m")
        self.hand_depth.setSpecialValueText("not set")
        self.hand_depth.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        self.hand_depth.setAccessibleName("Depth")
        self.hand_depth.setToolTip("Depth that the brush paints and Fill uses; Ctrl+click in the image picks one")
        self.hand_depth.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.leash.setToolTip(
            "Snap: maximum distance on the screen that a drawn line moves to an edge (less of the image when zoomed "
            "in); 0: off"
        )
        self.amount.setToolTip("Pixels by which the selected blocks grow, shrink or are smoothed")
        self.amount.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        _show_while_usable(self.amount, actions["grow_blocks"])
        by_hand = [name for name in BY_HAND.split() if name != "|"]
        self._parts: dict[str, QWidget] = {
            "brush": _together(self.brush, self._brush_text),
            "leash": _together(PlainLabel("Snap"), self.leash, self._leash_text),
            **{name: _together(_button(actions[name])) for name in ("similar_only", "to_no_block", "new_block")},
            "hand_depth": _together(self.hand_depth, *(_button(actions[name], short=True) for name in by_hand)),
            "amount": _together(*(_button(action) for action in by_amount), self.amount),
        }
        lay_out(QHBoxLayout(self), *self._parts.values(), spacing=_GAP)
        policy = QSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        policy.setRetainSizeWhenHidden(True)
        self.setSizePolicy(policy)
        for label, longest in ((self._brush_text, "120 px"), (self._leash_text, "20 px")):
            label.setMinimumWidth(label.fontMetrics().horizontalAdvance(longest))
        for box in (self.amount, self.hand_depth):
            box.setKeyboardTracking(False)  # Escape drops what is being typed
        self._numbers: dict[str, QSlider | QSpinBox] = {
            "brush_radius": self.brush,
            "leash": self.leash,
            "amount": self.amount,
        }
        for name, number in self._numbers.items():
            number.valueChanged.connect(partial(self.changed.emit, name))
        self.hand_depth.valueChanged.connect(partial(self.changed.emit, "hand_depth"))

    def event(self, event: QEvent) -> bool:
        """Tell the tool bar of another width also while it has no room for the row, which it hides then."""
        if event.type() == QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return super().event(event)

    def show_options(self, names: Collection[str], options: ToolOptions) -> None:
        """Show the options of a tool (`Tool.options`) with their values."""
        for name, part in self._parts.items():
            part.setVisible(name in names)
        diameter = 2 * options.brush_radius
        self._brush_text.setText(f"{diameter:g} px")
        self.brush.setToolTip(f"Brush diameter: {diameter:g} px ([ and ], or Ctrl+wheel)")
        self._leash_text.setText(f"{options.leash} px" if options.leash else "off")
        for name, number in self._numbers.items():
            with QSignalBlocker(number):
                number.setValue(round(getattr(options, name)))
        if not self.hand_depth.hasFocus():  # a number that is being typed is rounded
            with QSignalBlocker(self.hand_depth):
                self.hand_depth.setValue(options.hand_depth)
        for name, switch in self._switches.items():
            switch.setChecked(getattr(options, name))


def _slider(name: str, low: int, high: int) -> QSlider:
    slider = QSlider(Qt.Orientation.Horizontal)
    slider.setAccessibleName(name)
    slider.setRange(low, high)
    slider.setFixedWidth(_SLIDER_WIDTH)
    slider.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return slider


def _button(action: QAction, short: bool = False) -> QToolButton:
    """Return a button that is there only while its command can be used; with `short`, with its first word."""
    if short:
        action.setIconText(action.iconText().partition(" ")[0])
    button = command_button(action, TEXT_BESIDE_ICON)
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    _show_while_usable(button, action)
    return button


def _show_while_usable(widget: QWidget, action: QAction) -> None:
    widget.setVisible(action.isEnabled())
    action.enabledChanged.connect(widget.setVisible)


def _together(*widgets: QWidget) -> QWidget:
    group = QWidget()
    lay_out(QHBoxLayout(group), *widgets, spacing=_GAP)
    return group
