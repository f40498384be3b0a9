"""The linked views: cells over one frame with a common pan and zoom, each with a content that the user selects."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from ilf.data.frame import RGBDFrame

from ..base import theme
from ..state.parts import EVERY_PART, Part
from ..state.workspace import Workspace
from ..widgets.basics import Themed, lay_out
from .cell import Cell
from .colour_ranges import ColourRanges
from .colours import FULL
from .image_view import ImageView
from .interaction import Preview
from .layers import Layer
from .layouts import CELLS, Sheet
from .navigation import Navigation
from .shown_blocks import ShownBlocks
from .side_comparison import SideComparison
from .view_data import READ, Before, FormerState, ShownStage, ViewData

_MARKS = {"frame", "shows_missing", "invalid_mask", "by_hand", "result", "expected", "runs", "swipe"}
"""Data of which some pixels are striped."""


class LinkedViews(Themed, QWidget):
    """Views of one frame, up to four at a time, with one pan, one zoom and one crosshair.

    Each view has a named cell and shows the content that the user selects there. A small view beside a large one shows
    the same part of the frame at a smaller scale.

    Left-button events go to the handler of `navigation` first and pan if it rejects them; the middle button and space +
    left pan; the wheel zooms at the cursor; Alt+arrows, plus and minus pan and zoom by keyboard.

    Attributes
    ----------
    cells : dict
        Name -> Cell.
    data : ViewData
        What is shown.
    blocks : ShownBlocks
    ranges : ColourRanges
    sides : SideComparison
    sheet : Sheet
        The layout.
    navigation : Navigation
        Pointer and keys.
    transform : ViewTransform
        Where the views look.

    Signals
    -------
    cursorMoved(object)
        Pixel (x, y) under the pointer, as whole numbers, or None off the image.
    shownChanged()
        The visible contents changed: another layout, another content of a cell, or the views became visible again.
    rangeChanged()
        A colour range changed, or another cell is the one whose range is edited.
    pressed()
        A mouse button was pressed in a view.
    """

    cursorMoved = Signal(object)
    shownChanged = Signal()
    rangeChanged = Signal()
    pressed = Signal()

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self.data = ViewData(workspace)
        self._used_with_sides: frozenset[str] = frozenset()
        """Data that the shown cells used when the sides were last drawn."""
        self.cells = {name: Cell(content, self._handle, self.data) for name, (_, content) in CELLS.items()}
        self._views = [cell.view for cell in self.cells.values()]
        self.blocks = ShownBlocks(workspace, self.data, self._views)
        self.navigation = Navigation(self._views, self)
        self.transform = self.navigation.transform
        self._active = next(iter(self.cells))
        self._last_levels: tuple[float, float] | None = None
        self.ranges = ColourRanges(self.data, self)
        self.ranges.changed.connect(self._follow_ranges)
        self.sides = SideComparison(self.data, self.cells.values(), self._follow_sides)

        self._empty = QWidget()
        self.sheet = Sheet(self.cells)
        self.sheet.placed.connect(self._update_places)
        self.sheet.layoutChanged.connect(self.shownChanged)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._empty)
        self._pages.addWidget(self.sheet)
        lay_out(QVBoxLayout(self), self._pages)

        for name, cell in self.cells.items():
            cell.view.resized.connect(self._fit_views)
            cell.chosen.connect(lambda content, name=name: self.set_content(name, content))
        self.navigation.cursorMoved.connect(self._move_cursor)
        self._take_theme()

    def set_empty_page(self, page: QWidget) -> None:
        """Set the page that is shown while there is no frame."""
        lay_out(QVBoxLayout(self._empty), page)

    # the frame and its result

    def refresh(self, parts: Part = EVERY_PART) -> None:
        """Draw what has changed of the current document, or all that depends on another one."""
        shown = self.data.document or self.data.played
        changed = self.data.read(parts)
        if shown is not (self.data.document or self.data.played):
            self._begin_frame()
            self._draw()
        elif changed:
            self._draw(*changed)

    def _begin_frame(self) -> None:
        """Show another frame, fitted, with its own depth range; or none, only the page for that."""
        frame = self.data.frame
        self.set_preview(None)
        self.show_found(stage=ShownStage(self.data.stage.name))
        for cell in self.cells.values():
            cell.view.draw(Layer())  # those that are hidden would keep the former frame
        if frame is None:
            self.navigation.set_frame(None)
            self._pages.setCurrentWidget(self._empty)
            return
        height, width = frame.shape
        self.navigation.set_frame((width, height))
        self.sides.set_frame(width, height)
        self.ranges.reset_for_frame()
        self._pages.setCurrentWidget(self.sheet)
        self.sheet.set_aspect(self.transform.aspect)

    def show_played(self, frame: RGBDFrame, depth: NDArray[np.float32] | None, text: str, before: Before) -> None:
        """Show the next frame of a sequence that is played: where the views were, in the colours of the first one.

        Parameters
        ----------
        frame : RGBDFrame
        depth : ndarray, optional
            Completed depth [m], float32 (H, W).
        text : str
            How it was completed.
        before : Before
        """
        former = self.data.frame
        same_size = former is not None and former.shape == frame.shape
        begins = self.data.played is None or not same_size
        place = self.transform.place if same_size else None
        self.data.play(frame, depth, text, before)
        if begins:
            self._begin_frame()
            self.blocks.draw(EVERY_PART)
            if place is not None:
                self.transform.look_at(*place)
        self._draw(*READ, "before")

    def keep_pictures(self, on: bool) -> None:
        """Keep the pictures while no frame is open and frames are played; with False, show that none is open."""
        self.data.keeps_picture = on
        if not on:
            self.refresh()

    def show_found(self, **found: Any) -> None:
        """Show what was found or chosen for the views, by its name in `ViewData`."""
        for name, value in found.items():
            setattr(self.data, name, value)
        self._draw(*("result" if name == "under_way" else name for name in found))

    def look_back(self, former: FormerState | None) -> None:
        """Show other blocks and depth in place of those of the current document; None for its own."""
        self.data.former = former
        self.refresh()
        self.blocks.draw(EVERY_PART)

    def _draw(self, *changed: str) -> None:
        """Redraw the cells that use any of these data, or all cells."""
        if self.data.ranges["depth"].mode == FULL and (not changed or "result" in changed):
            self.ranges.update_for_result()
        for cell in self.cells.values():
            cell.follow()
            if not changed or not (cell.uses | _MARKS).isdisjoint(changed):
                cell.draw_again()
        if self.sides.is_divided and (not changed or not {"runs", "result"}.isdisjoint(changed)):
            self.sides.show_divider()
            self.blocks.draw(Part.LABELS)
        levels = self.ranged.bar.levels
        if levels != self._last_levels:
            self._last_levels = levels
            self.rangeChanged.emit()

    def _follow_sides(self, *parts: str) -> None:
        """Draw the changed sides; they may need data that no view has used before."""
        self._draw(*parts)
        self.blocks.draw(Part.LABELS)
        used = frozenset().union(*(cell.uses for cell in self.sheet.shown))
        if used != self._used_with_sides:
            self._used_with_sides = used
            self.shownChanged.emit()

    # contents

    def contents(self) -> dict[str, str]:
        """Name of each cell -> what it shows."""
        return {name: cell.content for name, cell in self.cells.items()}

    def set_content(self, cell: str, content: str) -> None:
        """Show another content in a cell, by a name from `contents`.

        Raises
        ------
        ValueError
            If the cell or content does not exist.
        """
        if cell not in self.cells:
            raise ValueError(f"cell must be one of {', '.join(self.cells)}, not {cell!r}")
        if content != self.cells[cell].content:
            self.cells[cell].set_content(content)
            self.sides.show_divider()
            self.shownChanged.emit()
            self.rangeChanged.emit()

    def reset_contents(self) -> None:
        """Restore the default content of every cell."""
        for name, (_, content) in CELLS.items():
            self.set_content(name, content)

    def shows(self, part: str) -> bool:
        """Whether a visible cell uses a part of the data, such as "edges"."""
        return any(cell.isVisible() and part in cell.uses for cell in self.cells.values())

    @property
    def active(self) -> Cell:
        """The cell that was last clicked, or the first one if that is hidden."""
        cell = self.cells[self._active]
        return cell if cell in self.sheet.shown else self.sheet.shown[0]

    @property
    def ranged(self) -> Cell:
        """The cell whose colour range is edited: the active one if it has a range, else the first that has."""
        return next((cell for cell in (self.active, *self.sheet.shown) if cell.range_kind), self.active)

    def choose_content(self) -> None:
        """Open the menu of the cell under the pointer, or of the active one."""
        under = (cell for cell in self.sheet.shown if cell.underMouse())
        next(under, self.active).open_menu()

    # blocks, selection, preview

    def set_preview(self, preview: Preview | None) -> None:
        """Draw the preview of a tool in all views; None removes it."""
        for view in self._views:
            view.preview.set_preview(preview)

    def _follow_ranges(self) -> None:
        self._draw("levels")
        self.rangeChanged.emit()

    # layout

    def _update_places(self) -> None:
        """Update cursor and sizes after cells were moved or others are shown."""
        for cell in self.cells.values():
            if cell not in self.sheet.shown:
                cell.point_at(None)
        self._fit_views()
        for cell in self.sheet.shown:
            cell.point_at(self.navigation.pixel)

    def _fit_views(self) -> None:
        """Apply the transform to views of their current size."""
        views = [cell.view for cell in self.sheet.shown]
        sizes = [view.viewport().size() for view in views]
        self.transform.set_view(sizes[0].width(), sizes[0].height())
        for view, size in zip(views, sizes, strict=True):
            view.share = self.transform.share(size.width(), size.height())
        self.navigation.show_place()

    def _move_cursor(self, pixel: tuple[int, int] | None) -> None:
        for cell in self.sheet.shown:
            cell.point_at(pixel)
        self.cursorMoved.emit(pixel)

    def _handle(self, view: ImageView, event: QEvent) -> bool:
        """Handle the events of all views."""
        if event.type() == QEvent.Type.MouseButtonPress:
            self.activate(view)
            self.pressed.emit()
        return self.sides.handle(view, event) or self.navigation.handle(view, event)

    def activate(self, view: ImageView) -> None:
        """Make a view the active one, if it is one of these."""
        name = next((name for name, cell in self.cells.items() if cell.view is view), self._active)
        if name != self._active:
            self._active = name
            self.rangeChanged.emit()

    # drawing

    def _take_theme(self) -> None:
        self.data.colours = theme.colours(self.palette())
        for cell in self.cells.values():
            cell.draw_again()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shownChanged.emit()
