"""Matching colour with depth by time."""

from __future__ import annotations

import heapq
import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from .._runtime.formatting import counted
from ..errors import InputError

T = TypeVar("T")

MAX_TIME_GAP_S = 0.02


def associated(
    colours: list[tuple[float, str]], depths: list[tuple[float, str]], max_gap: float = MAX_TIME_GAP_S
) -> list[tuple[str, str]]:
    """Match colour and depth files nearest in time, each used once, in the order of time.

    Parameters
    ----------
    colours, depths : list of (float, str)
        Times [s] and names.
    max_gap : float
        Maximum time difference of a pair [s].

    Examples
    --------
    >>> associated([(0.00, "a.png"), (0.03, "b.png")], [(0.01, "a-d.png"), (0.06, "c-d.png")])
    [('a.png', 'a-d.png')]
    """
    colours, depths = sorted(colours), sorted(depths)
    pairs = _nearest([time for time, _ in colours], [time for time, _ in depths], max_gap)
    return [(colours[row][1], depths[column][1]) for row, column in sorted(pairs)]


def gap_text(colours: Sequence[tuple[float, str]], depths: Sequence[tuple[float, str]], max_gap: float) -> str:
    """Why colour and depth do not match by time, as the rest of a sentence and what to do.

    Parameters
    ----------
    colours, depths : sequence of (float, str)
        Times [s] and names, as for `associated`.
    max_gap : float
        Maximum time difference of a pair [s].

    Examples
    --------
    >>> gap_text([(0.0, "a.png"), (0.1, "b.png")], [(0.03, "a-d.png")], 0.02)
    'no colour lies within 0.02 s of depth: the smallest difference is 0.03 s. Allow ...'
    """
    if not (colours and depths):
        return f"there are {len(colours)} colour images and {len(depths)} depth images."
    one, other = (np.unique([time for time, _ in images]) for images in (colours, depths))
    place = np.searchsorted(other, one)
    gaps = [np.abs(other[np.clip(place + step, 0, len(other) - 1)] - one) for step in (-1, 0)]
    smallest = float(np.min(gaps))
    told = f"no colour lies within {max_gap:g} s of depth: the smallest difference is {smallest:.4g} s"
    return f"{told}. Allow more (--max-gap) if they fit, or correct the times if two clocks differ."


def left_out(colours: int, depths: int, condition: str) -> list[str]:
    """Notes on numbers of images in no pair: they lack one of the other kind of that name, or within a time."""
    counts = (("colour", "depth", colours), ("depth", "colour", depths))
    return [
        f"{counted(count, f'{what} image')} left out: there is no {other} image {condition}."
        for what, other, count in counts
        if count
    ]


def _nearest(rows: list[float], columns: list[float], max_gap: float) -> list[tuple[int, int]]:
    """Greedily pair the nearest times of two sorted lists, then the nearest of the rest, and so on.

    Every row waits with its nearest free column; one whose column was taken meanwhile waits again.
    """
    free = [(time, column) for column, time in enumerate(columns)]
    waiting: list[tuple[float, int, int]] = []
    found: dict[int, int] = {}

    def wait(row: int) -> None:
        time = rows[row]
        after = bisect_left(free, (time,))
        before = bisect_left(free, free[after - 1][:1]) if after else after  # the first of equal times
        near = [
            (abs(there - time), row, column) for there, column in (*free[before : before + 1], *free[after : after + 1])
        ]
        if near and min(near)[0] <= max_gap:
            heapq.heappush(waiting, min(near))

    for row in range(len(rows)):
        wait(row)
    while waiting:
        _, row, column = heapq.heappop(waiting)
        if column in found:
            wait(row)
        else:
            found[column] = row
            del free[bisect_left(free, (columns[column], column))]
    return [(row, column) for column, row in found.items()]


# Pairing the images of two streams by their time stamps.

_LARGEST_GAP_S = 10.0
"""Maximum time difference [s] of a frame that is asked for by its key."""


class TimedPairs(Generic[T]):
    """Pairs of colour and the depth nearest in time, each used once.

    Parameters
    ----------
    colours, depths : mapping
        Name -> time [s] and what it stands for. The name of a colour is the key of its frame.

    Examples
    --------
    >>> TimedPairs(stamped([0, 33], 1000), stamped([4, 41], 1000)).paired(0.02)
    {'0.000': (0, 4), '0.033': (33, 41)}
    """

    def __init__(self, colours: Mapping[str, tuple[float, T]], depths: Mapping[str, tuple[float, T]]) -> None:
        self._colours, self._depths = colours, depths

    @cached_property
    def _nearest(self) -> dict[str, tuple[float, str]]:
        """Key -> time [s] from the colour to its depth, and the name of that, in the order of time. A limit of the time
        leaves some out, and changes no other."""
        pairs = associated(*self._timed(), math.inf)
        return {colour: (abs(self._colours[colour][0] - self._depths[depth][0]), depth) for colour, depth in pairs}

    def paired(self, max_gap: float) -> dict[str, tuple[T, T]]:
        """Key -> colour and depth whose times differ by at most `max_gap` [s], in the order of time."""
        return {key: pair for key in self._nearest if (pair := self.find(key, max_gap))}

    def find(self, key: str, max_gap: float = _LARGEST_GAP_S) -> tuple[T, T] | None:
        """Colour and depth for a key; None if there are none."""
        apart, depth = self._nearest.get(key, (math.inf, ""))
        return (self._colours[key][1], self._depths[depth][1]) if apart <= max_gap else None

    def index(self, max_gap: float, where: object) -> tuple[tuple[str, ...], tuple[float, ...], tuple[str, ...]]:
        """The names of the colours in pairs, their times [s], and notes; raises InputError, about `where`, if there are
        none."""
        names = tuple(self.paired(max_gap))
        if not names:
            raise InputError(f"{where}: {gap_text(*self._timed(), max_gap)}")
        left = len(self._colours) - len(names), len(self._depths) - len(names)
        return names, tuple(self._colours[name][0] for name in names), tuple(left_out(*left, f"within {max_gap:g} s"))

    def _timed(self) -> tuple[list[tuple[float, str]], list[tuple[float, str]]]:
        """Times [s] and names of colours and depths."""
        colours, depths = ([(time, name) for name, (time, _) in some.items()] for some in (self._colours, self._depths))
        return colours, depths


def stamped(stamps: Iterable[int], per_second: int) -> dict[str, tuple[float, int]]:
    """Images by their time stamps, as `TimedPairs` takes them. A name is the stamp in seconds, with all of its digits.

    Parameters
    ----------
    stamps : iterable of int
    per_second : int
        Units of the time stamps per second: a power of ten.
    """
    digits = len(str(per_second)) - 1
    parts = ((stamp, *divmod(stamp, per_second)) for stamp in stamps)
    return {f"{seconds}.{rest:0{digits}d}": (stamp / per_second, stamp) for stamp, seconds, rest in parts}
