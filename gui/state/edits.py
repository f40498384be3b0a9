"""Undo steps, and what is told of those that change depth. Parameters have theirs in `parameters.py`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoCommand

from ilf.data.label_map import Box
from ilf.segmentation.editing.patches import LabelPatch

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
