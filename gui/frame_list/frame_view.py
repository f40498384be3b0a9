"""The rows of the frame list, to click and to walk through."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QModelIndex, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPaintEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView, QWidget

from gui.frame_list.list_model import ENTRY
from gui.frame_list.row_painter import RowPainter, close_box, row_height
from gui.state.entries import Entry
from gui.widgets.hint import paint_hint


class FrameView(QTableView):
    """Clicks on a row's cross take the frame out and do nothing else.

    A table of one column: unlike a list, it does not ask for every row whenever rows come or go.

    Signals
    -------
    opened(object)
        The entry that was clicked, or that Enter was pressed on.
    note_wished(object)
        The entry that is to have a note (F2).
    removal_wished(list)
        Entries that are to be taken out of the list.
    """

    opened = Signal(object)
    note_wished = Signal(object)
    removal_wished = Signal(list)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hint = ""
        """What an empty list says."""
        self._closing = QModelIndex()
        self.setAccessibleName("Frames")
        self.setItemDelegate(RowPainter(self))
        self.setMouseTracking(True)
        self.setFrameShape(QTableView.Shape.NoFrame)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.horizontalHeader().setStretchLastSection(True)
        self.horizontalHeader().hide()
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.verticalHeader().hide()
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self._fit_rows()
        # a click and Enter both mean it, and a style may report one click as both
        self.clicked.connect(self._open)
        self.activated.connect(self._open)

    def chosen(self) -> list[Entry]:
        """The entries of the chosen rows, from top to bottom."""
        return [index.data(ENTRY) for index in sorted(self.selectedIndexes(), key=QModelIndex.row)]

    def show_row(self, index: QModelIndex) -> None:
        """Have a row in sight, also if rows have come or gone just now."""
        self.executeDelayedItemsLayout()
        self.updateGeometries()
        self.scrollTo(index)

    def _open(self, index: QModelIndex) -> None:
        if len(self.selectedIndexes()) <= 1:  # more are chosen for something else
            self.opened.emit(index.data(ENTRY))

    def moveCursor(self, action: QAbstractItemView.CursorAction, keys: Qt.KeyboardModifier) -> QModelIndex:
        """Home and End are the ends of the list, not of a row."""
        ends = {
            QAbstractItemView.CursorAction.MoveHome: 0,
            QAbstractItemView.CursorAction.MoveEnd: self.model().rowCount() - 1,
        }
        return self.model().index(ends[action], 0) if action in ends else super().moveCursor(action, keys)

    def changeEvent(self, event: QEvent) -> None:
        """Rows are as high as their text."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit_rows()

    def _fit_rows(self) -> None:
        self.verticalHeader().setDefaultSectionSize(row_height(self.fontMetrics()))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Delete takes the chosen frames out, F2 asks for a note."""
        plain = event.modifiers() == Qt.KeyboardModifier.NoModifier
        if event.key() == Qt.Key.Key_Delete and plain and self.chosen():
            self.removal_wished.emit(self.chosen())
        elif event.key() == Qt.Key.Key_F2 and plain and self.currentIndex().isValid():
            self.note_wished.emit(self.currentIndex().data(ENTRY))
        else:
            super().keyPressEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._closing = self._cross_at(event)
        if not self._closing.isValid():
            super().mousePressEvent(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        pressed, self._closing = self._closing, QModelIndex()
        if not pressed.isValid():
            super().mouseReleaseEvent(event)
        elif self._cross_at(event) == pressed:
            self.removal_wished.emit([pressed.data(ENTRY)])

    def _cross_at(self, event: QMouseEvent) -> QModelIndex:
        """The row whose cross is under the mouse at a left click."""
        at = event.position().toPoint()
        index = self.indexAt(at)
        if not index.isValid() or event.button() != Qt.MouseButton.LeftButton:
            return QModelIndex()
        return index if close_box(self.visualRect(index)).adjusted(-3, -3, 3, 3).contains(at) else QModelIndex()

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)
