"""Panel of all frames: filter, list, and the user's note on a frame."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, QModelIndex, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QActionGroup, QKeyEvent, QMouseEvent, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QMenu,
    QSizePolicy,
    QTableView,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ...base import theme
from ...state.entries import Entry
from ...widgets.basics import Themed, paint_hint
from .model import ENTRY, ORDERS, STATES, FrameFilter, FrameListModel
from .row_painter import RowPainter, close_box, row_height
from .thumbnails import Thumbnails

# The view of the frame list.


class FrameView(QTableView):
    """View of the list; a click on the cross of a row only removes the frame.

    A table with one column: unlike a list view, it does not query every row when rows are inserted or removed.

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
        # a click and Enter both open a frame; a style may report one click as both
        self.clicked.connect(self._open)
        self.activated.connect(self._open)

    def chosen(self) -> list[Entry]:
        """Return the entries of the selected rows, from top to bottom."""
        return [index.data(ENTRY) for index in sorted(self.selectedIndexes(), key=QModelIndex.row)]

    def show_row(self, index: QModelIndex) -> None:
        """Scroll to a row, also if rows have just been inserted or removed."""
        self.executeDelayedItemsLayout()
        self.updateGeometries()
        self.scrollTo(index)

    def _open(self, index: QModelIndex) -> None:
        if len(self.selectedIndexes()) <= 1:  # a selection of several frames is for other commands
            self.opened.emit(index.data(ENTRY))

    def moveCursor(self, action: QAbstractItemView.CursorAction, keys: Qt.KeyboardModifier) -> QModelIndex:
        """Move to the ends of the list, not of the row, by Home and End."""
        ends = {
            QAbstractItemView.CursorAction.MoveHome: 0,
            QAbstractItemView.CursorAction.MoveEnd: self.model().rowCount() - 1,
        }
        return self.model().index(ends[action], 0) if action in ends else super().moveCursor(action, keys)

    def changeEvent(self, event: QEvent) -> None:
        """Fit the height of the rows to the font."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.FontChange:
            self._fit_rows()

    def _fit_rows(self) -> None:
        self.verticalHeader().setDefaultSectionSize(row_height(self.fontMetrics()))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Remove the selected frames by Delete; edit the note by F2."""
        plain = event.modifiers() == Qt.KeyboardModifier.NoModifier
        if event.key() == Qt.Key.Key_Delete and plain and self.chosen():
            self.removal_requested.emit(self.chosen())
        elif event.key() == Qt.Key.Key_F2 and plain and self.currentIndex().isValid():
            self.note_requested.emit(self.currentIndex().data(ENTRY))
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
            self.removal_requested.emit([pressed.data(ENTRY)])

    def _cross_at(self, event: QMouseEvent) -> QModelIndex:
        """Return the row whose cross is under the mouse at a left click; invalid for none."""
        at = event.position().toPoint()
        index = self.indexAt(at)
        if not index.isValid() or event.button() != Qt.MouseButton.LeftButton:
            return QModelIndex()
        return index if close_box(self.visualRect(index)).adjusted(-3, -3, 3, 3).contains(at) else QModelIndex()

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)


_NOTHING_OPEN = "Open a frame, or drop files or a folder of frames here"
_ROOMY = 240
"""Minimum height of the panel [px] for a permanent line for the note."""
_NONE_SHOWN = "No frame matches the filter: press Esc in the line above to show all"


class FramesPanel(QWidget):
    """Panel that shows the list and emits requests; its owner sets the contents.

    Signals
    -------
    filter_changed()
        The filter or the order has changed.
    noted(object, str)
        An entry, and the user's note on it.
    """

    filter_changed = Signal()
    noted = Signal(object, str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.thumbnails = Thumbnails(self)
        self.model = FrameListModel(self.thumbnails.of, self)
        self._noting: Entry | None = None
        """The frame of the note in the line below."""
        self.text = QLineEdit(placeholderText="Name or note", clearButtonEnabled=True)
        self.text.setAccessibleName("Filter frames by name or note")
        self.text.setToolTip("Show only frames whose name or note contains all these words")
        self.state = _choice(STATES, "Filter frames by state", "Show only frames in this state")
        self.order = _OrderButton()
        self.view = FrameView(self)
        self.view.setModel(self.model)
        self.view.hint = _NOTHING_OPEN
        self.note = _NoteLine()
        self.note.setAccessibleName("Note on the frame")
        self.note.setToolTip("Note on this frame; it is saved with the project (F2 in the list)")
        self._lay_out()
        self.setFocusProxy(self.view)
        self.thumbnails.arrived.connect(self.view.viewport().update)
        self.text.textChanged.connect(lambda _: self.filter_changed.emit())
        self.state.currentIndexChanged.connect(lambda _: self.filter_changed.emit())
        self.order.changed.connect(self.filter_changed)
        self.note.editingFinished.connect(self._take_note)
        self.note.returnPressed.connect(self.view.setFocus)
        self.note.given_up.connect(self._give_up_note)
        self.view.selectionModel().currentChanged.connect(lambda *_: self._switch_note())

    def _lay_out(self) -> None:
        self.filter_row = QWidget()
        row = QHBoxLayout(self.filter_row)
        row.setContentsMargins(6, 4, 6, 4)
        row.setSpacing(6)
        row.addWidget(self.text, 1)
        row.addWidget(self.state, 1)
        row.addWidget(self.order)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.filter_row)
        layout.addWidget(self.view, 1)
        layout.addWidget(self.note)

    @property
    def frame_filter(self) -> FrameFilter:
        """Filter and order chosen by the user."""
        return FrameFilter(self.text.text(), str(self.state.currentData()), self.order.order)

    def show_all(self) -> None:
        """Clear the filter."""
        with QSignalBlocker(self.text), QSignalBlocker(self.state):
            self.text.clear()
            self.state.setCurrentIndex(0)
        self.filter_changed.emit()

    def show_counts(self, counts: Mapping[str, int]) -> None:
        """Show the number of frames in each state."""
        for row, (state, text) in enumerate(STATES.items()):
            self.state.setItemText(row, f"{text} ({counts.get(state, 0)})")
        several = counts.get("all", 0) > 1
        self.filter_row.setVisible(several)
        self.view.hint = _NONE_SHOWN if several else _NOTHING_OPEN

    def show_present(self, entry: Entry | None) -> None:
        """Mark the current frame and scroll to it."""
        self.model.set_present(entry)
        index = self.model.index_of(entry)
        if index.isValid():
            self.view.setCurrentIndex(index)
            self.view.show_row(index)
        self._switch_note()

    def scroll_to_present(self, entry: Entry | None) -> None:
        """Scroll to the current frame after it has moved in the list."""
        index = self.model.index_of(entry)
        if index.isValid():
            if not self.view.currentIndex().isValid():
                self.view.setCurrentIndex(index)
            self.view.show_row(index)

    def show_note(self) -> None:
        """Show the note on the frame, unless it is being edited."""
        entry = self._noting
        self._fit_note()
        self.note.setPlaceholderText("" if entry is None else f"Note on {entry.name}")
        if not self.note.isModified() or not self.note.hasFocus():
            self.note.setText("" if entry is None else entry.note)

    def write_note(self, entry: Entry) -> None:
        """Edit the note on a frame."""
        self.view.setCurrentIndex(self.model.index_of(entry))
        self._switch_note()
        self.note.show()
        self.note.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.note.selectAll()

    def _switch_note(self) -> None:
        row = self.view.currentIndex().row()
        entry = self.model.entries[row] if 0 <= row < len(self.model.entries) else self.model.present
        if entry is not self._noting:
            self._take_note()
            self._noting = entry
        self.show_note()

    def _fit_note(self) -> None:
        """Show the line of the note if there is enough space, if it has text, or if it is being edited."""
        entry, writing = self._noting, self.note.hasFocus()
        self.note.setVisible(entry is not None and (writing or bool(entry.note) or self.height() > _ROOMY))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_note()

    def _take_note(self) -> None:
        entry, text = self._noting, self.note.text().strip()
        if entry is not None and self.note.isModified():
            self.note.setModified(False)
            self.noted.emit(entry, text)

    def _give_up_note(self) -> None:
        """Discard the edit of the note."""
        self.note.setModified(False)
        self.view.setFocus()
        self.show_note()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if no thread is left."""
        self._take_note()
        return self.thumbnails.shutdown()


class _NoteLine(QLineEdit):
    """Line edit in which Escape cancels the edit, and has no other effect in the window."""

    given_up = Signal()

    def event(self, event: QEvent) -> bool:
        """Handle Escape in this line."""
        if isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            event.accept()
            if event.type() == QEvent.Type.KeyPress:
                self.given_up.emit()
            return True
        return super().event(event)


class _OrderButton(Themed, QToolButton):
    """Button with a menu of orders; its icon shows whether the list is sorted."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.order = next(iter(ORDERS))
        self.setAccessibleName("Sort frames")
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.setAutoRaise(True)
        menu = QMenu(self)
        group = QActionGroup(menu)
        for order, text in ORDERS.items():
            action = menu.addAction(text)
            action.setCheckable(True)
            action.setChecked(order == self.order)
            action.triggered.connect(lambda _=False, order=order: self.choose(order))
            group.addAction(action)
        self.setMenu(menu)
        self._take_theme()

    def choose(self, order: str) -> None:
        """Sort by another of `ORDERS`."""
        self.order = order
        self._take_theme()
        self.changed.emit()

    def _take_theme(self) -> None:
        own = self.order == next(iter(ORDERS))
        self.setIcon(theme.icon("ph.list-numbers" if own else "ph.sort-ascending", self.palette()))
        self.setToolTip(f"{ORDERS[self.order]}. Next and previous frame follow this order")


def _choice(texts: Mapping[str, str], name: str, hint: str) -> QComboBox:
    box = QComboBox()
    for value, text in texts.items():
        box.addItem(text, value)
    box.setAccessibleName(name)
    box.setToolTip(hint)
    box.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
    return box
