"""A cell of the linked views: a place for one content, which the user chooses in the menu of its title."""

from __future__ import annotations

from collections.abc import Set

from PySide6.QtCore import QPoint, Signal
from PySide6.QtGui import QBrush, QShowEvent

from gui.theme import Colours
from gui.views.view_cell import EventHandler, ViewCell

from .making import Studio
from .menu import content_menu
from .names import checked
from .painter import Painter


class Cell(ViewCell):
    """Draws its content only for those who look at it.

    Signals
    -------
    chosen(str)
        The user wants another content.
    """

    chosen = Signal(str)

    def __init__(self, content: str, on_event: EventHandler, studio: Studio) -> None:
        super().__init__(on_event)
        self.content = content
        """What is to be shown; `concrete` is what that stands for as things are."""
        self.concrete = ""
        self._studio = studio
        self._painter: Painter | None = None
        self._theme: tuple[Colours, QBrush] | None = None
        self._is_late = False
        self._pixel: tuple[int, int] | None = None
        self._menu = content_menu(self)
        self._menu.triggered.connect(lambda action: self.chosen.emit(action.data()))
        self.strip.menuWished.connect(self.open_menu)
        self.strip.doubleClicked.connect(self._menu.close)
        self.follow()

    @property
    def painter(self) -> Painter:
        """What draws the content."""
        assert self._painter is not None
        return self._painter

    def set_content(self, content: str) -> None:
        """Show another content.

        Raises
        ------
        ValueError
            If there is no such content.
        """
        self.content = checked(content)
        self.follow()

    def follow(self) -> None:
        """Take another painter if the content stands for something else now."""
        concrete = self._studio.material.concrete(self.content)
        if concrete == self.concrete:
            return
        if self._painter is not None:
            self._painter.leave()
            self.bar.set_levels(None)
            self.set_legend([])
            self.view.set_message("")
            self.view.set_picture(None)
            self.strip.set_text("")
        self.concrete = concrete
        self._painter = self._studio.painter(concrete, self)
        if self._theme is not None:
            self._painter.set_colours(*self._theme)
            self._draw_if_seen()

    def redraw(self, parts: Set[str]) -> None:
        """Some parts of the material have changed."""
        if not self.painter.uses.isdisjoint(parts):
            self._draw_if_seen()

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y), and mark on the colour bar what there is; None for nothing."""
        self.show_cursor(pixel)
        self._pixel = pixel
        self._show_value()

    def _show_value(self) -> None:
        pixel = None if self._is_late or self.bar.isHidden() else self._pixel
        self.bar.set_value(None if pixel is None else self.painter.value_at(*pixel))

    def open_menu(self, place: QPoint | None = None) -> None:
        """Let the user choose the content."""
        self._menu.offer(self._studio.material, self.content)
        self._menu.popup(self.strip.menu_place() if place is None else place)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Take the colours of the theme."""
        super().set_colours(colours, hatch)
        self._theme = colours, hatch
        self.painter.set_colours(colours, hatch)
        self._draw_if_seen()

    def _draw_if_seen(self) -> None:
        self._is_late = not self.isVisible()
        if not self._is_late:
            self.painter.draw()
            self._show_value()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._is_late:
            self._draw_if_seen()
