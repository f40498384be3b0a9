"""Film strip under the images: thumbnails of the listed frames with the state of each."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import (
    QEvent,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QPointF,
    QRect,
    QRectF,
    QSettings,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QPainter, QPalette, QPen, QPixmap, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QAbstractItemView, QListView, QStyle, QStyledItemDelegate, QStyleOptionViewItem

from ...base import theme
from ...base.commands import Command
from ...state.entries import Entry
from ..context import Context, Feature
from ..edit_summary import EditSummaryFeature
from .feature import FramesFeature
from .model import ENTRY, PRESENT, FrameListModel
from .row_painter import mark_colour, paint_tick

_HEIGHT_SHARE = 0.0375
_HEIGHTS = 30, 60
"""Height of the strip: share of the window's height, minimum and maximum [px]."""
_BAR = 4
"""Height of the bar in the colour of the state [px]."""
_MARK = 13
"""Diameter of the mark of a frame that is done or is to be checked [px]."""

Index = QModelIndex | QPersistentModelIndex


class ThumbnailPainter(QStyledItemDelegate):
    """Paints a thumbnail with a bar in the colour of the frame's state, and a mark if it is done or to be checked."""

    size = QSize()

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        """All thumbnails have one size."""
        return self.size

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        entry: Entry = index.data(ENTRY)
        colours = theme.colours(option.palette)
        box = option.rect.adjusted(1, 1, -1, -1)
        painter.save()
        painter.setRenderHints(QPainter.RenderHint.SmoothPixmapTransform | QPainter.RenderHint.Antialiasing)
        painter.fillRect(option.rect, colours.background)
        _paint_picture(painter, box, index.data(Qt.ItemDataRole.DecorationRole))
        bar = mark_colour(entry.summary.stage, colours)
        if bar is not None:
            painter.fillRect(QRect(box.left(), box.bottom() + 1 - _BAR, box.width(), _BAR), bar)
        if entry.summary.done:
            centre = _paint_plate(painter, box, colours.background)
            paint_tick(painter, centre, colours.good)
        elif entry.summary.to_check:
            _paint_plate(painter, box, colours.warning)
            painter.setPen(colours.background)
            painter.drawText(_plate(box), Qt.AlignmentFlag.AlignCenter, "!")
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if index.data(PRESENT):
            painter.setPen(QPen(option.palette.color(QPalette.ColorRole.Highlight), 2))
            painter.drawRect(box)
        elif option.state & QStyle.StateFlag.State_HasFocus or option.state & QStyle.StateFlag.State_MouseOver:
            painter.setPen(QPen(colours.muted, 1))
            painter.drawRect(box)
        painter.restore()


def _paint_picture(painter: QPainter, box: QRect, picture: QPixmap | None) -> None:
    """Paint the middle part of a thumbnail that fills the box."""
    if picture is None or picture.isNull():
        return
    part = box.size().scaled(picture.size(), Qt.AspectRatioMode.KeepAspectRatio)
    source = QRect(0, 0, part.width(), part.height())
    source.moveCenter(picture.rect().center())
    painter.drawPixmap(box, picture, source)


def _plate(box: QRect) -> QRectF:
    return QRectF(box.right() - _MARK - 1, box.top() + 2, _MARK, _MARK)


def _paint_plate(painter: QPainter, box: QRect, colour: QColor) -> QPointF:
    """Paint the disc below a mark; return its centre."""
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawEllipse(_plate(box))
    return _plate(box).center()


class FilmStrip(QListView):
    """Row of thumbnails; a click or Enter opens a frame, the arrow keys move, the wheel scrolls.

    Signals
    -------
    opened(object)
        The entry of the frame to open.
    """

    opened = Signal(object)

    def __init__(self, model: FrameListModel) -> None:
        super().__init__()
        self.setModel(model)
        self._painter = ThumbnailPainter(self)
        self.setItemDelegate(self._painter)
        self.setAccessibleName("Film strip of the frames")
        self.setFlow(QListView.Flow.LeftToRight)
        self.setUniformItemSizes(True)
        self.setFrameShape(QListView.Shape.NoFrame)
        self.setMouseTracking(True)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.clicked.connect(self._open)
        self.activated.connect(self._open)
        for changed in (model.rowsInserted, model.rowsRemoved, model.modelReset):
            changed.connect(self._fit)
        model.dataChanged.connect(self._follow_present)
        self._present: Entry | None = None
        self.set_height(_HEIGHTS[0])

    def set_height(self, height: int) -> None:
        """Set the height [px]."""
        if height != self.height() or not self.gridSize().isValid():
            self.setFixedHeight(height)
            self._painter.size = QSize(4 * height // 3, height)
            self.setGridSize(self._painter.size)
            self._fit()

    def _fit(self) -> None:
        self.setMaximumWidth(max(self.model().rowCount(), 1) * self.gridSize().width())
        self._follow_present()

    def _follow_present(self) -> None:
        """Scroll to the current frame after another one became current."""
        model = self.model()
        if isinstance(model, FrameListModel) and model.present is not self._present:
            self._present = model.present
            index = model.index_of(model.present)
            if index.isValid():
                self.setCurrentIndex(index)
                self.scrollTo(index, QAbstractItemView.ScrollHint.PositionAtCenter)

    def _open(self, index: QModelIndex) -> None:
        self.opened.emit(index.data(ENTRY))

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Scroll sideways by the usual wheel."""
        turn = event.angleDelta().y() or event.angleDelta().x()
        bar = self.horizontalScrollBar()
        bar.setValue(bar.value() - turn * self.gridSize().width() // 120)
        event.accept()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the current frame visible."""
        super().resizeEvent(event)
        if self.currentIndex().isValid():
            self.scrollTo(self.currentIndex())


_KEY = "frames/film_strip"


class FilmStripFeature(Feature):
    """The film strip, visible while the list has more than one frame, unless it is switched off."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        frames = context.feature(FramesFeature)
        self.strip = FilmStrip(frames.panel.model)
        self.strip.hide()
        self.strip.opened.connect(frames.open)
        frames.panel.thumbnails.arrived.connect(self.strip.viewport().update)
        context.centre.add_before(context.feature(EditSummaryFeature).line, self.strip)
        context.actions.add(self._commands())
        self._on = context.actions["film_strip"]
        stored = QSettings().value(_KEY, True, bool) if context.panels.persistent else True
        self._on.setChecked(stored is True)
        self._on.toggled.connect(self._keep)
        entries = context.workspace.frames.entries
        context.refresh.add("film strip", self.show, (entries.added, entries.removed, self._on.toggled))
        context.centre.installEventFilter(self)

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "film_strip",
                "Film &strip",
                "Show the frames under the images while there are several; the bar has the colour of the state",
                icon="ph.film-strip",
                checkable=True,
            ),
        )

    def show(self) -> None:
        """Show or hide the strip."""
        self.strip.setVisible(self._on.isChecked() and len(self.context.workspace.frames.entries) > 1)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Fit the strip to the height of the window."""
        if event.type() == QEvent.Type.Resize:
            least, most = _HEIGHTS
            self.strip.set_height(min(max(round(_HEIGHT_SHARE * self.context.window.height()), least), most))
        return False

    def _keep(self, on: bool) -> None:
        if self.context.panels.persistent:
            QSettings().setValue(_KEY, on)
