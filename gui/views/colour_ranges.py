"""The ends of the colours of all views: one range for all depths, one for all differences and errors."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf.drawing.colours import robust_depth_levels

from .colours import FIXED, FULL, KINDS, Levels, Range, depth_table
from .painter import Material, full_levels


class ColourRanges(QObject):
    """How the levels of each kind (`ranges.KINDS`) are found, and the colours of depth.

    Signals
    -------
    changed()
        There may be other levels, or other colours.
    """

    changed = Signal()

    def __init__(self, material: Material, parent: QObject) -> None:
        super().__init__(parent)
        self._material = material

    @property
    def depth(self) -> Levels:
        """Depth [m] at the ends of the depth colours."""
        return self.of("depth").levels or (0.0, 1.0)

    @property
    def depth_map(self) -> str:
        """The depth colours, one of `colour_maps.DEPTH_MAPS`."""
        return self._material.depth_map

    def of(self, kind: str) -> Range:
        """How the levels of a kind are found."""
        return self._material.ranges[kind]

    def set(self, kind: str, mode: str, levels: Levels | None = None, locked: bool | None = None) -> None:
        """Find the levels of a kind in another way (`ranges.MODES`), or set them, or lock or unlock them.

        Raises
        ------
        ValueError
            If the lower level is not below the upper one.
        """
        if levels is not None and not levels[0] < levels[1]:
            low, high = levels
            raise ValueError(f"the lower level must be below the upper one, not {low:g} and {high:g} {KINDS[kind]}")
        one = self.of(kind)
        one.mode, one.locked = mode, one.locked if locked is None else locked
        if levels is not None:
            one.levels = float(levels[0]), float(levels[1])
        elif mode != FIXED and not one.locked:
            one.levels = None
        self.find_depth()
        self.changed.emit()

    def set_depth_map(self, name: str) -> None:
        """Choose the depth colours by a name of `colour_maps.DEPTH_MAPS`."""
        self._material.depth_table = depth_table(name)
        self._material.depth_map = name
        self.changed.emit()

    def turn_to_another_frame(self) -> None:
        """Find the levels for the frame that there is now, but for those that are locked."""
        for one in self._material.ranges.values():
            one.turn_to_another_frame()
        self.find_depth()

    def follow_result(self) -> None:
        """There is other completed depth, which counts for the full range."""
        before = self.depth
        if self.of("depth").mode == FULL:
            self.find_depth()
            if self.depth != before:
                self.changed.emit()

    def find_depth(self) -> None:
        """The levels of all depths, by depth in; of the full range, by the result as well."""
        depth_in, result = self._material.depth_in, self._material.result
        if depth_in is None:
            return
        depths = [depth_in] if result is None else [depth_in, result.depth]

        def full() -> Levels:
            ends = np.array([full_levels(depth) for depth in depths])
            return float(ends[:, 0].min()), float(ends[:, 1].max())

        self.of("depth").find(lambda: robust_depth_levels(depth_in), full)
