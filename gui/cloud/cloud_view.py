"""The 3D view of a point cloud: orbit, pan, zoom, and ways to colour it. Drawn by the numpy splat."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu, QToolBar, QToolButton, QVBoxLayout, QWidget

from gui import theme
from gui.cloud.canvas import EMPTY_TEXT, CloudCanvas, Points, Rgb
from gui.views.colour_maps import depth_table
from ilf.drawing.levels import robust_depth_levels, to_indices

Choice = TypeVar("Choice")


class ColourBy(StrEnum):
    """What the points' colours mean."""

    COLOUR = "colour"
    DEPTH = "depth"
    FILLED = "raw vs filled"


class CloudView(QWidget):
    """A point cloud with its view buttons. Drag to orbit, shift or right drag to pan, wheel to zoom."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.canvas = CloudCanvas(self)
        self.setFocusProxy(self.canvas)
        self._colours: Rgb = np.empty((0, 3), np.uint8)
        self._filled: NDArray[np.bool_] | None = None
        self._guessed: NDArray[np.bool_] | None = None
        self._colour_by = ColourBy.COLOUR
        self._icons: list[tuple[QAction | QToolButton, str]] = []
        self._bar = self._tool_bar()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self._bar)
        layout.addWidget(self.canvas, 1)
        self._refresh_theme()

    def set_cloud(self, points: Points, colours: Rgb, reset: bool = True) -> None:
        """Show a cloud.

        Parameters
        ----------
        points : ndarray
            float32 (N, 3) [m], x right, y down, z forward, as the depth camera saw it.
        colours : ndarray
            uint8 (N, 3), red first.
        reset : bool
            False keeps the point of view: another cloud of the same frame.

        Raises
        ------
        ValueError
            If the shapes are not (N, 3) both.
        """
        points = np.ascontiguousarray(points, np.float32)
        if points.ndim != 2 or points.shape[1] != 3 or points.shape != colours.shape:
            raise ValueError(f"points and colours must both be (N, 3), not {points.shape} and {colours.shape}")
        self._colours, self._filled, self._guessed = colours, None, None
        self.canvas.set_points(points, reset)
        self._recolour()

    def set_filled(self, mask: NDArray[np.bool_] | None, guessed: NDArray[np.bool_] | None = None) -> None:
        """Say which points of the present cloud were filled, and which of those are guesses, bool (N,); None: none.

        Raises
        ------
        ValueError
            If the mask's length is not the number of points.
        """
        if mask is not None and mask.shape != (len(self.canvas.points),):
            raise ValueError(f"filled must be ({len(self.canvas.points)},), not {mask.shape}")
        self._filled, self._guessed = mask, guessed
        self._recolour()

    def set_message(self, text: str = EMPTY_TEXT) -> None:
        """Drop the cloud and show a text in its place."""
        self._filled = self._guessed = None
        self._colours = np.empty((0, 3), np.uint8)
        self.canvas.message = text
        self.canvas.set_points(np.empty((0, 3), np.float32), reset=True)
        self._recolour()

    def set_colour_by(self, colour_by: ColourBy) -> None:
        """Choose what the colours mean."""
        self._colour_by = ColourBy(colour_by)
        self._colours_shown.show_choice(self._colour_by)
        self._recolour()

    def set_point_size(self, size: int | None) -> None:
        """Side of a point in logical pixels; None: by the density of the cloud."""
        self._sizes_shown.show_choice(size or 0)
        self.canvas.set_drawing(point_size=size, shaded=self._shading.isChecked())

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._refresh_theme()

    def _recolour(self) -> None:
        points, colours = self.canvas.points, self._colours
        caption = f"{len(points):,} points"
        if self._colour_by is ColourBy.DEPTH and len(points):
            low, high = robust_depth_levels(points[:, 2])
            colours = depth_table("turbo")[to_indices(points[:, 2], low, high), :3]
            caption += f", blue {low:.2f} m to red {high:.2f} m"
        elif self._colour_by is ColourBy.FILLED and self._filled is not None:
            shades = theme.colours(self.palette())
            colours = colours.copy()
            colours[self._filled] = shades.accent.red(), shades.accent.green(), shades.accent.blue()
            caption += f", {np.count_nonzero(self._filled):,} filled"
            if self._guessed is not None and self._guessed.any():
                colours[self._guessed] = shades.warning.red(), shades.warning.green(), shades.warning.blue()
                caption += f", of these {np.count_nonzero(self._guessed):,} guessed"
        self.canvas.set_colours(colours, caption)

    def _refresh_theme(self) -> None:
        for item, name in self._icons:
            item.setIcon(theme.icon(name, self.palette()))
        self._recolour()

    def _tool_bar(self) -> QToolBar:
        bar = QToolBar(self)
        bar.setIconSize(QSize(16, 16))
        reset = bar.addAction("Reset", lambda: self.canvas.look("home"))
        reset.setToolTip("Show the whole cloud (R, Home, double-click)")
        self._icons.append((reset, "ph.house"))
        for name, hint in (("front", "as the depth camera saw it"), ("top", "from above"), ("side", "from the right")):
            action = bar.addAction(name.capitalize(), partial(self.canvas.look, name))
            action.setToolTip(f"Look {hint}" if name != "front" else f"Look {hint}: along its axis")
        bar.addSeparator()
        colours = {choice: choice.capitalize() for choice in ColourBy}
        self._colours_shown = _ChoiceButton(colours, "What the colours of the points mean", self.set_colour_by)
        sizes = {size: f"{size} px" if size else "Auto size" for size in range(5)}
        self._sizes_shown = _ChoiceButton(
            sizes,
            "Size of a point; auto: as wide as the gap to its neighbours",
            lambda size: self.set_point_size(size or None),
        )
        for button, icon in ((self._colours_shown, "ph.palette"), (self._sizes_shown, "ph.dots-nine")):
            bar.addWidget(button)
            self._icons.append((button, icon))
        self._shading = bar.addAction("Shading")
        self._shading.setCheckable(True)
        self._shading.setChecked(True)
        self._shading.setToolTip("Shading: darken what lies behind its surroundings (eye-dome lighting)")
        self._shading.toggled.connect(lambda on: self.canvas.set_drawing(point_size=self.canvas.point_size, shaded=on))
        self._icons.append((self._shading, "ph.circle-half"))
        return bar


class _ChoiceButton(QToolButton, Generic[Choice]):
    """A button that opens a menu of choices and shows the present one.

    Parameters
    ----------
    texts : mapping
        Choice -> what the user reads; the first is the present one.
    """

    def __init__(self, texts: Mapping[Choice, str], hint: str, chosen: Callable[[Choice], None]) -> None:
        super().__init__()
        self.setToolTip(hint)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.setAutoRaise(True)
        self.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        menu = QMenu(self)
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
        # the bar keeps still when the choice changes; the icon comes with the theme
        self.setMinimumWidth(max(widths) + self.iconSize().width())
        self.show_choice(next(iter(texts)))

    def show_choice(self, choice: Choice) -> None:
        """Mark a choice as the present one."""
        self._choices[choice].setChecked(True)
        self.setText(f"{self._choices[choice].text()} \u25be")
