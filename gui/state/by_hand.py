"""Depth by hand of the current frame, its proposals, and the command that changes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.data.by_hand import DepthByHand
from ilf.data.label_map import Box

from .blocks import WorkspaceBlocks
from .frames import WorkspaceFrames
from .session import Session
from .swap import Swap

Depth = NDArray[np.float32]


class HandDepthChange(NamedTuple):
    """A change of depth by hand that was made, undone or redone: the session, and the blocks with changed pixels."""

    session: Session
    blocks: frozenset[int]


class WorkspaceByHand(QObject):
    """Depth by hand of the frames, and the proposal that is shown before it is taken.

    Signals
    -------
    changed(object)
        Depth by hand has changed: a `HandDepthChange`.
    proposed()
        The proposal of the current frame has changed or was dropped.
    """

    changed = Signal(object)
    proposed = Signal()

    def __init__(self, frames: WorkspaceFrames, blocks: WorkspaceBlocks, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._frames = frames
        self._blocks = blocks

    def set_depth(self, depth: Depth, where: NDArray[np.bool_], text: str) -> bool:
        """Set depth by hand [m], float32 (H, W), NaN for none, at the pixels in `where`, bool (H, W), as one undo step;
        False if nothing changes.

        Raises
        ------
        InputError
            If a depth is out of range.
        """
        session = self._frames.session
        box = _box_of(where)
        if box is None:
            return False
        before = _part(session, box)
        after = np.where(where[box], depth[box], before)
        if np.array_equal(before, after, equal_nan=True):
            return False
        DepthByHand(after)  # refuses it before it becomes a step

        def exchange(depth: Depth) -> Depth:
            former = _part(session, box)
            blocks = session.take_by_hand(box, depth)
            self.changed.emit(HandDepthChange(session, blocks))
            self._blocks.validity_changed.emit(session)
            return former

        session.undo_stack.push(Swap(text, after, exchange))
        return True

    def propose(self, depth: Depth | None) -> None:
        """Show depth [m], float32 (H, W), NaN for none, in place of the completed depth until it is taken or dropped;
        None drops it."""
        if not self._frames.has_session or depth is self._frames.session.proposal:
            return
        self._frames.session.propose(depth)
        self.proposed.emit()


def _part(session: Session, box: Box) -> Depth:
    """Return a copy of depth by hand in a box."""
    if session.blocks.by_hand is None:
        return np.full(session.labels[box].shape, np.nan, np.float32)
    return session.blocks.by_hand.depth[box].copy()


def _box_of(mask: NDArray[np.bool_]) -> Box | None:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not rows.size:
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
