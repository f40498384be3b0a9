"""The undo steps of a document's blocks and results. Parameters have theirs in `parameters.py`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import Blocks
from ilf.data.label_map import Box
from ilf.segmentation.editing.patches import LabelPatch, redrawn

from .frame_data import touched_by
from .parts import Part

if TYPE_CHECKING:
    from .document import Document

DrawnChange = tuple[Box, NDArray[np.bool_], NDArray[np.bool_]]
"""Where drawn borders change, and the drawn pixels there before and after."""

Value = TypeVar("Value")


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


class EditLabels(QUndoCommand):
    """A change of the label map.

    New borders become drawn borders. With `blocks`, they do not: all that is said about the blocks changes too, as when
    all blocks are replaced.
    """

    def __init__(self, document: Document, patch: LabelPatch, text: str, blocks: Blocks | None = None) -> None:
        super().__init__(text)
        self._document = document
        self._patch = patch
        self._other_blocks = blocks
        to_check = document.state.to_check
        if to_check:
            to_check = to_check - touched_by(patch) if blocks is None else to_check & blocks.kept
        self._other_to_check = to_check
        self._drawn: DrawnChange | None = None
        if blocks is None:
            former = document.blocks.drawn
            box, drawn = redrawn(former, document.labels, patch)
            self._drawn = box, np.zeros_like(drawn) if former is None else former[box].copy(), drawn

    def redo(self) -> None:
        """Apply the change."""
        self._take(forward=True)

    def undo(self) -> None:
        """Undo the change."""
        self._take(forward=False)

    def _take(self, forward: bool) -> None:
        document, edit = self._document, None
        document.prepare_change()
        document.apply(self._patch, forward)
        to_check = document.state.to_check
        document.change(to_check=self._other_to_check)
        self._other_to_check = to_check
        if self._other_blocks is not None:
            self._other_blocks = document.take_blocks(self._other_blocks)
        elif self._drawn is not None:
            box, before, after = self._drawn
            blocks = touched_by(self._patch)
            edit = Edit(document, blocks, self.text(), Part.LABELS, self._patch, forward, self._drawn)
            document.draw(box, after if forward else before, blocks)
        document.note_labels_changed(self._patch, edit)
