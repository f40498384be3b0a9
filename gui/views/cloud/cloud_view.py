"""The 3D view of a point cloud: canvas, colour bar, tool bar and depth clipping."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Generic, TypeVar

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QActionGroup,
    QBrush,
    QColor,
)
from PySide6.QtWidgets import QHBoxLayout, QMenu, QSlider, QToolBar, QToolButton, QVBoxLayout, QWidget

from ...base import theme
from ...widgets.basics import PlainLabel, Themed, lay_out
from ..title_strip import TitleStrip
from .canvas import EMPTY_TEXT, CloudCanvas
from .colouring import ColourBy
from .scene import Scene

# A button that opens a menu of choices and shows the current one.

Choice = TypeVar("Choice")


class ChoiceButton(QToolButton, Generic[Choice]):
    """Button with a menu to select one of several choices.

    Parameters
    ----------
    texts : mapping
        Choice -> text; the first one is current.
    hint : str
        Tooltip.
    chosen : callable
        Called with the user's choice.
    """

    def __init__(self, texts: Mapping[Choice, str], hint: str, chosen: Callable[[Choice], None]) -> None:
        super().__init__()
        self.setToolTip(hint)
        self.setAccessibleName(hint)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.setAutoRaise(True)
        self.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        self.setMenu(menu)
        group = QActionGroup(menu)
        self._choices: dict[Choice, QAction] = {}
        widths = []
        for choice, text in texts.items():
            action = menu.addAction(text)
            action.setCheckable(True)
            action.triggered.connect(lambda _=False, choice=choice: chosen(choice))
            group.addAction(action)
            self._choices[choice] = action
            self.show_choice(choice)
            widths.append(self.sizeHint().width())
        # fixed width, so that the bar does not move; the icon is set with the theme
        self.setMinimumWidth(max(widths) + self.iconSize().width())
        self.show_choice(next(iter(texts)))

    def show_choice(self, choice: Choice) -> None:
        """Mark a choice as the current one."""
        self._choices[choice].setChecked(True)
        self.setText(f"{self._choices[choice].text()} \u25be")

    def allow(self, choice: Choice, allowed: bool, hint: str) -> None:
        """Enable or disable a choice and set its tooltip."""
        self._choices[choice].setEnabled(allowed)
        self._choices[choice].setToolTip(hint)


_STEPS = 1000
"""Steps of a slider over the depths of the cloud."""


class DepthClip(QWidget):
    """Sliders of the nearest and the farthest depth that are drawn, and a button to show all depths.

    Signals
    -------
    changed(float, float)
        Depths [m] between which the cloud is drawn; infinite where a slider is at its end.
    """

    changed = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bounds = 0.0, 1.0
        self.depths = -math.inf, math.inf
        """Depth range [m] that is drawn."""
        self.near, self.far = self._slider("Nearest depth"), self._slider("Farthest depth")
        self._labels = PlainLabel(), PlainLabel()
        everything = QToolButton(autoRaise=True)
        everything.setText("All")
        everything.setAccessibleName("Draw all depths")
        everything.setToolTip("Draw all depths again")
        everything.clicked.connect(self.clear)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 0, 8, 2)
        layout.addWidget(PlainLabel("Depth"))
        for slider, label in zip((self.near, self.far), self._labels, strict=True):
            label.setFixedWidth(self.fontMetrics().horizontalAdvance("00.00 m"))
            label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            layout.addWidget(slider)
            layout.addWidget(label)
        layout.addWidget(everything)
        self._show()

    def set_bounds(self, low: float, high: float) -> None:
        """Set the minimum and maximum depth [m] of the cloud; the drawn range stays the same in metres."""
        self._bounds = low, max(high, low + 1e-3)
        self._show()

    def clear(self) -> None:
        """Draw all depths."""
        self._set(-math.inf, math.inf)

    def _slider(self, what: str) -> QSlider:
        slider = QSlider(Qt.Orientation.Horizontal)
        slider.setRange(0, _STEPS)
        slider.setSingleStep(_STEPS // 100)
        slider.setPageStep(_STEPS // 10)
        slider.setAccessibleName(what)
        slider.setToolTip(f"{what} that is drawn")
        slider.valueChanged.connect(lambda _: self._take(slider))
        return slider

    def _take(self, moved: QSlider) -> None:
        """Draw the range of the sliders; one pushes the other."""
        near, far = self.near.value(), self.far.value()
        if near > far:
            near = far = moved.value()
        start, end = self._bounds
        nearest = start + near / _STEPS * (end - start) if near > 0 else -math.inf
        farthest = start + far / _STEPS * (end - start) if far < _STEPS else math.inf
        self._set(nearest, farthest)

    def _set(self, low: float, high: float) -> None:
        self.depths = low, high
        self._show()
        self.changed.emit(low, high)

    def _show(self) -> None:
        start, end = self._bounds
        for slider, label, depth in zip((self.near, self.far), self._labels, self.depths, strict=True):
            shown = min(max(depth, start), end)
            label.setText(f"{shown:.2f} m")
            with QSignalBlocker(slider):
                slider.setValue(round(_STEPS * (shown - start) / (end - start)))


_LOOKS = {
    "home": ("ph.house", "Show the whole cloud (R, Home, double-click beside it)"),
    "front": ("ph.camera", "View along the axis of the depth camera"),
    "top": ("ph.arrow-line-down", "View from above"),
    "side": ("ph.arrow-line-left", "View from the right"),
}


class CloudView(Themed, QWidget):
    """A point cloud with its view buttons, colour bar and clip.

    Signals
    -------
    colours_changed()
        The cloud needs other colours: another colouring was selected, or the theme changed.
    """

    colours_changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.colour_by = ColourBy.COLOUR
        self.canvas = CloudCanvas(self)
        self.setFocusProxy(self.canvas)
        self.strip = TitleStrip()
        self.strip.setToolTip("Click the title to select what colours the points")
        self.strip.menuRequested.connect(lambda place: self._colours.menu().popup(place))
        self.clip = DepthClip()
        self.clip.hide()
        self.clip.changed.connect(self.canvas.set_depths)
        self.bar = self.strip.bar
        self._icons: list[tuple[QAction | QToolButton, str]] = []
        lay_out(
            QVBoxLayout(self), self._make_bar(), self.strip, self.clip, self.canvas, spacing=0, stretched=self.canvas
        )
        self.set_message()
        self._apply_theme()

    def add_switches(self, raw: QAction, chosen_only: QAction, beside: QAction) -> None:
        """Add buttons to the bar: show the depth before completion, show only the selected blocks, put the view beside
        the images."""
        self.raw, self.chosen_only = raw, chosen_only
        self._bar.insertActions(self._clip_action, [raw, chosen_only])
        self._bar.addAction(beside)

    def show_scene(self, scene: Scene, reset: bool = True) -> None:
        """Show a cloud; without `reset`, keep the camera, for the same frame."""
        self.canvas.set_scene(scene, reset)
        self.clip.set_bounds(*scene.depths)
        colouring = scene.colouring
        notes = [f"{len(scene):,} points", *([colouring.note] if colouring.note else [])]
        self.strip.set_title(scene.title)
        self.strip.set_text(", ".join(notes))
        self.strip.set_legend([(QBrush(QColor(*colour)), text) for colour, text in colouring.legend])
        scale = colouring.scale
        if scale is None:
            self.bar.set_levels(None)
        else:
            self.bar.set_unit(scale.unit)
            self.bar.set_table(scale.table)
            self.bar.set_levels(scale.levels, scale.logarithmic)

    def set_message(self, text: str = EMPTY_TEXT) -> None:
        """Show a text in place of the cloud."""
        self.canvas.set_message(text)
        self.strip.set_title("3D")
        self.strip.set_text("")
        self.strip.set_legend([])
        self.bar.set_levels(None)

    def set_colour_by(self, colour_by: ColourBy) -> None:
        """Select what colours the points."""
        self.colour_by = ColourBy(colour_by)
        self._colours.show_choice(self.colour_by)
        self.colours_changed.emit()

    def set_unavailable(self, lacking: Mapping[ColourBy, str]) -> None:
        """Disable the unavailable colourings and show the reasons."""
        for choice in ColourBy:
            why = lacking.get(choice, "")
            self._colours.allow(choice, not why, f"{choice.hint}. {why}" if why else choice.hint)

    def set_point_size(self, size: int | None) -> None:
        """Set the side of a point in logical pixels; None: from the density of the cloud."""
        self._sizes.show_choice(size or 0)
        self.canvas.set_drawing(point_size=size, shaded=self._shading.isChecked())

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        return self.canvas.shutdown()

    def _take_theme(self) -> None:
        self._apply_theme()
        self.colours_changed.emit()

    def _apply_theme(self) -> None:
        colours = theme.colours(self.palette())
        for item, name in self._icons:
            item.setIcon(theme.icon(name, self.palette()))
        self.strip.set_colours(colours)

    def _make_bar(self) -> QToolBar:
        """Create the tool bar; without room, the last items move to its extension."""
        self._bar = bar = QToolBar("3D", self)
        bar.setIconSize(QSize(16, 16))
        self._colours = ChoiceButton(
            {choice: choice.text for choice in ColourBy}, "What colours the points", self.set_colour_by
        )
        bar.addWidget(self._colours)
        self._icons.append((self._colours, "ph.palette"))
        self._clip_action = clip = self._toggle_action(
            bar, "Clip", "ph.arrows-in-line-horizontal", "draw only a range of depths", False
        )
        clip.toggled.connect(self._show_clip)
        bar.addSeparator()
        for name, (icon, hint) in _LOOKS.items():
            action = bar.addAction(name.capitalize(), partial(self.canvas.look, name))
            action.setToolTip(hint)
            self._icons.append((action, icon))
        bar.addSeparator()
        self._shading = self._toggle_action(
            bar, "Shading", "ph.circle-half", "darken points behind their neighbours", True
        )
        self._shading.toggled.connect(lambda on: self.canvas.set_drawing(point_size=self.canvas.point_size, shaded=on))
        sizes = {size: f"{size} px" if size else "Auto size" for size in range(5)}
        self._sizes = ChoiceButton(
            sizes,
            "Point size; auto: the distance to neighbouring points",
            lambda size: self.set_point_size(size or None),
        )
        bar.addWidget(self._sizes)
        self._icons.append((self._sizes, "ph.dots-nine"))
        return bar

    def _toggle_action(self, bar: QToolBar, text: str, icon: str, hint: str, on: bool) -> QAction:
        action = bar.addAction(text)
        action.setCheckable(True)
        action.setChecked(on)
        action.setToolTip(f"{text}: {hint}")
        self._icons.append((action, icon))
        return action

    def _show_clip(self, on: bool) -> None:
        self.clip.setVisible(on)
        self.canvas.set_depths(*(self.clip.depths if on else (-math.inf, math.inf)))
