"""Painting of a row of the frame list: thumbnail, name, state of the work, the user's note."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QPoint, QPointF, QRect, QSize, Qt
from PySide6.QtGui import QColor, QFont, QFontMetrics, QPainter, QPalette, QPen, QPixmap
from PySide6.QtWidgets import QStyle, QStyledItemDelegate, QStyleOptionViewItem

from ilf.project.project import Stage

from ...base import theme
from ...state.entries import Entry
from .model import ENTRY, PRESENT, last_line, state_line

_THUMBNAIL = QSize(72, 54)
_MARGIN = 7
_CLOSE_SIZE = 16
_BAR_WIDTH = 3
_MARK = 7
"""Diameter of the mark of a state [px]."""

Index = QModelIndex | QPersistentModelIndex


class RowPainter(QStyledItemDelegate):
    """Paints rows; the row under the mouse has a cross to remove the frame."""

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        entry: Entry = index.data(ENTRY)
        present = bool(index.data(PRESENT))
        hovered = bool(option.state & QStyle.StateFlag.State_MouseOver)
        painter.save()
        painter.setRenderHints(QPainter.RenderHint.SmoothPixmapTransform | QPainter.RenderHint.Antialiasing)
        _paint_ground(painter, option, present, hovered)
        _paint_thumbnail(painter, option, index.data(Qt.ItemDataRole.DecorationRole))
        _paint_lines(painter, option, entry, present, hovered)
        if hovered:
            theme.icon("ph.x", option.palette).paint(painter, close_box(option.rect))
        painter.restore()


def row_height(metrics: QFontMetrics) -> int:
    """Return the height of a row [px]."""
    return max(_THUMBNAIL.height(), 3 * _spacing(metrics)) + 2 * _MARGIN


def close_box(row: QRect) -> QRect:
    """Return the rectangle of the cross in a row."""
    return QRect(row.right() - _MARGIN - _CLOSE_SIZE, row.top() + _MARGIN, _CLOSE_SIZE, _CLOSE_SIZE)


def _paint_ground(painter: QPainter, option: QStyleOptionViewItem, present: bool, hovered: bool) -> None:
    tint = option.palette.color(QPalette.ColorRole.Highlight)
    painter.fillRect(option.rect, option.palette.base())  # covers the opaque colour of selected rows in tables
    if present:
        painter.fillRect(QRect(option.rect.topLeft(), QSize(_BAR_WIDTH, option.rect.height())), tint)
    if option.state & QStyle.StateFlag.State_Selected or hovered:
        tint.setAlpha(48 if option.state & QStyle.StateFlag.State_Selected else 20)
        painter.fillRect(option.rect, tint)
    if option.state & QStyle.StateFlag.State_HasFocus and option.state & QStyle.StateFlag.State_KeyboardFocusChange:
        painter.setPen(QPen(option.palette.color(QPalette.ColorRole.Highlight), 1))
        painter.drawRect(option.rect.adjusted(0, 0, -1, -1))


def _paint_thumbnail(painter: QPainter, option: QStyleOptionViewItem, picture: QPixmap | None) -> None:
    """Paint the thumbnail centred in its box with its aspect ratio, or an outline while there is none."""
    box = QRect(option.rect.topLeft() + QPoint(_MARGIN + _BAR_WIDTH, _MARGIN), _THUMBNAIL)
    box.moveTop(option.rect.center().y() - box.height() // 2)
    if picture is None or picture.isNull():
        painter.setPen(theme.colours(option.palette).grid)
        painter.drawRect(box.adjusted(0, 0, -1, -1))
        if picture is not None:
            painter.setPen(theme.colours(option.palette).muted)
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, "no picture")
        return
    target = QRect(QPoint(), picture.size().scaled(_THUMBNAIL, Qt.AspectRatioMode.KeepAspectRatio))
    target.moveCenter(box.center())
    painter.drawPixmap(target, picture)


def _paint_lines(painter: QPainter, option: QStyleOptionViewItem, entry: Entry, present: bool, hovered: bool) -> None:
    colours, summary = theme.colours(option.palette), entry.summary
    left = option.rect.left() + 2 * _MARGIN + _BAR_WIDTH + _THUMBNAIL.width()
    right = (close_box(option.rect).left() if hovered else option.rect.right()) - _MARGIN
    spacing = _spacing(option.fontMetrics)
    top = option.rect.center().y() - 3 * spacing // 2
    boxes = [QRect(left, top + number * spacing, right - left, spacing) for number in range(3)]
    fonts = QFont(option.font), QFont(option.font), QFont(option.font)
    fonts[0].setBold(present)
    fonts[2].setItalic(bool(summary.note))
    name = f"{entry.name} •" if entry.unsaved else entry.name
    centre = QPointF(left + _MARK / 2, boxes[1].center().y() + 0.5)
    if summary.done:
        paint_tick(painter, centre, colours.good)
    else:
        _paint_mark(painter, centre, mark_colour(summary.stage, colours))
    boxes[1].setLeft(left + _MARK + 5)
    check = colours.warning if summary.to_check else colours.muted
    pens = colours.text, colours.error if summary.stage is Stage.FAILED else check, colours.muted
    for text, box, font, pen in zip((name, state_line(entry), last_line(entry)), boxes, fonts, pens, strict=True):
        painter.setFont(font)
        painter.setPen(pen)
        shown = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, shown)


def mark_colour(stage: Stage, colours: theme.Colours) -> QColor | None:
    """Return the colour of a state; None for an outlined mark."""
    return {
        Stage.UNTOUCHED: None,
        Stage.EXTRACTED: colours.accent,
        Stage.PROPAGATED: colours.accent,
        Stage.EDITED: colours.warning,
        Stage.RUN: colours.good,
        Stage.FAILED: colours.error,
    }[stage]


def _paint_mark(painter: QPainter, centre: QPointF, colour: QColor | None) -> None:
    painter.setPen(QPen(painter.pen().color(), 1.2) if colour is None else Qt.PenStyle.NoPen)
    painter.setBrush(Qt.BrushStyle.NoBrush if colour is None else colour)
    painter.drawEllipse(centre, _MARK / 2, _MARK / 2)


def paint_tick(painter: QPainter, centre: QPointF, colour: QColor) -> None:
    """Paint the tick of a frame that is done, in place of the mark of its state."""
    painter.setPen(QPen(colour, 2))
    half = _MARK / 2
    corner = centre + QPointF(-half / 3, half)
    painter.drawPolyline([centre + QPointF(-half, half / 4), corner, centre + QPointF(half, -half)])


def _spacing(metrics: QFontMetrics) -> int:
    return metrics.height() + 1
