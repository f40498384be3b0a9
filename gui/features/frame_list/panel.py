"""Panel of all frames: filter and list."""

from __future__ import annotations

from collections.abc import Callable, Collection

from PySide6.QtCore import QItemSelectionModel, QModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QPaintEvent, QPixmap, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QLineEdit,
    QListView,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from ...state.workspace import Entry
from ...widgets.basics import combo, lay_out, paint_hint
from .model import ENTRY, ORDERS, STATES, FrameListModel, counts, shown_entries
from .painter import FramePainter
from .thumbnails import Thumbnails, reader_of

_ROW_WIDTH = 190
"""Width that a row takes where nothing else gives one: thumbnail and a short name [px]."""


class FrameView(QListView):
    """View of the list, as rows or as a strip of thumbnails.

    Signals
    -------
    opened(object)
        The entry was clicked, or Enter was pressed on it.
    note_requested(object)
        Request to edit the note on the entry (F2).
    removal_requested(list)
        Request to remove entries from the list.
    """

    opened = Signal(object)
    note_requested = Signal(object)
    removal_requested = Signal(list)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hint = ""
        """Text of an empty list."""
        self._painter = FramePainter((), self)
        self.setAccessibleName("Frames")
        self.setItemDelegate(self._painter)
        self.setUniformItemSizes(True)
        self.setMouseTracking(True)
        self.setFrameShape(QListView.Shape.NoFrame)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        # a click and Enter both open a frame; a style may report one click as both
        self.clicked.connect(self._open)
        self.activated.connect(self._open)

    @property
    def is_strip(self) -> bool:
        """Whether thumbnails are shown side by side, not rows."""
        return self._painter.strip_height > 0

    def set_strip(self, height: int) -> None:
        """Show thumbnails of this height side by side [px]; rows for 0."""
        if height == self._painter.strip_height:
            return
        self._painter.strip_height = height
        self.setFlow(QListView.Flow.LeftToRight if height else QListView.Flow.TopToBottom)
        off, as_needed = Qt.ScrollBarPolicy.ScrollBarAlwaysOff, Qt.ScrollBarPolicy.ScrollBarAsNeeded
        self.setVerticalScrollBarPolicy(off if height else as_needed)
        self.scheduleDelayedItemsLayout()
        self.show_frame(self.currentIndex())

    def sizeHint(self) -> QSize:
        """As much as a row needs, so that the panel leaves room for the images where it is docked beside them."""
        return QSize(_ROW_WIDTH, super().sizeHint().height())

    def chosen(self) -> list[Entry]:
        """Return the entries of the selected frames, in their order."""
        return [index.data(ENTRY) for index in sorted(self.selectedIndexes(), key=QModelIndex.row)]

    def choose(self, index: QModelIndex) -> None:
        """Make a frame the current one and select it alone, also while the keys of a command with Ctrl are held."""
        self.selectionModel().setCurrentIndex(index, QItemSelectionModel.SelectionFlag.ClearAndSelect)

    def show_frame(self, index: QModelIndex) -> None:
        """Scroll to a frame, also if others have just been inserted or removed."""
        if index.isValid():
            self.executeDelayedItemsLayout()
            centre, visible = QAbstractItemView.ScrollHint.PositionAtCenter, QAbstractItemView.ScrollHint.EnsureVisible
            self.scrollTo(index, centre if self.is_strip else visible)

    def _open(self, index: QModelIndex) -> None:
        if len(self.selectedIndexes()) <= 1:  # a selection of several frames is for other commands
            self.opened.emit(index.data(ENTRY))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the current frame of a strip visible."""
        super().resizeEvent(event)
        if self.is_strip and self.currentIndex().isValid():
            self.scrollTo(self.currentIndex())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Remove the selected frames by Delete; edit the note by F2."""
        plain = event.modifiers() == Qt.KeyboardModifier.NoModifier
        if event.key() == Qt.Key.Key_Delete and plain and self.chosen():
            self.removal_requested.emit(self.chosen())
        elif event.key() == Qt.Key.Key_F2 and plain and self.currentIndex().isValid():
            self.note_requested.emit(self.currentIndex().data(ENTRY))
        else:
            super().keyPressEvent(event)

    def write_note(self, index: QModelIndex) -> None:
        """Edit the note on a frame, in its row."""
        self.choose(index)
        self.edit(index)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)


_NOTHING_OPEN = "Open a frame, or drop files or a folder of frames here"
_UNLIMITED = (1 << 24) - 1
"""Qt's maximum size of a widget that is not limited [px]."""
_NONE_SHOWN = "No frame matches the filter: press Esc in the line above to show all"


class FramesPanel(QWidget):
    """Panel that shows the list, as rows or as a strip, with a filter; its owner sets the contents.

    Parameters
    ----------
    stored : callable
        Returns the stored thumbnail of the frame with an id; None if there is none. Called in a worker thread.
    """

    def __init__(self, stored: Callable[[str], bytes | None]) -> None:
        super().__init__()
        self._stored = stored
        self.thumbnails = Thumbnails(self)
        self.model = FrameListModel(self.picture_of, self)
        self._bar = 0
        self._entries: Collection[Entry] = ()
        self.text = QLineEdit(placeholderText="Name or note", clearButtonEnabled=True)
        self.text.setAccessibleName("Filter frames by name or note")
        self.text.setToolTip("Show only frames whose name or note contains all these words")
        self.state = combo(STATES, "Show only frames in this state", "Filter frames by state")
        self.order = combo(ORDERS, "Order of the list, which next and previous frame follow", "Sort frames")
        self.state.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        for choice in (self.state, self.order):
            choice.currentIndexChanged.connect(lambda _: self.show_entries(self._entries, self.model.present))
        self.view = FrameView(self)
        self.view.setModel(self.model)
        self.view.hint = _NOTHING_OPEN
        self.filter_row, fields = QWidget(), (self.text, self.state, self.order)
        lay_out(QHBoxLayout(self.filter_row), *fields, margins=(6, 4, 6, 4), spacing=6, stretched=fields)
        lay_out(QVBoxLayout(self), self.filter_row, self.view, spacing=0, stretched=self.view)
        self.setFocusProxy(self.view)
        self.thumbnails.arrived.connect(self.view.viewport().update)
        self.model.layoutChanged.connect(self._fit)
        self.text.textChanged.connect(lambda _: self.show_entries(self._entries, self.model.present))

    def picture_of(self, entry: Entry) -> QPixmap | None:
        """Return the thumbnail of an entry; None while it is pending, an empty one if it cannot be made, until its
        files are found elsewhere."""
        files = None if entry.source is None else (entry.source.rgb, entry.source.key)
        return self.thumbnails.of((entry.id, files), reader_of(entry, self._stored))

    def set_bar(self, height: int) -> None:
        """Show only a strip of this height [px], no wider than its thumbnails; 0 for rows, with the filter above."""
        self._bar = height
        self.setMinimumHeight(height)
        self.setMaximumHeight(height or _UNLIMITED)
        self.view.set_strip(height)
        self._fit()

    def _fit(self) -> None:
        self.setMaximumWidth(max(self.model.rowCount(), 1) * (4 * self._bar // 3) if self._bar else _UNLIMITED)
        self.filter_row.setVisible(len(self._entries) > 1 and not self._bar)

    def show_entries(self, entries: Collection[Entry], present: Entry | None) -> None:
        """Show the frames that match the user's filter, and the current one, in the chosen order. The current one is
        scrolled to when it or its row has changed, and selected if it has."""
        self._entries = entries
        self._fit()
        self.view.hint = _NONE_SHOWN if len(entries) > 1 else _NOTHING_OPEN
        if self.filter_row.isVisible():
            found = counts(entries)
            for row, (state, text) in enumerate(STATES.items()):
                self.state.setItemText(row, f"{text} ({found[state]})")
        model, view = self.model, self.view
        former, row = model.present, model.row_of(present)
        model.present = present
        state, order = self.state.currentData(), self.order.currentData()
        model.set_entries(shown_entries(entries, self.text.text(), state, order, present))
        index = model.index_of(present)
        if index.isValid() and (present is not former or index.row() != row):
            if present is not former or not view.currentIndex().isValid():
                view.choose(index)
            view.show_frame(index)
