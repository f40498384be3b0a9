"""The 3D view of a point cloud: its picture, what its colours mean, and ways to look at it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

from PySide6.QtCore import QEvent, QSize, Signal
from PySide6.QtGui import QAction, QBrush, QColor, QResizeEvent
from PySide6.QtWidgets import QToolBar, QToolButton, QVBoxLayout, QWidget

from gui import theme
from gui.cloud.canvas import EMPTY_TEXT, CloudCanvas
from gui.cloud.choice_button import ChoiceButton
from gui.cloud.clip_row import ClipRow
from gui.cloud.colouring import ColourBy
from gui.cloud.scene import Scene
from gui.views.colour_bar import ColourBar
from gui.views.title_strip import TitleStrip

_BAR_MARGIN = 6
_BAR_SHARE = 0.55
_BAR_HEIGHTS = 110, 260
_LOOKS = {
    "home": ("ph.house", "Show the whole cloud (R, Home, double-click beside it)"),
    "front": ("ph.camera", "Look as the depth camera saw it: along its axis"),
    "top": ("ph.arrow-line-down", "Look from above"),
    "side": ("ph.arrow-line-left", "Look from the right"),
}


class CloudView(QWidget):
    """A point cloud with its view buttons, colour bar and clip.

    Parameters
    ----------
    raw, chosen_only, beside : QAction
        Whether the depth as it was before the completion is shown, whether only the chosen blocks are, whether the
        view stands beside the images: buttons of its bar.

    Signals
    -------
    colours_changed()
        Other colours are wanted: they are to mean something else, or the theme has changed.
    """

    colours_changed = Signal()

    def __init__(self, raw: QAction, chosen_only: QAction, beside: QAction, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.colour_by = ColourBy.COLOUR
        self.raw, self.chosen_only = raw, chosen_only
        self.canvas = CloudCanvas(self)
        self.setFocusProxy(self.canvas)
        self.strip = TitleStrip()
        self.strip.setToolTip("Click on the title to choose what the colours mean")
        self.strip.menuWished.connect(lambda place: self._colours.menu().popup(place))
        self.clip = ClipRow()
        self.clip.hide()
        self.clip.changed.connect(self.canvas.set_depths)
        self.bar = ColourBar(self.canvas)
        self._icons: list[tuple[QAction | QToolButton, str]] = []
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        for widget in (self._tool_bar(beside), self.strip, self.clip):
            layout.addWidget(widget)
        layout.addWidget(self.canvas, 1)
        self.canvas.installEventFilter(self)
        self.set_message()
        self._take_theme()

    def show_scene(self, scene: Scene, reset: bool = True) -> None:
        """Show a cloud; without `reset` it is seen from where the one before was: it is of the same frame."""
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
        """Drop the cloud and show a text in its place."""
        self.canvas.set_message(text)
        self.strip.set_title("3D")
        self.strip.set_text("")
        self.strip.set_legend([])
        self.bar.set_levels(None)

    def set_colour_by(self, colour_by: ColourBy) -> None:
        """Choose what the colours mean."""
        self.colour_by = ColourBy(colour_by)
        self._colours.show_choice(self.colour_by)
        self.colours_changed.emit()

    def set_lacking(self, lacking: Mapping[ColourBy, str]) -> None:
        """Which colours there are not, and why."""
        for choice in ColourBy:
            why = lacking.get(choice, "")
            self._colours.allow(choice, not why, f"{choice.hint}. {why}" if why else choice.hint)

    def set_point_size(self, size: int | None) -> None:
        """Side of a point in logical pixels; None: by the density of the cloud."""
        self._sizes.show_choice(size or 0)
        self.canvas.set_drawing(point_size=size, shaded=self._shading.isChecked())

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self.canvas.shutdown()

    def eventFilter(self, watched: object, event: QEvent) -> bool:
        """Keep the colour bar at the canvas's side."""
        if isinstance(event, QResizeEvent):
            least, most = _BAR_HEIGHTS
            room = self.canvas.height() - 2 * _BAR_MARGIN
            self.bar.setVisible(room >= least)
            self.bar.setFixedHeight(min(max(round(_BAR_SHARE * room), least), most))
            self.bar.move(self.canvas.width() - self.bar.width() - _BAR_MARGIN, _BAR_MARGIN)
        return False

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._take_theme()
            self.colours_changed.emit()

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        for item, name in self._icons:
            item.setIcon(theme.icon(name, self.palette()))
        self.strip.set_colours(colours)
        self.bar.set_colours(colours)

    def _tool_bar(self, beside: QAction) -> QToolBar:
        """Where there is too little room, what stands last is in the bar's extension."""
        bar = QToolBar("3D", self)
        bar.setIconSize(QSize(16, 16))
        self._colours = ChoiceButton(
            {choice: choice.text for choice in ColourBy}, "What the colours of the points mean", self.set_colour_by
        )
        bar.addWidget(self._colours)
        self._icons.append((self._colours, "ph.palette"))
        bar.addActions([self.raw, self.chosen_only])
        clip = self._switch(bar, "Clip", "ph.arrows-in-line-horizontal", "draw only depths between two handles", False)
        clip.toggled.connect(self._show_clip)
        bar.addSeparator()
        for name, (icon, hint) in _LOOKS.items():
            action = bar.addAction(name.capitalize(), partial(self.canvas.look, name))
            action.setToolTip(hint)
            self._icons.append((action, icon))
        bar.addSeparator()
        self._shading = self._switch(bar, "Shading", "ph.circle-half", "darken what lies behind its surroundings", True)
        self._shading.toggled.connect(lambda on: self.canvas.set_drawing(point_size=self.canvas.point_size, shaded=on))
        sizes = {size: f"{size} px" if size else "Auto size" for size in range(5)}
        self._sizes = ChoiceButton(
            sizes,
            "Size of a point; auto: as wide as the gap to its neighbours",
            lambda size: self.set_point_size(size or None),
        )
        bar.addWidget(self._sizes)
        self._icons.append((self._sizes, "ph.dots-nine"))
        bar.addAction(beside)
        return bar

    def _switch(self, bar: QToolBar, text: str, icon: str, hint: str, on: bool) -> QAction:
        action = bar.addAction(text)
        action.setCheckable(True)
        action.setChecked(on)
        action.setToolTip(f"{text}: {hint}")
        self._icons.append((action, icon))
        return action

    def _show_clip(self, on: bool) -> None:
        self.clip.setVisible(on)
        self.canvas.set_depths(*(self.clip.depths if on else (-math.inf, math.inf)))
