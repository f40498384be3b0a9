"""The undo step that exchanges a value with its former one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from PySide6.QtGui import QUndoCommand

Value = TypeVar("Value")


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
