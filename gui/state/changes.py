"""What has changed in the documents, told to the window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal

from .parts import NO_PART, Part


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
        self._shown: Any = None
        self._parts = NO_PART
        self._listeners: list[tuple[Part, Callable[[], None]]] = []
        # not a timer with interval 0: the next user input would be handled before it
        self._wanted.connect(self.tell, Qt.ConnectionType.QueuedConnection)

    def on(self, parts: Part, call: Callable[[], None]) -> None:
        """Call a function in each turn in which one of these parts has changed, before `changed` is emitted."""
        self._listeners.append((parts, call))

    def is_shown(self, document: object) -> bool:
        """Whether this is the current document."""
        return document is self._shown

    def note(self, part: Part, document: object = None) -> None:
        """Note that a part has changed: `changed` tells it in the next turn of the event loop. Of a `document` that is
        not shown, only its summary in the list is."""
        if not self._parts:
            self._wanted.emit()
        self._parts |= part if document is None or document is self._shown else Part.LIST

    def touch(self, document: object) -> None:
        """Tell that content of a document that a project stores has changed."""
        self.touched.emit(document)
        self.note(Part.CONTENT, document)

    def tell(self) -> None:
        """Tell now what would be told in the next turn."""
        parts, self._parts = self._parts, NO_PART
        for wanted, call in self._listeners:
            if wanted & parts:
                call()
        if parts:
            self.changed.emit(parts)
