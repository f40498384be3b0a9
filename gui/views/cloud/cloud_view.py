"""The 3D view of a point cloud: canvas, colour bar, tool bar and depth clipping."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QBrush
from PySide6.QtWidgets import QHBoxLayout, QMenu, QSlider, QToolBar, QVBoxLayout, QWidget

from ...widgets.basics import PlainLabel, Themed, add_choices, lay_out, menu_button
from ..layers import Layer
from ..title_strip import TitleStrip
from .canvas import DIRECTIONS, EMPTY_TEXT, CloudCanvas
from .scene import ColourBy, Scene

_STEPS = 1000
"""Steps of a slider over the depths of the cloud."""


class DepthClip(QWidget):
    """Sliders of the nearest and the farthest depth that are drawn; what is exported is not clipped.

    Signals
    -------
    changed(float, float)
        Depths [m] between which the cloud is drawn; infinite where a slider is at its end.
    """

    changed = Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self._bounds = 0.0, 1.0
        self.depths = -math.inf, math.inf
        """Depth range [m] that is drawn."""
        self.near, self.far = self._slider("Nearest depth"), self._slider("Farthest depth")
        self._labels = PlainLabel(), PlainLabel()
        layout = lay_out(QHBoxLayout(self), PlainLabel("Depth drawn"), margins=(8, 0, 8, 2))
        for slider, label in zip((self.near, self.far), self._labels, strict=True):
            label.setFixedWidth(self.fontMetrics().horizontalAdvance("00.00 m"))
            label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            layout.addWidget(slider)
            layout.addWidget(label)
        self._show()

    def set_bounds(self, low: float, high: float) -> None:
        """Set the minimum and maximum depth [m] of the cloud; the drawn range stays the same in metres."""
        self._bounds = low, max(high, low + 1e-3)
        self._show()

    def _slider(self, what: str) -> QSlider:
        slider = QSlider(Qt.Orientation.Horizontal)
        slider.setRange(0, _STEPS)
        slider.setSingleStep(_STEPS // 100)
        slider.setPageStep(_STEPS // 10)
        slider.setAccessibleName(what)
        slider.setToolTip(f"{what} that is drawn, in this view only")
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
        self.depths = nearest, farthest
        self._show()
        self.changed.emit(nearest, farthest)

    def _show(self) -> None:
        start, end = self._bounds
        for slider, label, depth in zip((self.near, self.far), self._labels, self.depths, strict=True):
            shown = min(max(depth, start), end)
            label.setText(f"{shown:.2f} m")
            with QSignalBlocker(slider):
                slider.setValue(round(_STEPS * (shown - start) / (end - start)))


_SIZES = range(1, 5)
"""Sides of a point that can be chosen [logical px]."""


class CloudView(Themed, QWidget):
    """A point cloud with its view buttons, colour bar and clip.

    Signals
    -------
    colours_changed()
        The cloud needs other colours: another colouring was selected, or the theme changed.
    """

    colours_changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.colour_by = ColourBy.COLOUR
        self.canvas = CloudCanvas(self)
        self.setFocusProxy(self.canvas)
        self.strip = TitleStrip()
        self.strip.setToolTip("Click the title to select what colours the points")
        self.strip.menuRequested.connect(lambda: self._colours.popup(self.strip.menu_position()))
        self.clip = DepthClip()
        self.clip.hide()
        self.clip.changed.connect(self.canvas.set_depths)
        self.bar = self.strip.bar
        lay_out(
            QVBoxLayout(self), self._make_bar(), self.strip, self.clip, self.canvas, spacing=0, stretched=self.canvas
        )
        self.set_message()
        self._take_theme()

    def add_switches(self, raw: QAction, chosen_only: QAction, beside: QAction) -> None:
        """Add buttons that show the depth before completion, and only the selected blocks; and to the menu, the command
        that puts the view beside the images."""
        raw.setIconText("Raw depth")
        chosen_only.setIconText("Selected only")
        self._bar.insertActions(self._clip_action, [raw, chosen_only])
        self._look_menu.addAction(beside)

    def show_scene(self, scene: Scene, reset: bool = True) -> None:
        """Show a cloud; without `reset`, keep the camera, for the same frame."""
        self.canvas.set_scene(scene, reset)
        self.clip.set_bounds(*scene.depths)
        self.strip.set_title(scene.title)
        self.strip.set_text(", ".join(filter(None, (f"{len(scene):,} points", scene.note))))
        self.strip.set_legend([(QBrush(colour), text) for colour, text in scene.legend])
        self.bar.show_layer(scene.layer, scene.unit)

    def set_message(self, text: str = EMPTY_TEXT) -> None:
        """Show a text in place of the cloud."""
        self.canvas.set_message(text)
        self.strip.set_title("3D")
        self.strip.set_text("")
        self.strip.set_legend([])
        self.bar.show_layer(Layer())

    def set_colour_by(self, colour_by: ColourBy) -> None:
        """Select what colours the points."""
        self.colour_by = colour_by
        self._choices[self.colour_by].setChecked(True)
        self._colour_button.setText(f"{self.colour_by.text} \u25be")
        self.colours_changed.emit()

    def set_unavailable(self, lacking: Mapping[ColourBy, str]) -> None:
        """Disable the unavailable colourings and show the reasons."""
        for choice in ColourBy:
            why = lacking.get(choice, "")
            self._choices[choice].setEnabled(not why)
            self._choices[choice].setToolTip(f"{choice.hint}. {why}" if why else choice.hint)

    def _take_theme(self) -> None:
        self.colours_changed.emit()

    def _make_bar(self) -> QToolBar:
        """Create the tool bar; without room, the last items move to its extension."""
        self._bar = bar = QToolBar("3D", self)
        bar.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        self._colours = QMenu(self)
        self._colours.setToolTipsVisible(True)
        texts = {choice: choice.text for choice in ColourBy}
        self._choices = add_choices(self._colours, texts, self.colour_by, self.set_colour_by)
        self._colour_button = menu_button(self._colours, f"{self.colour_by.text} \u25be", "What colours the points")
        bar.addWidget(self._colour_button)
        bar.addSeparator()
        self._clip_action = clip = _checkable(bar, "Clip", False)
        clip.setToolTip("Draw only a range of depths; files that are exported have all points")
        clip.toggled.connect(self._show_clip)
        bar.addSeparator()
        self._look_menu = self._make_look_menu()
        hint = "Direction, shading and point size, and where the view is"
        bar.addWidget(menu_button(self._look_menu, "View \u25be", hint))
        return bar

    def _make_look_menu(self) -> QMenu:
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        for name, (text, hint, *_) in DIRECTIONS.items():
            menu.addAction(text, partial(self.canvas.look, name)).setToolTip(hint)
        menu.addSeparator()
        self._shading = _checkable(menu, "&Shading", True)
        self._shading.setToolTip("Darken points behind their neighbours")
        self._shading.toggled.connect(self.canvas.set_shaded)
        sizes: dict[int | None, str] = {None: "Distance to neighbouring points"}
        sizes |= {size: f"{size} px" for size in _SIZES}
        self._sizes = add_choices(menu.addMenu("&Point size"), sizes, None, self.canvas.set_point_size)
        menu.addSeparator()
        return menu

    def _show_clip(self, on: bool) -> None:
        self.clip.setVisible(on)
        self.canvas.set_depths(*(self.clip.depths if on else (-math.inf, math.inf)))


def _checkable(place: QMenu | QToolBar, text: str, on: bool) -> QAction:
    action = place.addAction(text)
    action.setCheckable(True)
    action.setChecked(on)
    return action
