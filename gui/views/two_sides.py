"""Two depths that are compared in the views: which they are, parted by a handle, or one in place of the other."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QCursor, QFont, QFontMetricsF, QMouseEvent, QPainter, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from .contents import COMPARABLE, capital, short_title
from .image_view import ImageView
from .painter import Material
from .scene_items import ViewItem

# A line over the result that parts two depths: what is left of it is side A, what is right of it side B.

_NEAR = 8
"""Pixels of the screen on either side of the line in which it can be grasped."""
_GRIP = 11.0
_PAD = 4.0
_LINE, _HALO = QColor(255, 255, 255), QColor(0, 0, 0, 150)
_PLATE = QColor(0, 0, 0, 170)

Label = tuple[str, tuple[int, int, int] | None]
"""What a side is called, and its own colour (R, G, B) if it has one."""


class SwipeItem(ViewItem):
    """The line, a grip in the middle of what is to be seen of it, and what stands on either side."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self._frame = QRectF()
        self._x = 0.0
        self._labels: tuple[Label, Label] | None = None
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.9)
        self.hide()

    def place(self, frame: QRectF, x: float, labels: tuple[Label, Label] | None) -> None:
        """Stand at a column x of a frame, both in image coordinates; without labels, a thin line alone does."""
        self._frame, self._x, self._labels = frame, x, labels
        self.set_extent(frame, _GRIP + 2)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        transform = painter.worldTransform()
        shown = transform.mapRect(self._frame)
        if widget is not None:
            shown = shown.intersected(QRectF(widget.rect()))
        x = transform.map(QPointF(self._x, 0.0)).x()
        painter.save()
        painter.resetTransform()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        width = 1.0 if self._labels is None else 2.0
        for pen in (QPen(_HALO, width + 2), QPen(_LINE, width)):
            painter.setPen(pen)
            painter.drawLine(QPointF(x, shown.top()), QPointF(x, shown.bottom()))
        if self._labels is not None:
            self._draw_grip(painter, QPointF(x, shown.center().y()))
            self._draw_labels(painter, self._labels, x, shown)
        painter.restore()

    def _draw_grip(self, painter: QPainter, centre: QPointF) -> None:
        painter.setPen(QPen(_HALO, 2.0))
        painter.setBrush(_LINE)
        painter.drawEllipse(centre, _GRIP, _GRIP)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(40, 44, 50))
        for side in (-1, 1):
            tip, back, half = side * 8.0, side * 3.0, 4.0
            painter.drawPolygon([centre + QPointF(tip, 0), centre + QPointF(back, -half), centre + QPointF(back, half)])

    def _draw_labels(self, painter: QPainter, labels: tuple[Label, Label], x: float, shown: QRectF) -> None:
        metrics = QFontMetricsF(self._font)
        painter.setFont(self._font)
        for (text, colour), side in zip(labels, (-1, 1), strict=True):
            room = (x - shown.left() if side < 0 else shown.right() - x) - 4 * _PAD
            elided = metrics.elidedText(text, Qt.TextElideMode.ElideRight, room)
            if room < 3 * _GRIP or not elided:
                continue
            plate = QRectF(0, 0, metrics.horizontalAdvance(elided) + 2 * _PAD, metrics.height() + 2)
            plate.moveTop(shown.top() + 2 * _PAD)
            if side < 0:
                plate.moveRight(x - 2 * _PAD)
            else:
                plate.moveLeft(x + 2 * _PAD)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(_PLATE)
            painter.drawRoundedRect(plate, 3, 3)
            if colour is not None:
                painter.fillRect(QRectF(plate.left(), plate.bottom() - 2, plate.width(), 2), QColor(*colour))
            painter.setPen(_LINE)
            painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, elided)


class Swipe(QObject):
    """One handle over several views.

    Parameters
    ----------
    views : list of ImageView
    takes_part : callable
        Whether a view shows the two sides.
    has_grip : callable
        Whether such a view has grip and labels, too; others have a line that covers as little as can be.

    Signals
    -------
    moved()
        The handle is elsewhere, or is shown or not.
    """

    moved = Signal()

    def __init__(
        self,
        views: list[ImageView],
        takes_part: Callable[[ImageView], bool],
        has_grip: Callable[[ImageView], bool],
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._takes_part, self._has_grip = takes_part, has_grip
        self._frame = QRectF()
        self._labels: tuple[Label, Label] = (("", None), ("", None))
        self._dragged: ImageView | None = None
        self._near: ImageView | None = None
        self._near_before = QCursor()
        self._items: dict[ImageView, SwipeItem] = {}
        self.on = False
        self.x = 0.0
        """Where the handle is, in image coordinates."""
        for view in views:
            self._items[view] = SwipeItem(6.5)
            view.add_overlay(self._items[view])

    def set_frame(self, width: int, height: int) -> None:
        """Stand in the middle of another frame."""
        self._frame = QRectF(0, 0, width, height)
        self.x, self._dragged = width / 2, None
        self.show()

    def set_on(self, on: bool) -> None:
        """Show the handle, or do not."""
        if on != self.on:
            self.on, self._dragged = on, None
            self.show()
            self.moved.emit()

    def set_labels(self, labels: tuple[Label, Label]) -> None:
        """What stands at the left and at the right."""
        self._labels = labels
        self.show()

    def show(self) -> None:
        """Draw it where it belongs."""
        for view, item in self._items.items():
            is_shown = self.on and self._takes_part(view)
            item.setVisible(is_shown)
            if is_shown:
                item.place(self._frame, self.x, self._labels if self._has_grip(view) else None)

    def move_to(self, x: float) -> None:
        """Put the handle at a column of the frame."""
        x = float(min(max(round(x), self._frame.left()), self._frame.right()))
        if x != self.x:
            self.x = x
            self.show()
            self.moved.emit()

    def handle(self, view: ImageView, event: QEvent) -> bool:
        """Take an event of a view that means the handle."""
        if not self.on or not isinstance(event, QMouseEvent):
            return False
        kind, at = event.type(), view.to_image(event.position())
        if self._dragged is view:
            if kind == QEvent.Type.MouseMove:
                self.move_to(at.x())
            elif kind == QEvent.Type.MouseButtonRelease and event.button() == Qt.MouseButton.LeftButton:
                self._dragged = None
            return True
        near = self._takes_part(view) and abs(at.x() - self.x) * view.transform().m11() <= _NEAR
        if kind == QEvent.Type.MouseMove and event.buttons() == Qt.MouseButton.NoButton:
            self._show_near(view if near else None)
        pressed = kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick)
        if near and pressed and event.button() == Qt.MouseButton.LeftButton:
            self._dragged = view
            return True
        return False

    def _show_near(self, view: ImageView | None) -> None:
        """Another cursor over the handle; the tool's own comes back beside it."""
        if view is self._near:
            return
        if self._near is not None:
            self._near.viewport().setCursor(self._near_before)
        self._near = view
        if view is not None:
            self._near_before = view.viewport().cursor()
            view.viewport().setCursor(Qt.CursorShape.SplitHCursor)


class TwoSides(QObject):
    """Sides A and B: at first what is compared, or depth in, and the result.

    Parameters
    ----------
    material : Material
    views : list of ImageView
    content_of : callable
        The concrete content of a view.

    Signals
    -------
    changed(str)
        Other pixels are to be shown: the part of the material that has changed.
    """

    changed = Signal(str)

    def __init__(
        self, material: Material, views: list[ImageView], content_of: Callable[[ImageView], str], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._material = material
        self._content_of = content_of
        self.swipe = Swipe(views, self._is_swiped, lambda view: content_of(view) == "result", self)
        self.swipe.moved.connect(self._follow_handle)

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two depths, of `contents.names.COMPARABLE`."""
        return self._material.sides

    @property
    def chosen(self) -> tuple[str, str]:
        """The two as they were chosen; "" for what is best as things are."""
        return self._material.chosen_sides

    def choose(self, first: str = "", second: str = "") -> None:
        """Compare two depths by their names; "" stands for what is best as things are.

        Raises
        ------
        ValueError
            If there is no such depth.
        """
        for name in (first, second):
            if name not in ("", *COMPARABLE):
                raise ValueError(f"a side must be one of {', '.join(COMPARABLE)}, not {name!r}")
        self._material.chosen_sides = first, second
        self.changed.emit("runs")
        self._follow_handle()

    def set_swiping(self, on: bool) -> None:
        """Part the result by a handle: side A left of it, side B right of it."""
        self.swipe.set_on(on)

    def look_at_a(self, on: bool) -> None:
        """Let side A stand in for the result for a while."""
        if on != self._material.looks_at_a:
            self._material.looks_at_a = on
            self.changed.emit("result")

    def set_frame(self, width: int, height: int) -> None:
        """Take another frame, all of which is to be drawn: the handle stands in its middle."""
        self.swipe.set_frame(width, height)
        self._place()

    def write_labels(self) -> None:
        """Say at the handle what its sides are."""
        first, second = (self._label(depth) for depth in self.names)
        self.swipe.set_labels((first, second))

    def _label(self, depth: str) -> Label:
        run = self._material.run(depth)
        return capital(short_title(depth, self._material.names)), None if run is None else run.colour

    def _is_swiped(self, view: ImageView) -> bool:
        """The result, and blocks where the two sides have others; nothing while one of them is missing."""
        if any(self._material.layer(side) is None for side in self.names):
            return False
        shown = {"result", "colour"} if any(self._material.side_blocks) else {"result"}
        return self._content_of(view) in shown

    def _follow_handle(self) -> None:
        self._place()
        self.changed.emit("swipe")

    def _place(self) -> None:
        self._material.swiped_at = round(self.swipe.x) if self.swipe.on else None
