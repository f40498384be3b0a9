"""The strip over a picture: title with content menu, legend, a text about the picture, and its colour bar."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QPointF, QRect, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QMouseEvent, QPainter, QPaintEvent, QPolygonF, QResizeEvent
from PySide6.QtWidgets import QWidget

from ..base import theme
from ..widgets.basics import literal_text
from .colour_bar import ColourBar

PAD = 6
_SWATCH = 10
_ARROW = 7
_MIN_TITLE_WIDTH = 40
"""Minimum width of the title [px], however long the text at the right is."""
_BAR_SHARE = 0.38
"""Width of the colour bar, as a share of the strip's."""
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_MORE = " \N{HORIZONTAL ELLIPSIS}"
_PLACES = {"missing": 0, "invalid": 1, "unsupported": 3, "measured": 4}
"""Order of entries of the legend, the most needed first; all others have place 2."""

_TITLE_HINT = "Click the title to select what is shown; double-click to enlarge the view or show it alone"


class TitleStrip(QWidget):
    """Small muted title with a menu arrow; legend and colour bar at the right, outside the picture.

    Signals
    -------
    doubleClicked()
    menuRequested()
        The title was clicked: open the menu at `menu_position`.
    """

    doubleClicked = Signal()
    menuRequested = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.title = ""
        self._swatch: QColor | None = None
        self._legend: list[tuple[QBrush, str]] = []
        self._text = ""
        font = self.font()
        font.setPointSizeF(font.pointSizeF() * 0.88)
        self.setFont(font)
        self.bar = ColourBar(self)
        self.bar.setFont(font)
        self.bar.resized.connect(self._place_bar)
        self.setFixedHeight(self.fontMetrics().height() + 3)
        self.setToolTip(_TITLE_HINT)

    def set_title(self, title: str, swatch: tuple[int, int, int] | None = None) -> None:
        """Set the title of the picture, and its own colour (R, G, B) if it has one."""
        colour = None if swatch is None else QColor(*swatch)
        if (title, colour) != (self.title, self._swatch):
            self.title, self._swatch = title, colour
            self.setAccessibleName(f"View: {title}")
            self._describe()
            self.update()

    @property
    def title_end(self) -> int:
        """Right end of the title [px from the left]."""
        room = max(self._right - self._text_width, _MIN_TITLE_WIDTH + self._swatch_width)
        return min(self._title_width, room)

    @property
    def _swatch_width(self) -> int:
        return _SWATCH + PAD if self._swatch is not None else 0

    @property
    def _text_width(self) -> int:
        """Width of the text at the right, with its margins [px]."""
        return self.fontMetrics().horizontalAdvance(self._text) + 2 * PAD if self._text else 0

    @property
    def _title_width(self) -> int:
        """Width of the whole title [px]."""
        return 2 * PAD + self._swatch_width + self.fontMetrics().horizontalAdvance(self.title) + _ARROW + PAD

    @property
    def _right(self) -> int:
        """Right end of text and legend [px from the left]: the colour bar, if it is shown, or the strip's."""
        return self.width() if self.bar.isHidden() else self.bar.x() - PAD

    def _place_bar(self) -> None:
        """Show the colour bar where it has values, and room beside title and text."""
        bar = self.bar
        least = bar.minimumSizeHint().width()
        free = self.width() - self._title_width - self._width_of(self._legend) - 3 * PAD  # the legend comes first
        width = max(least, min(round(_BAR_SHARE * self.width()), bar.sizeHint().width(), free))
        bar.setVisible(bar.levels is not None and self.width() - least - self._text_width >= 2 * _MIN_TITLE_WIDTH)
        bar.setGeometry(self.width() - width - PAD, 0, width, self.height())
        self.update()

    def set_text(self, text: str) -> None:
        """Set the text about the picture, at the right."""
        if text != self._text:
            self._text = text
            self._place_bar()

    def set_legend(self, legend: list[tuple[QBrush, str]]) -> None:
        """Set swatches with their meaning, the most needed shown first: those without room are in the tool tip only."""
        self._legend = sorted(legend, key=lambda entry: _PLACES.get(entry[1], 2))
        self._describe()
        self._place_bar()

    def _describe(self) -> None:
        """Put what may have no room, title and legend, into the tool tip."""
        signs = f"Signs: {', '.join(text for _, text in self._legend)}" if self._legend else ""
        self.setToolTip(literal_text("\n".join(filter(None, (self.title, _TITLE_HINT, signs)))))

    def menu_position(self) -> QPoint:
        """Screen position at which the menu of the title opens."""
        return self.mapToGlobal(QPoint(0, self.height()))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.colours(self.palette())
        painter.fillRect(self.rect(), colours.panel)
        self._paint_title(painter, colours.muted)
        right = self._right - PAD
        metrics = self.fontMetrics()
        painter.setPen(colours.muted)
        painter.drawText(QRect(0, 0, right, self.height()), _RIGHT, self._text)
        if self._text:
            right -= metrics.horizontalAdvance(self._text) + PAD + 2
        self._paint_legend(painter, QRect(self.title_end, 0, right - self.title_end + 1, self.height()))

    def legend_in(self, room: int) -> list[tuple[QBrush, str]]:
        """Return the entries of the legend, from the left, that fit a width with their words, and an ellipsis if it is
        not all of them."""
        shown = list(self._legend)
        while shown and self._width_of(shown) + self._more_width(shown) > room:
            shown.pop()
        return shown

    def _more_width(self, shown: list[tuple[QBrush, str]]) -> int:
        """Width of the ellipsis after the entries that are shown, if they are not all [px]."""
        return self.fontMetrics().horizontalAdvance(_MORE) if len(shown) < len(self._legend) else 0

    def _paint_legend(self, painter: QPainter, room: QRect) -> None:
        shown = self.legend_in(room.width())
        more = self._more_width(shown)
        if 0 < more <= room.width():
            painter.drawText(room, _RIGHT, _MORE)
        left = room.right() - more - self._width_of(shown)
        for brush, text in shown:
            swatch = QRect(left + PAD + 2, (self.height() - _SWATCH) // 2, _SWATCH, _SWATCH)
            left += self._width_of([(brush, text)])
            painter.drawText(swatch.right() + 6, 0, left - swatch.right(), self.height(), _LEFT, text)
            painter.setBrush(brush)
            painter.drawRect(swatch.adjusted(0, 0, -1, -1))

    def _width_of(self, legend: list[tuple[QBrush, str]]) -> int:
        """Width of entries of the legend with their words [px]."""
        return sum(PAD + 2 + _SWATCH + 5 + self.fontMetrics().horizontalAdvance(text) for _, text in legend)

    def _paint_title(self, painter: QPainter, colour: QColor) -> None:
        left, end = PAD, self.title_end
        if self._swatch is not None:
            painter.fillRect(left, (self.height() - _SWATCH) // 2, _SWATCH, _SWATCH, self._swatch)
        left += self._swatch_width
        painter.setPen(colour)
        room = QRect(left, 0, end - left - 2 * PAD - _ARROW, self.height())
        title = self.fontMetrics().elidedText(self.title, Qt.TextElideMode.ElideRight, room.width() + PAD // 2)
        painter.drawText(room.adjusted(0, 0, PAD, 0), _LEFT, title)
        x, y = left + self.fontMetrics().horizontalAdvance(title) + PAD - 1.0, self.height() / 2 - 1.5
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colour)
        half = _ARROW / 2
        painter.drawPolygon(QPolygonF([QPointF(x, y), QPointF(x + _ARROW, y), QPointF(x + half, y + half + 0.5)]))
        painter.restore()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton and event.position().x() < self.title_end:
            self.menuRequested.emit()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.doubleClicked.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_bar()
