"""A cell of the linked views: it shows one content, which the user selects in the menu of its title."""

from __future__ import annotations

from collections.abc import Mapping, Set

from PySide6.QtCore import QPoint, QRect, QSize, Signal
from PySide6.QtGui import QAction, QBrush, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QMenu, QWidget

from ..base.theme import Colours
from .contents import (
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
from .layer_picture import LayerPicture
from .layers import Layer, Look, content_of, title_of, uses
from .layouts import CORRECT, CORRECT_VIEWS, GRIDS, LASTING, LAYOUTS, correct_places, grid_places
from .material import Material
from .pixel_items import BlockOverlay
from .spectrum_picture import SpectrumPicture
from .stages import StagePicker
from .view_cell import EventHandler, ViewCell

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

    def __init__(self, content: str, on_event: EventHandler, material: Material, overlay: BlockOverlay) -> None:
        super().__init__(on_event)
        self.content = content
        """Name of the content; `concrete` is the content that it currently resolves to."""
        self.concrete = ""
        self.picture = LayerPicture(self.view, self.bar)
        self._material = material
        self._overlay = overlay
        # fills of the blocks, and of those of the two sides, if divided and different from the current ones
        self._fills = [self.view.place(overlay.new_item()), self.view.add_layer(1), self.view.add_layer(1)]
        self._widget: SpectrumPicture | StagePicker | None = None
        self._look: Look | None = None
        self._needs_draw = False
        self._pixel: tuple[int, int] | None = None
        self._menu = content_menu(self)
        self._menu.triggered.connect(lambda action: self.chosen.emit(action.data()))
        self.strip.menuRequested.connect(self.open_menu)
        self.strip.doubleClicked.connect(self._menu.close)
        self.follow()

    @property
    def uses(self) -> frozenset[str]:
        """Parts of the material that the content depends on."""
        return uses(self.concrete, self._material)

    @property
    def range_kind(self) -> str:
        """Kind of the content's colour range; "" for none."""
        return content_of(self.concrete).range_kind

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
        """Change to another layer if the content resolves to another concrete content."""
        concrete = self._material.concrete(self.content)
        if concrete == self.concrete:
            return
        self.concrete = concrete
        self._replace_widget()
        content = content_of(concrete)
        self.picture.draw(Layer())
        self.set_legend([])
        self.strip.set_text("")
        self.strip.set_title(title_of(concrete, self._material))
        self.bar.set_unit(content.unit)
        self.view.shows_missing = content.stripes == "missing"
        self.view.shows_unsupported = content.stripes == "unsupported"
        self.view.has_lines = concrete != "extraction"  # its blocks differ from those of the frame
        for item in self._fills:
            item.setVisible(concrete == "colour")
        self.draw_again()

    def _replace_widget(self) -> None:
        self.strip.set_title_widget(None)
        if isinstance(self._widget, SpectrumPicture):
            self._widget.hide()
            self._widget.setParent(None)
            self._widget.deleteLater()
        self._widget = None
        if self.concrete == "spectrum":
            self._widget = SpectrumPicture(self.view)
        elif self.concrete == "extraction":
            self._widget = StagePicker(self.strip)
            self._widget.chosen.connect(self._material.stage.set_stage)
            self._widget.setFont(self.strip.font())
            self.strip.set_title_widget(self._widget)

    def redraw(self, parts: Set[str]) -> None:
        """Redraw if the content depends on any of these changed parts of the material."""
        if not self.uses.isdisjoint(parts):
            self.draw_again()

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y) and mark its value on the colour bar; None hides both."""
        self.show_cursor(pixel)
        self._pixel = pixel
        self._show_value()

    def _show_value(self) -> None:
        pixel = None if self._needs_draw or self.bar.isHidden() else self._pixel
        self.bar.set_value(None if pixel is None else self.picture.value_at(*pixel))

    def open_menu(self, place: QPoint | None = None) -> None:
        """Open the content menu."""
        self._menu.offer(self._material, self.content)
        self._menu.popup(self.strip.menu_position() if place is None else place)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Apply the theme's colours; `draw_again` draws the picture with them."""
        super().set_colours(colours, hatch)
        self._look = Look(colours, hatch)

    def draw_again(self) -> None:
        """Draw what has changed, at once or when the cell becomes visible."""
        self._needs_draw = not self.isVisible()
        if not self._needs_draw and self._look is not None:
            self._draw(self._look)
            self._show_value()

    def _draw(self, look: Look) -> None:
        material, run = self._material, self._material.run(self.concrete)
        layer = content_of(self.concrete).find(material, self.concrete, look)
        self.strip.set_title(title_of(self.concrete, material), None if run is None else run.colour)
        self.strip.set_text(layer.text)
        self.set_legend(layer.legend)
        self.picture.draw(layer)
        if self.concrete == "colour":
            self._draw_sides()
        if isinstance(self._widget, StagePicker):
            self._widget.show_stage(material.stage.stage)
            self._widget.set_hints(material.stage.hints)
        elif self._widget is not None:
            self._widget.set_colours(look.colours)
            self._widget.show_spectrum(material.spectrum)

    def _draw_sides(self) -> None:
        """Draw the blocks of the two sides in their columns, and the current blocks in the others."""
        column, blocks = self._material.swipe_column, self._material.side_blocks
        width = 0 if self._material.rgb is None else self._material.rgb.shape[1]
        spans = [(0, width), (width, width)] if column is None else [(0, column), (column, width)]
        own = [0, width]
        for index, (item, given, span) in enumerate(zip(self._fills[1:], blocks, spans, strict=True)):
            if column is None or given is None:
                item.clear()
                continue
            item.set_pixels(self._overlay.fills_of(*given))
            item.set_span(span)
            own[index] = column
        self._fills[0].set_span((own[0], own[1]) if own != [0, width] else None)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._needs_draw:
            self.draw_again()


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
