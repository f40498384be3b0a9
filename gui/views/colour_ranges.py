"""Colour ranges of all views: one for all depths, one for all differences and errors, one for expected errors."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf.drawing.colours import robust_depth_levels

from .colours import FIXED, KINDS, Levels, Range, depth_table, full_levels
from .view_data import ViewData


class ColourRanges(QObject):
    """Colour range of each kind (`colours.KINDS`), and the depth colour map.

    Signals
    -------
    changed()
        A range or the colour map may have changed.
    """

    changed = Signal()

    def __init__(self, data: ViewData, parent: QObject) -> None:
        super().__init__(parent)
        self._data = data

    @property
    def depth(self) -> Levels:
        """Depth [m] at the ends of the depth colours."""
        return self.of("depth").levels or (0.0, 1.0)

    def of(self, kind: str) -> Range:
        """Colour range of a kind."""
        return self._data.ranges[kind]

    def set(self, kind: str, mode: str, levels: Levels | None = None, locked: bool | None = None) -> None:
        """Set the mode (`colours.MODES`), the ends or the lock of the colour range of a kind.

        Raises
        ------
        ValueError
            If the lower end is not below the upper one.
        """
        if levels is not None and not levels[0] < levels[1]:
            low, high = levels
            raise ValueError(f"the lower end must be below the upper one, not {low:g} and {high:g} {KINDS[kind]}")
        one = self.of(kind)
        one.mode, one.locked = mode, one.locked if locked is None else locked
        if levels is not None:
            one.levels = float(levels[0]), float(levels[1])
        elif mode != FIXED and not one.locked:
            one.levels = None
        self.update_depth_range()
        self.changed.emit()

    def set_depth_map(self, name: str) -> None:
        """Set the depth colour map by a name of `colours.DEPTH_MAPS`."""
        self._data.depth_table = depth_table(name)
        self._data.depth_map = name
        self.changed.emit()

    def reset_for_frame(self) -> None:
        """Update all ranges except locked ones for the current frame."""
        for one in self._data.ranges.values():
            one.reset_for_frame()
        self.update_depth_range()

    def update_for_result(self) -> None:
        """Update the full range of depth for a changed result."""
        before = self.depth
        self.update_depth_range()
        if self.depth != before:
            self.changed.emit()

    def update_depth_range(self) -> None:
        """Update the range of all depths from depth in; the full range also from the result."""
        frame, result = self._data.frame, self._data.result
        if frame is None:
            return
        depth_in = frame.own_depth
        depths = [depth_in] if result is None else [depth_in, result.depth]

        def full() -> Levels:
            ends = np.array([full_levels(depth) for depth in depths])
            return float(ends[:, 0].min()), float(ends[:, 1].max())

        self.of("depth").find(lambda: robust_depth_levels(depth_in), full)
