"""Undoable commands. Each is one step for the user, with a text that says what it did."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtGui import QUndoCommand

from gui.session import BlockInfo, Session
from ilf.ebs.edit import LabelPatch

if TYPE_CHECKING:
    from gui.workspace import Workspace


class EditLabels(QUndoCommand):
    """A change of the label map.

    With `done`, the map has it already (a brush paints while it moves). With `infos`, what was known of the
    blocks changes with them, as when all blocks are replaced.
    """

    def __init__(
        self,
        workspace: Workspace,
        session: Session,
        patch: LabelPatch,
        text: str,
        done: bool = False,
        infos: dict[int, BlockInfo] | None = None,
    ) -> None:
        super().__init__(text)
        self._workspace = workspace
        self._session = session
        self._patch = patch
        self._done = done
        self._other_infos = infos

    def redo(self) -> None:
        """Make the change."""
        if not self._done:
            self._session.apply(self._patch)
        self._done = False
        self._swap_infos()
        self._workspace.note_labels_changed(self._session, self._patch)

    def undo(self) -> None:
        """Take it back."""
        self._session.apply(self._patch, forward=False)
        self._swap_infos()
        self._workspace.note_labels_changed(self._session, self._patch)

    def _swap_infos(self) -> None:
        if self._other_infos is not None:
            self._session.infos, self._other_infos = self._other_infos, self._session.infos


class EditInfo(QUndoCommand):
    """A change of a block's name, colour or lock."""

    def __init__(self, workspace: Workspace, session: Session, label: int, text: str, **changes: object) -> None:
        super().__init__(text)
        self._workspace = workspace
        self._session = session
        self._label = label
        self._before: BlockInfo = session.info(label)
        self._changes = changes

    def redo(self) -> None:
        """Make the change."""
        self._session.change_info(self._label, **self._changes)
        self._workspace.note_infos_changed(self._session)

    def undo(self) -> None:
        """Take it back."""
        self._session.infos[self._label] = self._before
        self._workspace.note_infos_changed(self._session)
