"""The rows of the frame list, to click and to walk through."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPaintEvent
from PySide6.QtWidgets import QAbstractItemView, QListView, QWidget

from gui.frame_list.list_model import ENTRY, Index
from gui.frame_list.row_painter import RowPainter, close_box
from gui.state.entries import Entry
from gui.widgets.hint import paint_hint


class FrameView(QListView):
    """Clicks on a row's cross take the frame out and do nothing else.

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
        self.setFrameShape(QListView.Shape.NoFrame)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setUniformItemSizes(True)
        # a click and Enter both mean it, and a style may report one click as both
        self.clicked.connect(self._open)
        self.activated.connect(self._open)

    def chosen(self) -> list[Entry]:
        """The entries of the chosen rows, from top to bottom."""
        return [index.data(ENTRY) for index in sorted(self.selectedIndexes(), key=QModelIndex.row)]

    def _open(self, index: QModelIndex) -> None:
        if len(self.selectedIndexes()) <= 1:  # more are chosen for something else
            self.opened.emit(index.data(ENTRY))

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

    def dataChanged(self, topLeft: Index, bottomRight: Index, roles: Sequence[int] = ()) -> None:
        """Rows look different, and are as high as before: there is no need to lay all of them out again."""
        self.viewport().update(self.visualRect(topLeft).united(self.visualRect(bottomRight)))

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)
