"""Painting of a frame of the list: a row with thumbnail, name, state and note, or a thumbnail alone in a strip."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPalette, QPen, QPixmap
from PySide6.QtWidgets import QLineEdit, QStyle, QStyleOptionViewItem, QWidget

from ilf.project.project import Stage

from ...base import theme
from ...state.entries import Entry
from ...widgets.tables import Index, RowDelegate
from .model import ENTRY, PRESENT, last_line, state_line

_THUMBNAIL = QSize(72, 54)
_MARGIN = 7
_CLOSE_SIZE = 16
_BAR = 4
"""Thickness of the bar of the current row, and of that in the colour of the state under a thumbnail [px]."""
_MARK = 7
"""Diameter of the mark of a state [px]."""
_PLATE = 13
"""Diameter of the disc behind a mark on a thumbnail [px]."""
_NOTE_WIDTH = 96
"""Minimum width of the line in which a note is edited [px]."""


class FramePainter(RowDelegate):
    """Paints rows, of which the one under the mouse has a cross to remove the frame; or thumbnails alone. The note on a
    frame is edited in the last line of its row, or at the foot of its thumbnail.

    Attributes
    ----------
    strip_height : int
        Height of the thumbnails of a strip [px]; 0 for rows.
    """

    strip_height = 0

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        """All frames have one size; a row is as wide as the view."""
        if self.strip_height:
            return QSize(4 * self.strip_height // 3, self.strip_height)
        return QSize(1, max(_THUMBNAIL.height(), 3 * (option.fontMetrics.height() + 1)) + 2 * _MARGIN)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        painter.save()
        painter.setRenderHints(QPainter.RenderHint.SmoothPixmapTransform | QPainter.RenderHint.Antialiasing)
        (_paint_in_strip if self.strip_height else _paint_row)(painter, option, index)
        painter.restore()

    def createEditor(self, parent: QWidget, option: QStyleOptionViewItem, index: Index) -> QWidget:
        editor = QLineEdit(parent, placeholderText=f"Note on {index.data()}")
        editor.setAccessibleName("Note on the frame")
        return editor

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, index: Index) -> None:
        height = editor.sizeHint().height()
        foot = option.rect.adjusted(0, option.rect.height() - height, 0, 0)
        box = foot if self.strip_height else _lines(option, option.rect.right())[2]
        editor.setGeometry(box.left(), box.top(), max(box.width(), _NOTE_WIDTH), height)


def close_box(row: QRect) -> QRect:
    """Return the rectangle of the cross in a row."""
    return QRect(row.right() - _MARGIN - _CLOSE_SIZE, row.top() + _MARGIN, _CLOSE_SIZE, _CLOSE_SIZE)


def _paint_in_strip(painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
    """Paint a thumbnail with a bar in the colour of the state, and a mark if it is done or to be checked."""
    colours, entry = theme.colours(option.palette), index.data(ENTRY)
    box = option.rect.adjusted(1, 1, -1, -1)
    painter.fillRect(option.rect, colours.background)
    _paint_picture(painter, option, box, index.data(Qt.ItemDataRole.DecorationRole))
    bar = _mark_colour(entry.summary.stage, colours)
    if bar is not None:
        painter.fillRect(QRect(box.left(), box.bottom() + 1 - _BAR, box.width(), _BAR), bar)
    plate = QRectF(box.right() - _PLATE - 1, box.top() + 2, _PLATE, _PLATE)
    if entry.summary.done:
        _paint_disc(painter, plate.center(), _PLATE, colours.background)
        _paint_tick(painter, plate.center(), colours.good)
    elif entry.summary.to_check:
        _paint_disc(painter, plate.center(), _PLATE, colours.warning)
        painter.setPen(colours.background)
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, "!")
    tint = option.palette.color(QPalette.ColorRole.Highlight)
    chosen = option.state & QStyle.StateFlag.State_Selected
    if chosen and not index.data(PRESENT):
        painter.fillRect(box, QColor(tint.red(), tint.green(), tint.blue(), 96))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if index.data(PRESENT):
        painter.setPen(QPen(tint, 2))
        painter.drawRect(box)
    elif option.state & (QStyle.StateFlag.State_HasFocus | QStyle.StateFlag.State_MouseOver):
        painter.setPen(QPen(colours.muted, 1))
        painter.drawRect(box)


def _paint_row(painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
    present = bool(index.data(PRESENT))
    hovered = bool(option.state & QStyle.StateFlag.State_MouseOver)
    box = QRect(option.rect.topLeft() + QPoint(_MARGIN + _BAR, _MARGIN), _THUMBNAIL)
    box.moveTop(option.rect.center().y() - box.height() // 2)
    _paint_ground(painter, option, present, hovered)
    _paint_picture(painter, option, box, index.data(Qt.ItemDataRole.DecorationRole))
    _paint_lines(painter, option, index.data(ENTRY), present, hovered)
    if hovered:
        theme.icon("ph.x", option.palette).paint(painter, close_box(option.rect))


def _paint_ground(painter: QPainter, option: QStyleOptionViewItem, present: bool, hovered: bool) -> None:
    tint = option.palette.color(QPalette.ColorRole.Highlight)
    painter.fillRect(option.rect, option.palette.base())  # covers the opaque colour of selected rows
    if present:
        painter.fillRect(QRect(option.rect.topLeft(), QSize(_BAR, option.rect.height())), tint)
    if option.state & QStyle.StateFlag.State_Selected or hovered:
        tint.setAlpha(48 if option.state & QStyle.StateFlag.State_Selected else 20)
        painter.fillRect(option.rect, tint)
    if option.state & QStyle.StateFlag.State_HasFocus and option.state & QStyle.StateFlag.State_KeyboardFocusChange:
        painter.setPen(QPen(option.palette.color(QPalette.ColorRole.Highlight), 1))
        painter.drawRect(option.rect.adjusted(0, 0, -1, -1))


def _paint_picture(painter: QPainter, option: QStyleOptionViewItem, box: QRect, picture: QPixmap | None) -> None:
    """Paint the middle part of a thumbnail that fills the box, or an outline while there is none."""
    if picture is not None and not picture.isNull():
        part = box.size().scaled(picture.size(), Qt.AspectRatioMode.KeepAspectRatio)
        source = QRect(QPoint(), part)
        source.moveCenter(picture.rect().center())
        painter.drawPixmap(box, picture, source)
        return
    painter.setPen(theme.colours(option.palette).grid)
    painter.drawRect(box.adjusted(0, 0, -1, -1))
    if picture is not None and box.width() >= _THUMBNAIL.width():
        painter.setPen(theme.colours(option.palette).muted)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, "no picture")


def _paint_lines(painter: QPainter, option: QStyleOptionViewItem, entry: Entry, present: bool, hovered: bool) -> None:
    colours, summary = theme.colours(option.palette), entry.summary
    boxes = _lines(option, close_box(option.rect).left() if hovered else option.rect.right())
    left = boxes[0].left()
    fonts = QFont(option.font), QFont(option.font), QFont(option.font)
    fonts[0].setBold(present)
    fonts[2].setItalic(bool(summary.note))
    name = f"{entry.name} •" if entry.unsaved else entry.name
    centre = QPointF(left + _MARK / 2, boxes[1].center().y() + 0.5)
    if summary.done:
        _paint_tick(painter, centre, colours.good)
    else:
        _paint_disc(painter, centre, _MARK, _mark_colour(summary.stage, colours))
    boxes[1].setLeft(left + _MARK + 5)
    check = colours.warning if summary.to_check else colours.muted
    pens = colours.text, colours.error if summary.stage is Stage.FAILED else check, colours.muted
    for text, box, font, pen in zip((name, state_line(entry), last_line(entry)), boxes, fonts, pens, strict=True):
        painter.setFont(font)
        painter.setPen(pen)
        shown = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, shown)


def _lines(option: QStyleOptionViewItem, right: int) -> list[QRect]:
    """Return the rectangles of the three lines of a row, left of some place."""
    left = option.rect.left() + 2 * _MARGIN + _BAR + _THUMBNAIL.width()
    spacing = option.fontMetrics.height() + 1
    top = option.rect.center().y() - 3 * spacing // 2
    return [QRect(left, top + number * spacing, right - _MARGIN - left, spacing) for number in range(3)]


def _mark_colour(stage: Stage, colours: theme.Colours) -> QColor | None:
    """Return the colour of a state; None for an outlined mark."""
    return {
        Stage.UNTOUCHED: None,
        Stage.EXTRACTED: colours.accent,
        Stage.PROPAGATED: colours.accent,
        Stage.EDITED: colours.warning,
        Stage.RUN: colours.good,
        Stage.FAILED: colours.error,
    }[stage]


def _paint_disc(painter: QPainter, centre: QPointF, diameter: int, colour: QColor | None) -> None:
    """Paint a disc; an outline without a colour."""
    painter.setPen(QPen(painter.pen().color(), 1.2) if colour is None else Qt.PenStyle.NoPen)
    painter.setBrush(Qt.BrushStyle.NoBrush if colour is None else colour)
    painter.drawEllipse(centre, diameter / 2, diameter / 2)


def _paint_tick(painter: QPainter, centre: QPointF, colour: QColor) -> None:
    """Paint the tick of a frame that is done, in place of the mark of its state."""
    painter.setPen(QPen(colour, 2))
    half = _MARK / 2
    corner = centre + QPointF(-half / 3, half)
    painter.drawPolyline([centre + QPointF(-half, half / 4), corner, centre + QPointF(half, -half)])
