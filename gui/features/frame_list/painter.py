"""Painting of a frame of the list: its thumbnail with the state of the work, and beside it, in a row, what is said of
it."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette, QPen, QPixmap
from PySide6.QtWidgets import QLineEdit, QStyle, QStyleOptionViewItem, QWidget

from ilf.project.project import FrameSummary, Stage

from ...base import theme
from ...widgets.row_table import Index, RowDelegate
from .model import ENTRY, PRESENT, last_line, state_line

_THUMBNAIL = QSize(72, 54)
_MARGIN = 7
_BAR = 4
"""Thickness of the bar in the colour of the state under a thumbnail [px]."""
_MARK = 13
"""Side of the mark of a frame that is done or to be checked [px]."""


class FramePainter(RowDelegate):
    """Paints thumbnails with three lines of text beside them, or alone. The note on a frame is edited at
    the foot of its row.

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

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        entry, colours = index.data(ENTRY), theme.colours(option.palette)
        name = f"{entry.name} •" if entry.unsaved else entry.name
        option.text = "" if self.strip_height else "\u2028".join((name, state_line(entry), last_line(entry)))
        option.font.setBold(bool(index.data(PRESENT)))
        if entry.summary.stage is Stage.FAILED or entry.summary.to_check:
            tone = colours.error if entry.summary.stage is Stage.FAILED else colours.warning
            for role in (QPalette.ColorRole.Text, QPalette.ColorRole.HighlightedText):
                option.palette.setColor(role, tone)
        option.icon = QIcon()  # only its space: the thumbnail fills it
        option.features |= QStyleOptionViewItem.ViewItemFeature.HasDecoration
        option.decorationSize = QSize(_THUMBNAIL.width() + 2 * _MARGIN, _THUMBNAIL.height())

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        super().paint(painter, option, index)
        box, colours = self._box(option.rect), theme.colours(option.palette)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        _paint_picture(painter, box, index.data(Qt.ItemDataRole.DecorationRole), colours)
        _paint_state(painter, box, index.data(ENTRY).summary, colours)
        tint, selected = option.palette.color(QPalette.ColorRole.Highlight), QStyle.StateFlag.State_Selected
        if index.data(PRESENT):
            painter.setPen(QPen(tint, 2))
            painter.drawRect(box)
        elif self.strip_height and option.state & (selected | QStyle.StateFlag.State_MouseOver):
            painter.fillRect(box, theme.faded(tint, 96 if option.state & selected else 40))
        painter.restore()

    def createEditor(self, parent: QWidget, option: QStyleOptionViewItem, index: Index) -> QWidget:
        editor = QLineEdit(parent, placeholderText=f"Note on {index.data()}")
        editor.setAccessibleName("Note on the frame")
        return editor

    def updateEditorGeometry(self, editor: QWidget, option: QStyleOptionViewItem, index: Index) -> None:
        foot = QRect(option.rect)
        foot.setTop(foot.bottom() + 1 - editor.sizeHint().height())
        foot.setLeft(self._box(option.rect).right() + _MARGIN)
        editor.setGeometry(foot)

    def _box(self, rect: QRect) -> QRect:
        """Return the place of the thumbnail."""
        if self.strip_height:
            return rect.adjusted(1, 1, -1, -1)
        return QRect(QPoint(rect.left() + _MARGIN, rect.center().y() - _THUMBNAIL.height() // 2), _THUMBNAIL)


def _paint_picture(painter: QPainter, box: QRect, picture: QPixmap | None, colours: theme.Colours) -> None:
    """Paint the middle part of a thumbnail that fills the box, or an outline if there is none."""
    if picture is None or picture.isNull():
        painter.setPen(colours.grid)
        painter.drawRect(box.adjusted(0, 0, -1, -1))
        return
    source = QRect(QPoint(), box.size().scaled(picture.size(), Qt.AspectRatioMode.KeepAspectRatio))
    source.moveCenter(picture.rect().center())
    painter.drawPixmap(box, picture, source)


def _paint_state(painter: QPainter, box: QRect, summary: FrameSummary, colours: theme.Colours) -> None:
    """Paint a bar in the colour of the state at the foot of a thumbnail, and a mark if it is done or to be checked."""
    tone = _colour_of(summary.stage, colours)
    if tone is not None:
        painter.fillRect(QRect(box.left(), box.bottom() + 1 - _BAR, box.width(), _BAR), tone)
    mark, ground = ("✓", colours.good) if summary.done else ("!" if summary.to_check else "", colours.warning)
    if mark:
        plate = QRectF(box.right() - _MARK - 1, box.top() + 2, _MARK, _MARK)
        painter.fillRect(plate, ground)
        painter.setPen(colours.background)
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, mark)


def _colour_of(stage: Stage, colours: theme.Colours) -> QColor | None:
    """Return the colour of a state; None for a frame that has not been worked on."""
    return {
        Stage.UNTOUCHED: None,
        Stage.EXTRACTED: colours.accent,
        Stage.PROPAGATED: colours.accent,
        Stage.EDITED: colours.warning,
        Stage.RUN: colours.good,
        Stage.FAILED: colours.error,
    }[stage]
