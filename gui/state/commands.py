"""Undoable commands. Each is one step for the user, with a text that says what it did."""

from __future__ import annotations

from typing import Any, Protocol

from PySide6.QtGui import QUndoCommand

from gui.state.session import BlockNotes, Session
from ilf.ebs.edit import LabelPatch


class Notices(Protocol):
    """Who is told before and after a command changes a session."""

    def prepare_change(self, session: Session) -> None:
        """The label map is about to change."""
        ...

    def note_labels_changed(self, session: Session, patch: LabelPatch) -> None:
        """The label map has changed."""
        ...

    def note_infos_changed(self, session: Session) -> None:
        """A name, colour or lock has changed."""
        ...


class EditLabels(QUndoCommand):
    """A change of the label map.

    With `done`, the map has it already (a brush paints while it moves). With `notes`, what is known of the
    blocks changes with them, as when all blocks are replaced.
    """

    def __init__(
        self,
        notices: Notices,
        session: Session,
        patch: LabelPatch,
        text: str,
        done: bool = False,
        notes: BlockNotes | None = None,
    ) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._patch = patch
        self._done = done
        self._other_notes = notes

    def redo(self) -> None:
        """Make the change."""
        if not self._done:
            self._notices.prepare_change(self._session)
            self._session.apply(self._patch)
        self._done = False
        self._swap_notes()
        self._notices.note_labels_changed(self._session, self._patch)

    def undo(self) -> None:
        """Take it back."""
        self._notices.prepare_change(self._session)
        self._session.apply(self._patch, forward=False)
        self._swap_notes()
        self._notices.note_labels_changed(self._session, self._patch)

    def _swap_notes(self) -> None:
        if self._other_notes is not None:
            self._other_notes = self._session.take_notes(self._other_notes)


class EditInfo(QUndoCommand):
    """A change of a block's name, colour or lock."""

    def __init__(self, notices: Notices, session: Session, label: int, text: str, **changes: Any) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._label = label
        info = session.info(label)
        self._before = {name: getattr(info, name) for name in changes}
        self._after = changes

    def redo(self) -> None:
        """Make the change."""
        self._change(self._after)

    def undo(self) -> None:
        """Take it back."""
        self._change(self._before)

    def _change(self, values: dict[str, Any]) -> None:
        self._session.change_info(self._label, **values)
        self._notices.note_infos_changed(self._session)
