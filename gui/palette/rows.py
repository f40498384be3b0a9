"""How a row of the palette looks: icon, name with the letters that were typed, menu or reason, keys."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QFont, QPainter, QPalette
from PySide6.QtWidgets import QStyle, QStyledItemDelegate, QStyleOptionViewItem

from gui import theme
from gui.palette.ranking import Offer

OFFER_ROLE = int(Qt.ItemDataRole.UserRole)
_ICON, _MARGIN, _SPACE = 16, 8, 12
_MARK = 18


class OfferDelegate(QStyledItemDelegate):
    """Disabled commands are grey, with what keeps them from being given in the place of their menu."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        return QSize(200, option.fontMetrics.height() + 12)

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        offer: Offer = index.data(OFFER_ROLE)
        entry, colours = offer.entry, theme.colours(option.palette)
        enabled = entry.action.isEnabled()
        painter.save()
        if option.state & QStyle.StateFlag.State_Selected:
            tint = option.palette.color(QPalette.ColorRole.Highlight)
            tint.setAlpha(60)
            painter.fillRect(option.rect, tint)
        row = option.rect.adjusted(_MARGIN, 0, -_MARGIN, 0)
        mode = entry.action.icon().Mode.Normal if enabled else entry.action.icon().Mode.Disabled
        icon = QRect(0, 0, _ICON, _ICON)
        icon.moveCenter(row.center())
        icon.moveLeft(row.left())
        entry.action.icon().paint(painter, icon, Qt.AlignmentFlag.AlignCenter, mode)
        row.setLeft(row.left() + _ICON + _MARGIN)
        keys = entry.keys
        painter.setFont(option.font)
        painter.setPen(colours.muted)
        painter.drawText(row, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, keys)
        row.setRight(row.right() - painter.fontMetrics().horizontalAdvance(keys) - _SPACE)
        if entry.action.isCheckable() and entry.action.isChecked():
            painter.setPen(colours.accent)
            painter.drawText(QRect(row.right() - _MARK, row.top(), _MARK, row.height()), _MIDDLE, "✓")
            row.setRight(row.right() - _MARK)
        painter.setPen(colours.text if enabled else colours.muted)
        row.setLeft(_draw_text(painter, row, offer, option.font) + _SPACE)
        painter.setFont(option.font)
        painter.setPen(colours.muted)
        painter.drawText(
            row, _LEFT, painter.fontMetrics().elidedText(entry.why_not or entry.where, _ELIDE, row.width())
        )
        painter.restore()


_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_MIDDLE = Qt.AlignmentFlag.AlignCenter
_ELIDE = Qt.TextElideMode.ElideRight


def _draw_text(painter: QPainter, row: QRect, offer: Offer, font: QFont) -> int:
    """Draw the command's name, the letters that are meant bold; returns where it ends."""
    left, text = row.left(), offer.entry.text
    meant = set(offer.letters)
    place = 0
    while place < len(text):
        end = place + 1
        while end < len(text) and (end in meant) == (place in meant):
            end += 1
        own = QFont(font)
        own.setBold(place in meant)
        painter.setFont(own)
        part = text[place:end]
        painter.drawText(QRect(left, row.top(), row.right() - left, row.height()), _LEFT, part)
        left += painter.fontMetrics().horizontalAdvance(part)
        place = end
    return left
