"""A cell of the linked views: it shows one content, which the user selects in the menu of its title."""

from __future__ import annotations

from collections.abc import Mapping, Set

from PySide6.QtCore import QPoint, QRect, QSize, Signal
from PySide6.QtGui import QAction, QBrush, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QMenu, QWidget

from ..base.theme import Colours
from .analysis_painters import SpectrumPainter, StageModel, StagePainter
from .colour_painters import ColourPainter, MaskPainter, StrengthPainter
from .contents import (
    COMPARABLE,
    DIFFERENCE,
    FLICKERS,
    RUNS,
    SIDES,
    TITLES,
    capital,
    checked,
    difference_of,
    operands_of,
    short_title,
)
from .depth_painters import DepthPainter, DifferencePainter, ExpectedErrorPainter
from .layouts import CORRECT, CORRECT_VIEWS, GRIDS, LASTING, LAYOUTS, correct_places, grid_places
from .painter import Material, Painter
from .pixel_items import BlockOverlay
from .view_cell import EventHandler, ViewCell

# The painter of each content.


class PainterFactory:
    """Factory of painters that share one material, one block overlay and one stage board."""

    def __init__(self, material: Material, overlay: BlockOverlay, board: StageModel) -> None:
        self.material = material
        self._overlay = overlay
        self._board = board

    def painter(self, content: str, cell: ViewCell) -> Painter:
        """Create the painter of a concrete content for a cell."""
        material = self.material
        if content == "colour":
            return ColourPainter(content, cell, material, self._overlay)
        if content == "extraction":
            return StagePainter(content, cell, material, self._board)
        if content in COMPARABLE:
            return DepthPainter(content, cell, material)
        if operands_of(content):
            return DifferencePainter(content, cell, material)
        return _PAINTERS[content](content, cell, material)


_PAINTERS: dict[str, type[Painter]] = {
    "expected-error": ExpectedErrorPainter,
    "strength": StrengthPainter,
    "creases": StrengthPainter,
    "extrapolated": MaskPainter,
    "invalid_mask": MaskPainter,
    "from_neighbours": MaskPainter,
    "spectrum": SpectrumPainter,
}


# The menu of a cell's title: all contents, with the current one checked.

_UNAVAILABLE_TEXTS = {
    "ground_truth": "This frame has no ground truth",
    "guide": "This frame has no guide: File > Load guide…",
    "from_neighbours": "No depth of neighbours is used: File > Use neighbours…",
    "error": "This frame has no ground truth to compare the result with",
}
_SIDE_TEXTS = {"a": "Side A", "b": "Side B"}


class ContentMenu(QMenu):
    """Menu of contents, refilled each time it opens, since runs change. The data of an action is a content's name."""

    def offer(self, material: Material, content: str) -> None:
        """Fill the menu with the available contents; check `content`."""
        self.clear()
        self._content = content
        for name in ("colour", "depth-in", "result"):
            self._add(self, name, TITLES[name])
        for depth in RUNS:
            if depth in material.names:
                self._add(self, depth, f"Run: {material.names[depth]}")
        self._add(self, "ground_truth", TITLES["ground_truth"], material.ground_truth is not None)
        self._add(self, "guide", TITLES["guide"], material.guide is not None)
        self.addSeparator()
        first, second = operands_of(material.concrete(DIFFERENCE)) or ("", "")
        pair = f"{short_title(first, material.names)} \N{MINUS SIGN} {short_title(second, material.names)}"
        self._add(self, DIFFERENCE, f"Difference ({pair})")
        self._add_differences(material)
        self._add(self, "error", TITLES["error"], material.ground_truth is not None)
        for name in ("expected-error", *FLICKERS):
            self._add(self, name, TITLES[name])
        self.addSeparator()
        for name in ("strength", "creases", "extraction", "extrapolated", "invalid_mask"):
            self._add(self, name, TITLES[name])
        self._add(self, "from_neighbours", TITLES["from_neighbours"], material.from_neighbours is not None)
        self._add(self, "spectrum", TITLES["spectrum"])
        self.addSeparator()
        for side, depth in zip(SIDES, material.sides, strict=True):
            self._add(self, side, f"{_SIDE_TEXTS[side]} of the comparison ({short_title(depth, material.names)})")

    def _add_differences(self, material: Material) -> None:
        depths = material.comparable()
        menu = self.addMenu("Difference of")
        for first in depths:
            others = menu.addMenu(capital(short_title(first, material.names)).replace("&", "&&"))
            for second in depths:
                if second != first:
                    self._add(others, difference_of(first, second), f"less {short_title(second, material.names)}")

    def _add(self, menu: QMenu, content: str, text: str, there: bool = True) -> QAction:
        action = menu.addAction(text.replace("&", "&&"))
        action.setData(content)
        action.setCheckable(True)
        action.setChecked(content == self._content)
        action.setEnabled(there)
        if not there:
            action.setToolTip(_UNAVAILABLE_TEXTS[content])
        return action


def content_menu(parent: QWidget) -> ContentMenu:
    """Create an empty menu."""
    menu = ContentMenu("Content of the view", parent)
    menu.setToolTipsVisible(True)
    return menu


class Cell(ViewCell):
    """View of one content; draws only while it is visible.

    Signals
    -------
    chosen(str)
        The user selected another content.
    """

    chosen = Signal(str)

    def __init__(self, content: str, on_event: EventHandler, studio: PainterFactory) -> None:
        super().__init__(on_event)
        self.content = content
        """Name of the content; `concrete` is the content that it currently resolves to."""
        self.concrete = ""
        self._studio = studio
        self._painter: Painter | None = None
        self._theme: tuple[Colours, QBrush] | None = None
        self._needs_draw = False
        self._pixel: tuple[int, int] | None = None
        self._menu = content_menu(self)
        self._menu.triggered.connect(lambda action: self.chosen.emit(action.data()))
        self.strip.menuRequested.connect(self.open_menu)
        self.strip.doubleClicked.connect(self._menu.close)
        self.follow()

    @property
    def painter(self) -> Painter:
        """Painter of the content."""
        assert self._painter is not None
        return self._painter

    def set_content(self, content: str) -> None:
        """Show another content.

        Raises
        ------
        ValueError
            If the content does not exist.
        """
        self.content = checked(content)
        self.follow()

    def follow(self) -> None:
        """Replace the painter if the content resolves to another concrete content."""
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
            self._draw_if_visible()

    def redraw(self, parts: Set[str]) -> None:
        """Redraw if the painter uses any of these changed parts of the material."""
        if not self.painter.uses.isdisjoint(parts):
            self._draw_if_visible()

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y) and mark its value on the colour bar; None hides both."""
        self.show_cursor(pixel)
        self._pixel = pixel
        self._show_value()

    def _show_value(self) -> None:
        pixel = None if self._needs_draw or self.bar.isHidden() else self._pixel
        self.bar.set_value(None if pixel is None else self.painter.value_at(*pixel))

    def open_menu(self, place: QPoint | None = None) -> None:
        """Open the content menu."""
        self._menu.offer(self._studio.material, self.content)
        self._menu.popup(self.strip.menu_position() if place is None else place)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Apply the theme's colours; `draw_again` draws the picture with them."""
        super().set_colours(colours, hatch)
        self._theme = colours, hatch
        self.painter.set_colours(colours, hatch)

    def draw_again(self) -> None:
        """Draw the picture, at once or when it becomes visible."""
        self._draw_if_visible()

    def _draw_if_visible(self) -> None:
        self._needs_draw = not self.isVisible()
        if not self._needs_draw:
            self.painter.draw()
            self._show_value()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._needs_draw:
            self._draw_if_visible()


# The area of the linked views: which cells are visible, how large and where.

_MIN_SIZE = QSize(256, 192)


class Sheet(QWidget):
    """Widget that arranges cells by a layout. A double-click on a cell's title enlarges the cell, or restores it.

    Parameters
    ----------
    cells : mapping of str to Cell
        Keyed by the names that layouts use; the sheet becomes their parent.

    Signals
    -------
    layoutChanged(str)
        Another of `LAYOUTS` is shown.
    placed()
        Cells were moved, or other cells are shown.
    """

    layoutChanged = Signal(str)
    placed = Signal()

    def __init__(self, cells: Mapping[str, Cell]) -> None:
        super().__init__()
        self.is_placing = False
        """Whether the cells are being moved; `placed` follows."""
        self.setObjectName("sheet")
        self.setMinimumSize(_MIN_SIZE)
        self._cells = cells
        self._aspect = 1.0
        self.layout_name = self.lasting = LAYOUTS[0]
        """The layout shown, and the one of `LASTING` that it is or returns to."""
        self._large = CORRECT_VIEWS[0]
        for name, cell in cells.items():
            # before it is made visible: without a parent it would be a window
            cell.setParent(self)
            cell.strip.doubleClicked.connect(lambda name=name: self._enlarge(name))
        self._arrange()

    @property
    def shown(self) -> tuple[Cell, ...]:
        """Cells of the current layout; the first sets the scale of the others."""
        return tuple(self._cells[name] for name in self._names())

    def set_aspect(self, aspect: float) -> None:
        """Arrange the cells for pictures of this aspect ratio (width over height)."""
        self._aspect = aspect
        self._place()

    def set_layout(self, name: str, lasting: str = "") -> None:
        """Arrange the cells by one of `LAYOUTS`; single views return to `lasting`, or to the last one by default."""
        if name not in LAYOUTS:
            raise ValueError(f"layout must be one of {', '.join(LAYOUTS)}, not {name!r}")
        self.lasting = next(one for one in (name, lasting or self.lasting, LAYOUTS[0]) if one in LASTING)
        if name == self.layout_name:
            return
        self.layout_name = name
        self._arrange()
        self.layoutChanged.emit(name)

    def toggle_layout(self, name: str) -> None:
        """Show a layout, or return to the last lasting one if it is shown."""
        self.set_layout(self.lasting if self.layout_name == name else name)

    def _enlarge(self, name: str) -> None:
        """Enlarge a small view, otherwise maximise or restore the view."""
        if self.layout_name == CORRECT and name != self._large:
            self._large = name
            self._arrange()
        else:
            self.toggle_layout(name)

    def _names(self) -> tuple[str, ...]:
        if self.layout_name == CORRECT:
            return (self._large, *(name for name in CORRECT_VIEWS if name != self._large))
        return GRIDS[self.layout_name][0] if self.layout_name in GRIDS else (self.layout_name,)

    def _arrange(self) -> None:
        shown = self._names()
        for name, cell in self._cells.items():
            cell.setVisible(name in shown)
        self._place()

    def _place(self) -> None:
        shown, size = self.shown, (self.width(), self.height())
        if self.layout_name == CORRECT:
            places = correct_places(len(shown) - 1, *size, self._aspect, shown[0].strip.height())
        else:
            places = grid_places(len(shown), GRIDS[self.layout_name][1] if len(shown) > 1 else 1, *size)
        self.is_placing = True
        for cell, place in zip(shown, places, strict=True):
            cell.setGeometry(QRect(*place))
        self.is_placing = False
        self.placed.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place()
