"""What of the state has changed, how the window is told of it, and how it is undone. It draws by the parts."""

from __future__ import annotations

from collections.abc import Callable
from enum import Flag, auto
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import Box
from ilf.segmentation.editing.patches import LabelPatch

if TYPE_CHECKING:
    from .document import Document

Value = TypeVar("Value")


class Part(Flag):
    """A part of the state of the current frame, or of the window. Several changes of one turn of the event loop are one
    set of parts."""

    FRAME = auto()
    """Another frame is the current one, or none is: everything shown is of another frame."""
    LIST = auto()
    """Frames were added, opened, closed or removed, or their summaries, notes or order changed."""
    LABELS = auto()
    """The label map; `STROKE` while a stroke is in progress, which may still be cancelled."""
    STROKE = auto()
    REPLACED = auto()
    """All blocks were replaced, or restored by undo; not an edit."""
    INFOS = auto()
    """Names, colours, locks and visibility of blocks."""
    SELECTION = auto()
    INVALID_MASK = auto()
    GUIDE = auto()
    NEIGHBOURS = auto()
    BY_HAND = auto()
    PROPOSAL = auto()
    """Depth that is shown in place of the completed one until it is taken or dropped."""
    GROUND_TRUTH = auto()
    REGION = auto()
    """The rectangle."""
    MARKS = auto()
    """The profile line or the measurements."""
    IGNORED = auto()
    """Flagged places that are ignored."""
    PARAMETERS = auto()
    """Of the filter: common, own or shared ones."""
    EXTRACTION = auto()
    """Parameters of the extraction."""
    RESULTS = auto()
    """Results changed, were removed, or may be stale after an edit of what depth depends on; or a run has ended."""
    SOME_RESULTS = auto()
    """The run in progress has new results; up to several times a second."""
    RECORDS = auto()
    """Running blocks have new records."""
    PREVIEWS = auto()
    """The depth of running blocks."""
    EXPECTED_ERROR = auto()
    HISTORY = auto()
    """The run history."""
    COMPARED = auto()
    """The runs that are compared with the current result."""
    ITERATION = auto()
    """The earlier iteration that the views show."""
    RUNNING = auto()
    """A run has started, paused, gone on or ended."""
    CONTENT = auto()
    """Content of a frame that a project stores has changed."""
    LOADING = auto()
    """Frames are being read, or are not any more."""
    DEPTH = FRAME | LABELS | RESULTS | INVALID_MASK | NEIGHBOURS | ITERATION
    """All that the depth in the views depends on, but for a run in progress."""


NO_PART = Part(0)
EVERY_PART = ~NO_PART


DrawnChange = tuple[Box, NDArray[np.bool_], NDArray[np.bool_]]
"""Where drawn borders change, and the drawn pixels there before and after."""


class Edit(NamedTuple):
    """A change of what the depth of blocks depends on, which was made, undone or redone.

    Attributes
    ----------
    document : Document
    blocks : frozenset of int
        Blocks whose depth is concerned.
    text : str
        The name of the edit.
    part : Part
        What was changed: the label map, depth by hand, the invalid mask, the guide or the depth of neighbours.
    patch : LabelPatch or None
        The change of the label map in forward direction.
    forward : bool
        False if it was undone.
    drawn : (Box, ndarray of bool, ndarray of bool) or None
        Where drawn borders change, and the drawn pixels there before the edit and after it.
    """

    document: Document
    blocks: frozenset[int]
    text: str
    part: Part
    patch: LabelPatch | None = None
    forward: bool = True
    drawn: DrawnChange | None = None


class Changes(QObject):
    """The channel from documents to the window.

    Signals
    -------
    changed(Part)
        What has changed of the current document and of the list, once per turn of the event loop.
    edited(object)
        An undoable change of what the depth of blocks depends on, of any document, at once: an `Edit`.
    labels_changed(object)
        The box (rows, columns) of the current label map that has changed, at once, also by a stroke in progress.
    about_to_change()
        The current document or its label map is about to change: strokes in progress must end.
    touched(object)
        Content of a document that a project stores has changed.
    """

    changed = Signal(object)
    edited = Signal(object)
    labels_changed = Signal(object)
    about_to_change = Signal()
    touched = Signal(object)
    _wanted = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.shown: Any = None
        self._parts = NO_PART
        self._awaited = False
        self._listeners: list[tuple[Part, Callable[[], None]]] = []
        # not a timer with interval 0: the next user input would be handled before it
        self._wanted.connect(self.tell, Qt.ConnectionType.QueuedConnection)

    def on(self, parts: Part, call: Callable[[], None]) -> None:
        """Call a function in each turn in which one of these parts has changed, before `changed` is emitted."""
        self._listeners.append((parts, call))

    def note(self, part: Part, document: object = None) -> None:
        """Note that a part has changed: `changed` tells it in the next turn of the event loop. Of a `document` that is
        not shown, only its summary in the list is."""
        self._parts |= part if document is None or document is self.shown else Part.LIST
        self.wake()

    def wake(self) -> None:
        """Tell in the next turn of the event loop, even if no part has changed."""
        if not self._awaited:
            self._awaited = True
            self._wanted.emit()

    def touch(self, document: object) -> None:
        """Tell that content of a document that a project stores has changed."""
        self.touched.emit(document)
        self.note(Part.CONTENT, document)

    def tell(self) -> None:
        """Tell now what would be told in the next turn."""
        self._awaited = False
        parts, self._parts = self._parts, NO_PART
        for wanted, call in self._listeners:
            if wanted & parts:
                call()
        self.changed.emit(parts)


class Swap(QUndoCommand, Generic[Value]):
    """A change of a value. Redo and undo exchange it with the former one.

    Parameters
    ----------
    text : str
        The name of the step.
    value : object
        The new value.
    exchange : callable
        Sets a value, reports the change and returns the former value.
    """

    def __init__(self, text: str, value: Value, exchange: Callable[[Value], Value]) -> None:
        super().__init__(text)
        self._other = value
        self._exchange = exchange

    def redo(self) -> None:
        """Exchange the values."""
        self._other = self._exchange(self._other)

    undo = redo
