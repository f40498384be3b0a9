"""Schedules of the cut-off radius: how the pass band grows while the iteration goes on (section 3)."""

from __future__ import annotations

import math
from typing import Protocol

from ...parameters import Parameters

Radii = tuple[float, float]


class Schedule(Protocol):
    """State of one block's pass band."""

    stage: int
    """Number of different pass bands so far, from 1."""

    @property
    def radii(self) -> Radii:
        """(r_y, r_x) of the next iteration, in cycles per padded grid."""
        ...

    def advance(self, steady: bool) -> bool:
        """Take note of an iteration; True when the schedule has come to its end."""
        ...


class StagedSchedule:
    """The paper's text: iterate until steady, then enlarge the radius.

    The cut-off frequency, equal in all directions of the image, starts at `staged_start` basebands (by default
    0: the mean alone, which lifts the defective area from 0 m), passes the baseband 1 / longest length and
    1 / shortest length, and rises by `stage_step` basebands a stage to 1 / `shortest_wavelength`, or to
    1 / shortest length where the block is narrower than that. The stages divide the way evenly, so the last one
    ends exactly there.

    Parameters
    ----------
    grid : tuple of int
        Padded grid (H, W).
    lengths : tuple of float
        Longest and shortest length of the block [px].
    parameters : Parameters
    """

    def __init__(self, grid: tuple[int, int], lengths: tuple[float, float], parameters: Parameters) -> None:
        longest, shortest = lengths
        self._grid = grid
        self._first = parameters.staged_start / longest
        self._last = max(1.0 / parameters.shortest_wavelength, min(1.0 / shortest, 0.5), self._first)
        self._steps = math.ceil((self._last - self._first) * longest / parameters.stage_step)
        self.stage = 1

    @property
    def radii(self) -> Radii:
        share = (self.stage - 1) / self._steps if self._steps else 0.0
        frequency = self._first + share * (self._last - self._first)
        return self._grid[0] * frequency, self._grid[1] * frequency

    def advance(self, steady: bool) -> bool:
        if steady and self.stage > self._steps:
            return True
        self.stage += steady
        return False


class LinearSchedule:
    """The released code: r = start * (H/h, W/w) + (H, W) / (wavelength * iterations) * (i - 1)."""

    def __init__(self, grid: tuple[int, int], block: tuple[int, int], parameters: Parameters) -> None:
        start = parameters.linear_start
        self._start = start * grid[0] / block[0], start * grid[1] / block[1]
        span = parameters.shortest_wavelength * parameters.max_iterations
        self._growth = grid[0] / span, grid[1] / span
        self._iterations = parameters.max_iterations
        self.stage = 1

    @property
    def radii(self) -> Radii:
        done = self.stage - 1
        return self._start[0] + self._growth[0] * done, self._start[1] + self._growth[1] * done

    def advance(self, steady: bool) -> bool:
        at_end = self.stage >= self._iterations
        self.stage += not at_end
        return at_end
