"""Comparison of two depths in the views: their selection, a draggable divider, and one in place of the other."""

from __future__ import annotations

from collections.abc import Callable, Collection

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QCursor, QMouseEvent, QPainterPath

from .cell import Cell
from .drawings import HaloPath
from .image_view import ImageView
from .view_data import COMPARABLE, ViewData

_NEAR = 8
"""Distance from the line [screen px] within which it can be dragged."""


class SideComparison:
    """Sides A and B of the comparison: by default the compared run, or depth in, and the result. A divider in the views
    that show both has side A at its left and side B at its right.

    Parameters
    ----------
    data : ViewData
    cells : collection of Cell
    draw : callable
        Draws parts of the data that have changed, by their names.
    """

    def __init__(self, data: ViewData, cells: Collection[Cell], draw: Callable[..., None]) -> None:
        self._data = data
        self._draw = draw
        self._cells = {cell.view: cell for cell in cells}
        self._items = {view: HaloPath(2, QColor("white"), 150, 6.5) for view in self._cells}
        for view, item in self._items.items():
            view.add(item)
        self._frame = QRectF()
        self._dragged: ImageView | None = None
        self._near: ImageView | None = None
        self._near_before = QCursor()
        self.is_divided = False
        self.x = 0.0
        """Position of the divider, in image coordinates."""

    def choose(self, first: str = "", second: str = "") -> None:
        """Select the two depths to compare by their names; "" for automatic.

        Raises
        ------
        ValueError
            If a depth does not exist.
        """
        for name in (first, second):
            if name not in ("", *COMPARABLE):
                raise ValueError(f"a side must be one of {', '.join(COMPARABLE)}, not {name!r}")
        self._data.chosen_sides = first, second
        self._draw("runs", "swipe")

    def show_a_as_result(self, on: bool) -> None:
        """Show side A in place of the result, or the result again."""
        if on != self._data.shows_a_as_result:
            self._data.shows_a_as_result = on
            self._draw("result")

    def set_frame(self, width: int, height: int) -> None:
        """Set the size of a new frame; the divider moves to its middle."""
        self._frame = QRectF(0, 0, width, height)
        self._dragged = None
        self._place(width / 2)

    def divide(self, on: bool) -> None:
        """Show or hide the divider. If it would be out of sight, it moves to the middle of what is visible."""
        if on != self.is_divided:
            self.is_divided, self._dragged, x = on, None, self.x
            for view in (view for view in self._items if self._takes_part(view) and view.isVisible()):
                columns = view.visible_box()[1]
                if not columns.start < x < columns.stop:
                    x = float((columns.start + columns.stop) // 2)
            self._place(x)
            self._draw("swipe")

    def move_to(self, x: float) -> None:
        """Move the divider to a column of the frame."""
        x = float(min(max(round(x), self._frame.left()), self._frame.right()))
        if x != self.x:
            self._place(x)
            self._draw("swipe")

    def _place(self, x: float) -> None:
        self.x = x
        self._data.swipe_column = round(x) if self.is_divided else None
        self.show_divider()

    def show_divider(self) -> None:
        """Update the divider in all views."""
        line = QPainterPath(QPointF(self.x, self._frame.top()))
        line.lineTo(self.x, self._frame.bottom())
        for view, item in self._items.items():
            item.set_visible(self.is_divided and self._takes_part(view))
            item.set_path(line)

    def _takes_part(self, view: ImageView) -> bool:
        """Whether a view is divided: the result, and the blocks if the sides have others; none if a side is missing."""
        if any(self._data.depth(side) is None for side in self._data.sides):
            return False
        shown = {"result"} if self._data.side_labels is None else {"result", "colour"}
        return self._cells[view].concrete in shown

    def handle(self, view: ImageView, event: QEvent) -> bool:
        """Handle an event of a view if it concerns the divider; True if it did."""
        if not self.is_divided or not isinstance(event, QMouseEvent):
            return False
        kind, at = event.type(), view.to_image(event.position())
        if self._dragged is view:
            if kind == QEvent.Type.MouseMove:
                self.move_to(at.x())
            elif kind == QEvent.Type.MouseButtonRelease and event.button() == Qt.MouseButton.LeftButton:
                self._dragged = None
            return True
        near = self._takes_part(view) and abs(at.x() - self.x) * view.transform.m11() <= _NEAR
        if kind == QEvent.Type.MouseMove and event.buttons() == Qt.MouseButton.NoButton:
            self._show_near(view if near else None)
        pressed = kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick)
        if near and pressed and event.button() == Qt.MouseButton.LeftButton:
            self._dragged = view
            return True
        return False

    def _show_near(self, view: ImageView | None) -> None:
        """Show another cursor over the divider, and restore the tool's cursor beside it."""
        if view is self._near:
            return
        if self._near is not None:
            self._near.viewport().setCursor(self._near_before)
        self._near = view
        if view is not None:
            self._near_before = view.viewport().cursor()
            view.viewport().setCursor(Qt.CursorShape.SplitHCursor)
