"""The linked views: cells over one frame with a common pan and zoom, each with a content that the user selects."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from ilf.drawing.blocks import InnerPoint, inner_points
from ilf.segmentation.edges.frame_edges import FrameEdges

from ..base import theme
from ..widgets.basics import Themed
from .cell import Cell
from .colour_ranges import ColourRanges
from .image_view import ImageView, ViewTransform
from .interaction import PointerHandler, Preview
from .layouts import CELLS
from .material import Before, Material, ShownDepth, ShownRun, Spectrum
from .navigation import Navigation
from .pixel_items import BlockOverlay
from .scene_items import missing_brush
from .screen_layers import ScreenLayers
from .sheet import Sheet
from .side_comparison import SideComparison
from .stages import StageModel

_PARTS = {"earlier": "runs", "result_number": "runs", "error_is_outdated": "expected", "is_running": "result"}
"""Parts that some data belong to; the others are parts of their own."""
_MARKS = {"invalid_mask", "by_hand", "suspect", "unsupported"}
"""Data that are striped."""


class LinkedViews(Themed, QWidget):
    """Views of one frame, up to four at a time, with one pan, one zoom and one crosshair.

    Each view has a named cell and shows the content that the user selects there. A small view beside a large one shows
    the same part of the frame at a smaller scale.

    Left-button events go to the pointer handler first and pan if it rejects them; the middle button and space + left
    pan; the wheel zooms at the cursor; Alt+arrows, plus and minus pan and zoom by keyboard.

    Attributes
    ----------
    cells : dict
        Name -> Cell.
    material : Material
        Data of the frame shown.
    ranges : ColourRanges
    sides : SideComparison
    extraction : StageModel

    Signals
    -------
    cursorMoved(object)
        Pixel (x, y) under the pointer, as whole numbers, or None off the image.
    contextMenuRequested(QPoint, float, float)
        Place on the screen and image coordinates x, y of a right click or the menu key.
    layoutChanged(str)
        The layout now shown, also when a double-click on a title changed it.
    shownChanged()
        The visible contents changed: another layout, another content of a cell, or the views became visible again.
    rangeChanged()
        A colour range changed, or another cell is the one whose range is edited.
    pressed()
        A mouse button was pressed in a view.
    """

    cursorMoved = Signal(object)
    contextMenuRequested = Signal(QPoint, float, float)
    layoutChanged = Signal(str)
    shownChanged = Signal()
    rangeChanged = Signal()
    pressed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._transform = ViewTransform()
        self._navigation = Navigation(self._transform, self)
        self.extraction = StageModel(self)
        self.material = Material(self.extraction)
        self._given: dict[str, Any] = {}
        """Data of the frame as they were given."""
        self._used_with_sides: frozenset[str] = frozenset()
        """Parts that the shown cells used when the sides were last drawn."""
        self._names: Mapping[int, str] | None = None
        self._shows_missing = False
        self._overlay = BlockOverlay(1)
        self.cells = {
            name: Cell(content, self._handle, self.material, self._overlay) for name, (_, content) in CELLS.items()
        }
        self._views = [cell.view for cell in self.cells.values()]
        self._layers = ScreenLayers()
        self._active = next(iter(self.cells))
        self._last_levels: tuple[float, float] | None = None
        self.ranges = ColourRanges(self.material, self)
        self.ranges.changed.connect(self._follow_ranges)
        self.sides = SideComparison(self.material, self._views, self._content_of, self)
        self.sides.changed.connect(self._follow_sides)

        self._empty = QWidget()
        self._sheet = Sheet(self.cells)
        self._sheet.placed.connect(self._update_places)
        self._sheet.layoutChanged.connect(self.layoutChanged)
        self._sheet.layoutChanged.connect(self.shownChanged)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._empty)
        self._pages.addWidget(self._sheet)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._pages)

        for name, cell in self.cells.items():
            cell.view.resized.connect(self._follow_size)
            cell.chosen.connect(lambda content, name=name: self.set_content(name, content))
        self.extraction.changed.connect(lambda: self._changed("stage"))
        self._navigation.cursorMoved.connect(self._move_cursor)
        self._navigation.contextMenuRequested.connect(self.contextMenuRequested)
        self._navigation.transformChanged.connect(self._show_transform)
        self._navigation.cursorShapeChanged.connect(self._set_cursor_shape)
        self._old_pictures: list[Cell] = []
        """Cells whose pictures have the colours of the last theme."""
        self._draw_timer = QTimer(self, singleShot=True, interval=0)
        self._draw_timer.timeout.connect(self._draw_next)
        self._take_theme()

    def set_empty_page(self, page: QWidget) -> None:
        """Set the page that is shown while there is no frame."""
        self._pages.insertWidget(0, page)
        if self._pages.currentWidget() is self._empty:
            self._pages.setCurrentWidget(page)
        self._pages.removeWidget(self._empty)
        self._empty.deleteLater()
        self._empty = page

    # the frame and its result

    def set_frame(
        self, rgb: NDArray[np.uint8], measured: NDArray[np.float32], outside_view: NDArray[np.bool_] | None = None
    ) -> None:
        """Show a new frame, fitted, with its own depth range; clear blocks, result, invalid mask and preview.

        Parameters
        ----------
        rgb : ndarray
            Colour, uint8 (H, W, 3).
        measured : ndarray
            Depth [m], float32 (H, W), NaN = missing; the invalid mask is shown by `show_data`.
        outside_view : ndarray, optional
            Pixels that the depth camera could not see, bool (H, W).

        Raises
        ------
        ValueError
            If the shapes differ.
        """
        if rgb.shape != (*measured.shape, 3):
            raise ValueError(f"colour {rgb.shape} and depth {measured.shape} do not show the same pixels")
        height, width = measured.shape
        self._forget()
        self.material.rgb = rgb
        self.material.measured = self.material.depth_in = measured
        self._transform.set_frame(width, height)
        self._navigation.set_frame((width, height))
        for view in self._views:
            view.set_frame_size(width, height)
        self.sides.set_frame(width, height)
        self.ranges.reset_for_frame()
        self._pages.setCurrentWidget(self._sheet)
        self._sheet.set_aspect(self._transform.aspect)
        self._changed()
        self.material.outside_view = outside_view
        self._show_marks()

    def clear(self) -> None:
        """Show no frame, only the page for that."""
        self._navigation.set_frame(None)
        self._forget()
        self._pages.setCurrentWidget(self._empty)
        self._changed()

    def _forget(self) -> None:
        self.material.forget()
        self._given.clear()
        self._overlay.clear()
        self._layers.set_blocks(None)
        self.set_selected(())
        self.set_to_check(())
        self._show_marks()
        self._write_names()
        self.set_preview(None)
        self.extraction.show_message("")

    def set_result(
        self,
        depth_out: NDArray[np.float32] | None,
        extrapolated: NDArray[np.bool_] | None = None,
        stale: NDArray[np.bool_] | None = None,
    ) -> None:
        """Show completed depth [m], float32 (H, W), NaN where not recovered, and its difference; None for none.

        The masks `extrapolated` and `stale`, bool (H, W), mark extrapolated pixels and pixels from an older state of
        their block. Only changes since the last call are redrawn; the arrays may be the same ones, changed in place.

        Raises
        ------
        ValueError
            If there is no frame or the shape is not its shape.
        """
        self._check(depth_out, "a result")
        self.material.result = None if depth_out is None else ShownDepth(depth_out, extrapolated, stale)
        self.ranges.update_for_result()
        self._changed("result")

    def show_played(
        self,
        rgb: NDArray[np.uint8],
        depth_in: NDArray[np.float32],
        depth_out: NDArray[np.float32] | None,
        text: str,
        before: Before,
    ) -> None:
        """Show the next frame of a sequence that is played: where the views were, in the colours of the first one.

        Parameters
        ----------
        rgb : ndarray
            Colour, uint8 (H, W, 3).
        depth_in : ndarray
            Depth [m], float32 (H, W), NaN = missing.
        depth_out : ndarray, optional
            Completed depth [m], float32 (H, W).
        text : str
            How it was completed.
        before : Before
        """
        material = self.material
        same_size = material.measured is not None and depth_in.shape == material.measured.shape
        if not material.played or not same_size:
            place = self.place if same_size else None
            self.set_frame(rgb, depth_in)
            if place is not None:
                self.set_place(*place)
            material.played = True
        material.rgb, material.measured, material.depth_in = rgb, depth_in, depth_in
        material.result = None if depth_out is None else ShownDepth(depth_out)
        self.show_data(moment=text, before=before)
        self._changed("frame", "invalid_mask", "result", "moment")
        self._show_marks()

    def show_data(self, **data: Any) -> None:
        """Show data of the frame by their names in `Material`; what has not changed is not drawn again.

        Raises
        ------
        ValueError
            If there is no frame or a shape is not its shape.
        """
        material = self.material
        changed = {name: value for name, value in data.items() if not _are_same(self._given.get(name), value)}
        for name, value in changed.items():
            self._check(value, name.replace("_", " "))
        for name, value in changed.items():
            self._given[name] = value
            if name == "invalid_mask":
                material.set_invalid_mask(value)
            else:
                setattr(material, name, value)
        if changed:
            self._changed(*(_PARTS.get(name, name) for name in changed))
        if not _MARKS.isdisjoint(changed):
            self._show_marks()

    def set_missing_shown(self, on: bool) -> None:
        """Set whether missing depth is striped over the colour image."""
        self._shows_missing = on
        self._show_marks()

    def _show_marks(self) -> None:
        material, measured, unsupported = self.material, self.material.measured, self.material.unsupported
        self._layers.set_masks(
            {
                "missing": ~np.isfinite(measured) if self._shows_missing and measured is not None else None,
                "outside view": material.outside_view,
                "unsupported": unsupported if unsupported is not None and unsupported.any() else None,
                "suspect": material.suspect,
                "invalid": material.invalid_mask,
                "by hand": material.by_hand,
            }
        )
        for cell in self.cells.values():
            cell.set_stripe_legend(self._layers.striped_in(cell.view))

    def _check(self, data: Any, what: str) -> None:
        """Raise ValueError if data, or the arrays in them, are not of the frame's shape."""
        if isinstance(data, Spectrum):  # has no pixels of the frame
            return
        if isinstance(data, tuple):
            for one in data:
                self._check(one, what)
        elif isinstance(data, (ShownRun, FrameEdges)):
            self._check(data.depth if isinstance(data, ShownRun) else data.strength, what)
        elif isinstance(data, np.ndarray):
            measured = self.material.measured
            if measured is None or data.shape != measured.shape:
                raise ValueError(f"{what} of shape {data.shape} does not belong to the frame shown")

    def _changed(self, *parts: str) -> None:
        """Redraw the cells that use any of these parts, or all cells."""
        for cell in self.cells.values():
            cell.follow()
            cell.redraw(set(parts) or cell.uses)
        if not parts or not {"runs", "result"}.isdisjoint(parts):
            self.sides.update_labels()
        levels = self.ranged.bar.levels
        if levels != self._last_levels:
            self._last_levels = levels
            self.rangeChanged.emit()

    def _follow_sides(self, part: str) -> None:
        """Draw the changed sides; they may need data that no view has used before."""
        self._changed(part)
        used = frozenset().union(*(cell.uses for cell in self._sheet.shown))
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
            self._layers.show([cell.view for cell in self._sheet.shown])
            self._show_marks()
            self.sides.swipe.show()
            self.shownChanged.emit()
            self.rangeChanged.emit()

    def reset_contents(self) -> None:
        """Restore the default content of every cell."""
        for name, (_, content) in CELLS.items():
            self.set_content(name, content)

    def shows(self, part: str) -> bool:
        """Whether a visible cell uses a part of the material, such as "edges"."""
        return any(cell.isVisible() and part in cell.uses for cell in self.cells.values())

    @property
    def shown(self) -> tuple[Cell, ...]:
        """The cells of the current layout, even while the views are hidden."""
        return self._sheet.shown

    @property
    def active(self) -> Cell:
        """The cell that was last clicked, or the first one if that is hidden."""
        cell = self.cells[self._active]
        return cell if cell in self._sheet.shown else self._sheet.shown[0]

    @property
    def ranged(self) -> Cell:
        """The cell whose colour range is edited: the active one if it has a range, else the first that has."""
        return next((cell for cell in (self.active, *self._sheet.shown) if cell.range_kind), self.active)

    def take_focus(self) -> None:
        """Give the keyboard focus to the active view."""
        self.active.view.setFocus()

    def choose_content(self) -> None:
        """Open the menu of the cell under the pointer, or of the active one."""
        under = (cell for cell in self._sheet.shown if cell.underMouse())
        next(under, self.active).open_menu()

    # blocks, selection, preview

    def set_blocks(self, labels: NDArray[np.int32], colour_table: NDArray[np.uint8]) -> None:
        """Draw a label map over the colour view.

        Parameters
        ----------
        labels : ndarray
            int32 (H, W), 0 = no block.
        colour_table : ndarray
            uint8 (N + 1, 4) RGBA by label; alpha 0 hides a block.

        Raises
        ------
        ValueError
            If there is no frame, the shapes differ or a label has no colour.
        """
        self._check(labels, "a label map")
        self._overlay.set_blocks(labels, colour_table)
        self._layers.set_blocks(self._overlay.labels, self._overlay.colours)
        self._write_names()

    def add_colours(self, colour_table: NDArray[np.uint8]) -> None:
        """Set a colour table that extends the current one to further labels."""
        self._overlay.add_colours(colour_table)
        self._layers.add_colours(self._overlay.colours)

    def update_blocks_region(self, rows: slice, columns: slice, labels: NDArray[np.int32]) -> None:
        """Replace the labels of a box by an int32 array of the box's shape; its labels must have colours."""
        self._overlay.update_region((rows, columns), labels)
        self._layers.update_region((rows, columns))

    def set_overlay_opacity(self, opacity: float) -> None:
        """Set the opacity of the blocks' fills, 0-1."""
        self._overlay.set_opacity(opacity)
        self._changed("swipe")

    def set_contours_only(self, on: bool) -> None:
        """Set whether blocks are drawn as coloured outlines without fill."""
        self._overlay.set_filled(not on)
        self._changed("swipe")
        self._layers.set_in_colours(on)

    def set_block_names(self, names: Mapping[int, str] | None) -> None:
        """Write names by label inside the current blocks; None for none."""
        self._names = names
        self._write_names()

    def set_selected(self, labels: Iterable[int]) -> None:
        """Draw a wider line around these blocks in all views."""
        self._layers.set_selected(labels)

    def set_to_check(self, labels: Iterable[int]) -> None:
        """Outline blocks that need checking, in a colour of their own, in all views."""
        self._layers.set_to_check(labels)

    def set_preview(self, preview: Preview | None) -> None:
        """Draw the preview of a tool in all views; None removes it."""
        for view in self._views:
            view.preview.set_preview(preview)

    def set_pointer_handler(self, handler: PointerHandler | None) -> None:
        """Send pointer events of all views to a tool; None lets the left button pan."""
        self._navigation.set_handler(handler)

    def set_space(self, held: bool) -> None:
        """Set whether the space key is held anywhere: the left button then pans."""
        self._navigation.set_space(held)

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y), as if the pointer were there; None hides it."""
        self._navigation.forget_pointer()
        self._navigation.point_at(pixel)

    @property
    def pixel(self) -> tuple[int, int] | None:
        """The pixel (x, y) with the crosshair; None for none."""
        return self._navigation.pixel

    def _follow_ranges(self) -> None:
        self._changed("levels")
        self.rangeChanged.emit()

    # transform and layout

    def fit(self) -> None:
        """Show the whole frame."""
        self._transform.fit()
        self._show_transform()

    def one_to_one(self) -> None:
        """Show one image pixel per device pixel around the current centre."""
        self._transform.set_scale(1 / self.devicePixelRatioF())
        self._show_transform()

    def zoom_to(self, rows: slice, columns: slice) -> None:
        """Show a box of the image with some margin around it."""
        self._transform.show(columns.start, rows.start, columns.stop, rows.stop)
        self._show_transform()

    @property
    def place(self) -> tuple[float, float, float] | None:
        """Image coordinates x, y [px] in the middle, and screen pixels per image pixel; None for the whole frame."""
        transform = self._transform
        return None if transform.fitted else (transform.x, transform.y, transform.scale)

    def set_place(self, x: float, y: float, scale: float) -> None:
        """Show a place of the frame, as returned by `place`."""
        self._transform.look_at(x, y, scale)
        self._show_transform()

    @property
    def layout_name(self) -> str:
        """Name of the layout shown, one of `LAYOUTS`."""
        return self._sheet.layout_name

    @property
    def pixel_size(self) -> float:
        """Image pixels per screen pixel in a large view."""
        return 1 / self._transform.scale

    @property
    def lasting_layout(self) -> str:
        """The layout of `LASTING` that is shown, or that the current one returns to."""
        return self._sheet.lasting

    def set_layout(self, name: str, lasting: str = "") -> None:
        """Arrange the views by one of `LAYOUTS`; single views return to `lasting`, or to the last one by default."""
        self._sheet.set_layout(name, lasting)

    def toggle_layout(self, name: str) -> None:
        """Show a layout, or return to the last lasting one if it is shown."""
        self._sheet.toggle_layout(name)

    def _update_places(self) -> None:
        """Update cursor and sizes after cells were moved or others are shown."""
        for cell in self.cells.values():
            if cell not in self._sheet.shown:
                cell.point_at(None)
        self._fit_views()
        for cell in self._sheet.shown:
            cell.point_at(self._navigation.pixel)

    def _follow_size(self) -> None:
        """Fit the views after one has another size; while the cells are placed, only once at the end."""
        if not self._sheet.is_placing:
            self._fit_views()

    def _fit_views(self) -> None:
        """Apply the transform to views of their current size."""
        views = [cell.view for cell in self._sheet.shown]
        sizes = [view.viewport().size() for view in views]
        self._transform.set_view(sizes[0].width(), sizes[0].height())
        for view, size in zip(views, sizes, strict=True):
            view.share = self._transform.share(size.width(), size.height())
        self._show_transform()

    def _show_transform(self) -> None:
        for view in self._views:
            view.show_transform(self._transform)
        shown = [cell.view for cell in self._sheet.shown]
        self._layers.show(shown)
        self._navigation.follow(shown)

    def _move_cursor(self, pixel: tuple[int, int] | None) -> None:
        for cell in self._sheet.shown:
            cell.point_at(pixel)
        self.cursorMoved.emit(pixel)

    def _set_cursor_shape(self, shape: Qt.CursorShape) -> None:
        for view in self._views:
            view.viewport().setCursor(shape)

    def _handle(self, view: ImageView, event: QEvent) -> bool:
        """Handle the events of all views."""
        if event.type() == QEvent.Type.MouseButtonPress:
            self.activate(view)
            self.pressed.emit()
        return self.sides.swipe.handle(view, event) or self._navigation.handle(view, event)

    def _name_of(self, view: ImageView) -> str:
        return next(name for name, cell in self.cells.items() if cell.view is view)

    def _content_of(self, view: ImageView) -> str:
        return self.cells[self._name_of(view)].concrete

    def activate(self, view: ImageView) -> None:
        """Make a view the active one, if it is one of these."""
        name = next((name for name, cell in self.cells.items() if cell.view is view), self._active)
        if name != self._active:
            self._active = name
            self.rangeChanged.emit()

    # drawing

    def _write_names(self) -> None:
        labels, names = self._overlay.labels, self._names or {}
        points: dict[int, InnerPoint] = inner_points(labels) if labels is not None and names else {}
        for view in self._views:
            view.write_names(names, points)

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        missing = missing_brush(colours)
        for cell in self.cells.values():
            cell.set_colours(colours, missing)
            if not cell.isVisible():
                cell.draw_again()  # when it becomes visible
        self._old_pictures = [cell for cell in self.cells.values() if cell.isVisible()]
        if self._old_pictures:
            self._draw_timer.start()
        # a style sheet, because the application's replaces palettes of single widgets
        self._sheet.setStyleSheet(f"#sheet {{ background: {colours.border.name()}; }}")

    def _draw_next(self) -> None:
        """Draw the picture of one cell with the theme's colours, the next one at the next turn of the event loop."""
        self._old_pictures.pop(0).draw_again()
        if self._old_pictures:
            self._draw_timer.start()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shownChanged.emit()


def _are_same(one: Any, other: Any) -> bool:
    """Whether two data are the same; arrays are compared by identity."""
    return one is other or (type(one) in (str, int, bool, tuple, ShownRun) and one == other)
