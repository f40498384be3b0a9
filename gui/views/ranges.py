"""Which numbers the ends of the colours stand for. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Levels = tuple[float, float]

KINDS = {"depth": "m", "signed": "mm", "expected": "mm"}
"""Ranges that there are, and their units: of all depths, of differences and errors, of expected errors."""
ROBUST, FULL, FIXED = "robust", "full", "fixed"
MODES = {ROBUST: "Robust", FULL: "Full", FIXED: "Fixed"}
"""Ways to a range: what nearly all values lie in; what all of them lie in; two numbers."""


@dataclass
class Range:
    """How the levels of one kind are found.

    Attributes
    ----------
    mode : str
        One of `MODES`.
    levels : (float, float) or None
        The last levels, or the fixed ones.
    locked : bool
        Whether they stay as they are, whatever is shown.
    """

    mode: str = ROBUST
    levels: Levels | None = None
    locked: bool = False

    def find(self, robust: Callable[[], Levels], full: Callable[[], Levels]) -> Levels:
        """The levels for values whose robust and full ones are these."""
        if self.levels is None or not (self.locked or self.mode == FIXED):
            self.levels = full() if self.mode == FULL else robust()
        return self.levels

    def turn_to_another_frame(self) -> None:
        """Numbers that were set for a frame go with it, unless they are locked."""
        if not self.locked:
            self.levels = None
            if self.mode == FIXED:
                self.mode = ROBUST
