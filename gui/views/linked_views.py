"""The window's centre: colour + blocks, depth in and out, difference, expected error, extraction, all linked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPoint, Qt, Signal
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from gui import theme
from gui.views.stage_cell import StageCell
from ilf.drawing.levels import robust_depth_levels

from .block_names import InnerPoint, inner_points
from .colour_maps import depth_table
from .empty_hint import EmptyHint
from .layouts import CELLS
from .navigation import Navigation
from .overlay import BlockOverlay
from .pointer import PointerHandler
from .preview import Preview
from .result_cells import DepthCell, DifferenceCell, ErrorCell, missing_brush
from .screen_layers import ScreenLayers
from .sheet import Sheet
from .view_cell import ViewCell
from .view_transform import ViewTransform

_NO_RESULT = "No result yet"


class LinkedViews(QWidget):
    """Six views of one frame, up to four at a time, with one pan, one zoom and one crosshair.

    A small view beside a large one shows the same part of the frame, smaller.

    The left button goes to the pointer handler first and pans if that does not want it; the middle button and
    space + left pan; the wheel zooms at the cursor; arrows, plus and minus do the same by keyboard.

    Signals
    -------
    cursorMoved(object)
        Pixel (x, y) under the pointer, as whole numbers, or None off the image.
    contextMenuRequested(QPoint, float, float)
        Place on the screen and image coordinates x, y of a right click or the menu key.
    layoutChanged(str)
        The layout now shown, also when a double-click on a title changed it.
    """

    cursorMoved = Signal(object)
    contextMenuRequested = Signal(QPoint, float, float)
    layoutChanged = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._transform = ViewTransform()
        self._navigation = Navigation(self._transform, self)
        self._measured: NDArray[np.float32] | None = None
        self._depth_in: NDArray[np.float32] | None = None
        self._depth_out: NDArray[np.float32] | None = None
        self._guessed: NDArray[np.bool_] | None = None
        self._depth_map = "turbo"
        self._levels = (0.0, 1.0)
        self._stale: NDArray[np.bool_] | None = None
        self._names: Mapping[int, str] | None = None
        self._shows_missing = self._distrusts = False

        handle = self._navigation.handle
        colour = ViewCell(*CELLS["colour"], handle)
        self._depths = DepthCell(*CELLS["depth-in"], handle), DepthCell(*CELLS["depth-out"], handle)
        self._difference = DifferenceCell(*CELLS["difference"], handle)
        self._error = ErrorCell(*CELLS["expected-error"], handle)
        self.extraction = StageCell(handle)
        cells = (colour, *self._depths, self._difference, self._error, self.extraction)
        self.cells: dict[str, ViewCell] = dict(zip((*CELLS, "extraction"), cells, strict=True))
        self._views = [cell.view for cell in self.cells.values()]
        self._overlay = BlockOverlay(1)
        self.cells["colour"].view.place(self._overlay.item)
        self._layers = ScreenLayers(self.cells["colour"].view)

        self._hint = EmptyHint()
        self._sheet = Sheet(self.cells)
        self._sheet.placed.connect(self._fit_to_room)
        self._sheet.layoutChanged.connect(self.layoutChanged)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(self._sheet)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self._pages)

        for cell in self.cells.values():
            cell.view.resized.connect(self._fit_to_room)
        for name in ("depth-out", "difference", "expected-error"):
            self.cells[name].view.set_message(_NO_RESULT)
        self._navigation.cursorMoved.connect(self._move_cursor)
        self._navigation.contextMenuRequested.connect(self.contextMenuRequested)
        self._navigation.transformChanged.connect(self._show_transform)
        self._navigation.cursorShapeChanged.connect(self._set_cursor_shape)
        self._take_theme()

    # the frame and its result

    def set_frame(self, rgb: NDArray[np.uint8], measured: NDArray[np.float32]) -> None:
        """Show a new frame, fitted, with depth levels of its own; blocks, result, distrust and preview go.

        Parameters
        ----------
        rgb : ndarray
            Colour, uint8 (H, W, 3).
        measured : ndarray
            Depth [m], float32 (H, W), NaN = missing; what of it is distrusted, `set_distrusted` says.

        Raises
        ------
        ValueError
            If the shapes differ.
        """
        if rgb.shape != (*measured.shape, 3):
            raise ValueError(f"colour {rgb.shape} and depth {measured.shape} do not show the same pixels")
        height, width = measured.shape
        self._measured = self._depth_in = measured
        self._transform.set_frame(width, height)
        self._navigation.set_frame((width, height))
        for view in self._views:
            view.set_frame_size(width, height)
        self._forget()
        self.cells["colour"].view.set_picture(rgb)
        self.auto_levels()
        self._pages.setCurrentWidget(self._sheet)
        self._sheet.set_aspect(self._transform.aspect)

    def clear(self) -> None:
        """Show no frame, only the hint how to open one."""
        self._measured = self._depth_in = None
        self._navigation.set_frame(None)
        self._forget()
        self._pages.setCurrentWidget(self._hint)

    def _forget(self) -> None:
        self._overlay.clear()
        self._layers.set_blocks(None)
        self.set_selected(())
        self.set_distrusted(None)
        self._write_names()
        self.set_preview(None)
        self.set_result(None)
        self.set_expected_error(None)
        self.extraction.show_message("")

    def set_result(
        self,
        depth_out: NDArray[np.float32] | None,
        guessed: NDArray[np.bool_] | None = None,
        stale: NDArray[np.bool_] | None = None,
    ) -> None:
        """Show completed depth [m], float32 (H, W), NaN where not recovered, and its difference; None for none.

        With `guessed`, bool (H, W), part of it is a guess, and with `stale`, bool (H, W), part of it is of an older
        state of its block: both are marked. What has not changed since the last call is not drawn again; the arrays may
        be the same ones, changed in place.

        Raises
        ------
        ValueError
            If there is no frame or the shape is not its shape.
        """
        if depth_out is not None and (self._depth_in is None or depth_out.shape != self._depth_in.shape):
            raise ValueError(f"a result of shape {depth_out.shape} does not belong to the frame shown")
        self._depth_out, self._guessed, self._stale = depth_out, guessed, stale
        self._draw_depths()
        self._difference.show_difference(self._depth_in, depth_out)

    def name_result(self, text: str) -> None:
        """Say which completed depth it is, "" for the present one."""
        for name in ("depth-out", "difference"):
            self.cells[name].strip.set_text(text)

    def set_distrusted(self, mask: NDArray[np.bool_] | None) -> None:
        """Mark measured depth that is known to be wrong, bool (H, W), and take it for missing; None for none.

        Raises
        ------
        ValueError
            If there is no frame or the shape is not its shape.
        """
        if mask is not None and (self._measured is None or mask.shape != self._measured.shape):
            raise ValueError(f"a mask of shape {mask.shape} does not belong to the frame shown")
        # where nothing was measured there is nothing to distrust
        wrong = None if mask is None or self._measured is None else mask & np.isfinite(self._measured)
        if wrong is None or self._measured is None:
            self._depth_in = self._measured
        else:
            self._depth_in = np.where(wrong, np.float32(np.nan), self._measured)
        self._layers.set_distrusted(wrong)
        self._difference.show_difference(self._depth_in, self._depth_out)
        self._show_marks(wrong is not None)

    def set_missing_shown(self, on: bool) -> None:
        """Whether missing depth is striped over the colour image."""
        self._shows_missing = on
        self._show_marks(self._distrusts)

    def _show_marks(self, distrusts: bool) -> None:
        self._distrusts = distrusts
        shown = self._shows_missing and self._measured is not None
        self._layers.set_missing(~np.isfinite(self._measured) if shown and self._measured is not None else None)
        for name, cell in self.cells.items():
            cell.set_marks(missing=shown and name == "colour", distrusted=distrusts)

    def set_expected_error(self, error: NDArray[np.float32] | None) -> None:
        """Show the expected error [m] of filled pixels, float32 (H, W), NaN elsewhere; None for none.

        Raises
        ------
        ValueError
            If there is no frame or the shape is not its shape.
        """
        if error is not None and (self._depth_in is None or error.shape != self._depth_in.shape):
            raise ValueError(f"an expected error of shape {error.shape} does not belong to the frame shown")
        self._error.show_error(self._depth_in, error)

    def mark_error_outdated(self, outdated: bool) -> None:
        """Say whether the expected error shown is of a result before the present one."""
        self._error.strip.set_text("of the result before" if outdated else "")

    @property
    def shows_expected_error(self) -> bool:
        """Whether the view of the expected error is to be seen."""
        return self.cells["expected-error"].isVisible()

    @property
    def shows_extraction(self) -> bool:
        """Whether the view of the extraction is to be seen."""
        return self.extraction.isVisible()

    # blocks, selection, preview

    def set_blocks(self, labels: NDArray[np.int32], colour_table: NDArray[np.uint8]) -> None:
        """Draw the label map over the colour view.

        Parameters
        ----------
        labels : ndarray
            int32 (H, W), 0 = no block.
        colour_table : ndarray
            uint8 (N + 1, 4) RGBA by label; alpha 0 hides a block.

        Raises
        ------
        ValueError
            If there is no frame, the shapes do not fit or a label has no colour.
        """
        if self._depth_in is None or labels.shape != self._depth_in.shape:
            raise ValueError(f"a label map of shape {labels.shape} does not belong to the frame shown")
        self._overlay.set_blocks(labels, colour_table)
        self._layers.set_blocks(self._overlay.labels, self._overlay.colours)
        self._write_names()

    def add_colours(self, colour_table: NDArray[np.uint8]) -> None:
        """Take a table that begins as the present one and has colours for further labels."""
        self._overlay.add_colours(colour_table)
        self._layers.add_colours(self._overlay.colours)

    def update_blocks_region(self, rows: slice, columns: slice, labels: NDArray[np.int32]) -> None:
        """Replace the labels of a box by an int32 array of the box's shape; its labels must have colours."""
        self._overlay.update_region((rows, columns), labels)
        self._layers.update_region((rows, columns))

    def set_overlay_opacity(self, opacity: float) -> None:
        """Opacity of the blocks' fills, 0-1."""
        self._overlay.set_opacity(opacity)

    def set_contours_only(self, on: bool) -> None:
        """Whether blocks have lines in their colours and no fill."""
        self._overlay.set_filled(not on)
        self._layers.set_in_colours(on)

    def set_block_names(self, names: Mapping[int, str] | None) -> None:
        """Write names by label at places inside the blocks as they are now; None for none."""
        self._names = names
        self._write_names()

    def set_selected(self, labels: Iterable[int]) -> None:
        """Draw a wider line around these blocks in all views."""
        self._layers.set_selected(labels)

    def set_preview(self, preview: Preview | None) -> None:
        """Draw what a tool is about to do in all views; None removes it."""
        for view in self._views:
            view.preview.set_preview(preview)

    def set_pointer_handler(self, handler: PointerHandler | None) -> None:
        """Send pointer events of all views to a tool; None lets the left button pan."""
        self._navigation.set_handler(handler)

    def set_space(self, held: bool) -> None:
        """Whether the space key is held, wherever it was pressed: the left button pans meanwhile."""
        self._navigation.set_space(held)

    # colours

    @property
    def levels(self) -> tuple[float, float]:
        """Depth [m] at the ends of the depth colours."""
        return self._levels

    def set_levels(self, low: float, high: float) -> None:
        """Depth [m] at the ends of the depth colours, for both depth views."""
        if not low < high:
            raise ValueError(f"the lower level must be below the upper one, not {low:g} and {high:g} m")
        self._levels = (float(low), float(high))
        self._draw_depths()

    def auto_levels(self) -> None:
        """Set the depth levels from the 1st and 99th percentile of the incoming depth."""
        if self._depth_in is not None:
            self.set_levels(*robust_depth_levels(self._depth_in))

    def set_depth_map(self, name: str) -> None:
        """Choose the depth colours by a name of `colour_maps.DEPTH_MAPS`."""
        self._depth_table = depth_table(name)
        self._depth_map = name
        self._draw_depths()

    # transform and layout

    def fit(self) -> None:
        """Show the whole frame."""
        self._transform.fit()
        self._show_transform()

    def one_to_one(self) -> None:
        """Show one image pixel per device pixel around the present centre."""
        self._transform.set_scale(1 / self.devicePixelRatioF())
        self._show_transform()

    def zoom_to(self, rows: slice, columns: slice) -> None:
        """Show a box of the image with some room around it."""
        self._transform.show(columns.start, rows.start, columns.stop, rows.stop)
        self._show_transform()

    @property
    def layout_name(self) -> str:
        """Which of `LAYOUTS` is shown."""
        return self._sheet.layout_name

    @property
    def pixel_size(self) -> float:
        """Image pixels per pixel of the screen, in a view that is not a small one."""
        return 1 / self._transform.scale

    def set_layout(self, name: str) -> None:
        """Arrange the views: by one of `LAYOUTS`, some of them or one alone."""
        self._sheet.set_layout(name)

    def toggle_layout(self, name: str) -> None:
        """Show a layout, or, if it is shown, the one of several views before it."""
        self._sheet.toggle_layout(name)

    def _fit_to_room(self) -> None:
        """Show what the transform says in views of the size that they have now."""
        views = [cell.view for cell in self._sheet.shown]
        sizes = [view.viewport().size() for view in views]
        self._transform.set_view(sizes[0].width(), sizes[0].height())
        for view, size in zip(views, sizes, strict=True):
            view.share = self._transform.share(size.width(), size.height())
        self._show_transform()

    def _show_transform(self) -> None:
        for view in self._views:
            view.show_transform(self._transform)
        self._layers.show([cell.view for cell in self._sheet.shown])

    def _move_cursor(self, pixel: tuple[int, int] | None) -> None:
        for cell in self.cells.values():
            cell.show_cursor(pixel)
        self.cursorMoved.emit(pixel)

    def _set_cursor_shape(self, shape: Qt.CursorShape) -> None:
        for view in self._views:
            view.viewport().setCursor(shape)

    # drawing

    def _draw_depths(self) -> None:
        depth_in, depth_out = self._depths
        depth_in.show_depth(self._measured, self._levels, self._depth_table)
        depth_out.show_depth(self._depth_out, self._levels, self._depth_table, self._guessed, self._stale)

    def _write_names(self) -> None:
        labels, names = self._overlay.labels, self._names or {}
        points: dict[int, InnerPoint] = inner_points(labels) if labels is not None and names else {}
        for view in self._views:
            view.write_names(names, points)

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        missing = missing_brush(colours)
        self._hint.set_colours(colours)
        for cell in self.cells.values():
            cell.set_colours(colours, missing)
        # a style sheet, because the application's replaces palettes of single widgets
        self._sheet.setStyleSheet(f"#sheet {{ background: {colours.grid.name()}; }}")
        self.set_depth_map(self._depth_map)

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self._take_theme()
        super().changeEvent(event)
