"""The list of open frames, with thumbnails."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import (
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QRect,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QAction, QFont, QMouseEvent, QPainter, QPaintEvent, QPalette, QPixmap
from PySide6.QtWidgets import (
    QAbstractItemView,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from gui import theme
from gui.views.images import rgb_image
from gui.widgets.hint import paint_hint

_KEY, _DETAIL, _IMAGE = (Qt.ItemDataRole.UserRole + number for number in range(3))
_THUMBNAIL = QSize(72, 54)
_MARGIN = 7
_CLOSE_SIZE = 16
_BAR_WIDTH = 3


class FrameList(QWidget):
    """Open frames by key. The list reports wishes; what is current and what is gone is told to it.

    Signals
    -------
    activated(str)
        The user clicked, or pressed Enter on, a frame that is not the current one.
    removeRequested(str)
        The user wants to close a frame.
    """

    activated = Signal(str)
    removeRequested = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._current = ""
        self._items: dict[str, QListWidgetItem] = {}
        self.view = _FrameView(self)
        self.view.setAccessibleName("Open frames")
        self.view.setItemDelegate(_FrameDelegate(self.view))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.view)
        self.setFocusProxy(self.view)
        # a click and Enter both mean it, and a style may report one click as both
        self.view.itemClicked.connect(self._activate)
        self.view.itemActivated.connect(self._activate)
        self.view.customContextMenuRequested.connect(self._show_menu)
        self.view.close_clicked.connect(self.removeRequested)

    def add_frame(self, key: str, name: str, thumbnail: NDArray[np.uint8], detail: str = "") -> None:
        """Add a frame at the end.

        Parameters
        ----------
        key : str
            Identifies the frame; must be new.
        name : str
        thumbnail : ndarray of uint8, shape (h, w, 3)
            Any small size.
        detail : str
            One or two lines below the name.

        Raises
        ------
        ValueError
            If the key is there already.
        """
        if key in self._items:
            raise ValueError(f"frame {key!r} is in the list already")
        item = QListWidgetItem(name)
        item.setData(_KEY, key)
        item.setData(_DETAIL, detail)
        item.setData(_IMAGE, QPixmap.fromImage(rgb_image(thumbnail)))
        item.setToolTip(f"{name}\n{key}")
        self._items[key] = item
        self.view.addItem(item)

    def remove_frame(self, key: str) -> None:
        """Take a frame out of the list."""
        self.view.takeItem(self.view.row(self._items.pop(key)))
        if key == self._current:
            self._current = ""

    def update_detail(self, key: str, text: str) -> None:
        """Set the one or two lines below a frame's name."""
        self._items[key].setData(_DETAIL, text)

    def set_current(self, key: str) -> None:
        """Mark a frame as the one that is shown; `activated` is not emitted."""
        self._current = key
        self.view.setCurrentItem(self._items[key])
        self.view.scrollToItem(self._items[key])

    def keys(self) -> list[str]:
        """Keys from top to bottom."""
        return [self.view.item(row).data(_KEY) for row in range(self.view.count())]

    def _activate(self, item: QListWidgetItem) -> None:
        if item.data(_KEY) != self._current:
            self.activated.emit(item.data(_KEY))

    def _show_menu(self, at: QPoint) -> None:
        item = self.view.itemAt(at)
        if item is None:
            return
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        close = QAction(theme.icon("ph.x", self.palette()), "Close Frame", menu)
        key = item.data(_KEY)
        close.triggered.connect(lambda: self.removeRequested.emit(key))
        menu.addAction(close)
        menu.popup(self.view.viewport().mapToGlobal(at))


class _FrameView(QListWidget):
    """The list itself; clicks on a row's cross close the frame and do nothing else."""

    close_clicked = Signal(str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self._closing: QListWidgetItem | None = None
        self.setMouseTracking(True)
        self.setFrameShape(QListWidget.Shape.NoFrame)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setUniformItemSizes(True)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._closing = self._cross_at(event)
        if self._closing is None:
            super().mousePressEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        pressed, self._closing = self._closing, None
        if pressed is None:
            super().mouseReleaseEvent(event)
        elif self._cross_at(event) is pressed:
            self.close_clicked.emit(pressed.data(_KEY))

    def _cross_at(self, event: QMouseEvent) -> QListWidgetItem | None:
        """The row whose cross is under the mouse at a left click."""
        at = event.position().toPoint()
        item = self.itemAt(at)
        if item is None or event.button() != Qt.MouseButton.LeftButton:
            return None
        box = _close_box(self.visualItemRect(item)).adjusted(-3, -3, 3, 3)
        return item if box.contains(at) else None

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.count() == 0:
            paint_hint(self, "No frames open. Open one, or drop colour and depth files here.")


class _FrameDelegate(QStyledItemDelegate):
    """Thumbnail, name, detail, and a cross for closing on the row under the mouse."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        return QSize(160, _THUMBNAIL.height() + 2 * _MARGIN)

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        colours = theme.colours(option.palette)
        selected = bool(option.state & QStyle.StateFlag.State_Selected)
        hovered = bool(option.state & QStyle.StateFlag.State_MouseOver)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        if selected:
            tint = option.palette.color(QPalette.ColorRole.Highlight)
            painter.fillRect(QRect(option.rect.topLeft(), QSize(_BAR_WIDTH, option.rect.height())), tint)
            tint.setAlpha(48)
            painter.fillRect(option.rect, tint)
        elif hovered:
            tint = option.palette.color(QPalette.ColorRole.Highlight)
            tint.setAlpha(20)
            painter.fillRect(option.rect, tint)
        _paint_thumbnail(painter, option.rect, index.data(_IMAGE))

        left = option.rect.left() + 2 * _MARGIN + _BAR_WIDTH + _THUMBNAIL.width()
        right = _close_box(option.rect).left() if hovered else option.rect.right()
        lines = [index.data(), *index.data(_DETAIL).splitlines()]
        spacing = option.fontMetrics.height() + 1
        top = option.rect.center().y() - len(lines) * spacing // 2
        for number, line in enumerate(lines):
            font = QFont(option.font)
            font.setBold(number == 0 and selected)
            painter.setFont(font)
            painter.setPen(colours.muted if number else colours.text)
            box = QRect(left, top + number * spacing, right - left - _MARGIN, spacing)
            text = painter.fontMetrics().elidedText(line, Qt.TextElideMode.ElideRight, box.width())
            painter.drawText(box, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)
        if hovered:
            theme.icon("ph.x", option.palette).paint(painter, _close_box(option.rect))
        painter.restore()


def _paint_thumbnail(painter: QPainter, row: QRect, image: QPixmap) -> None:
    """The image in the middle of its box, whole and undistorted."""
    box = QRect(row.topLeft() + QPoint(_MARGIN + _BAR_WIDTH, _MARGIN), _THUMBNAIL)
    target = QRect(QPoint(), image.size().scaled(_THUMBNAIL, Qt.AspectRatioMode.KeepAspectRatio))
    target.moveCenter(box.center())
    painter.drawPixmap(target, image)


def _close_box(row: QRect) -> QRect:
    return QRect(row.right() - _MARGIN - _CLOSE_SIZE, row.top() + _MARGIN, _CLOSE_SIZE, _CLOSE_SIZE)
