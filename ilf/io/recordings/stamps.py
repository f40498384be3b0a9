"""Images of two streams that belong together by their stamps."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ...errors import InputError
from ..time_lists import MOST_APART_S, associated
from .recording import RecordingIndex

_GAPS = (MOST_APART_S, 0.2, 2.0, 10.0)
"""Largest gaps in time [s] by which a frame is looked for. What is paired by a smaller one is so by a larger, too."""


class StampedPairs:
    """Colour with the depth that is nearest in time, each used once. The key of a pair is the stamp of its colour in
    seconds, with all of its digits.

    Parameters
    ----------
    colours, depths : iterable of int
        Stamps.
    per_second : int
        How many of their units are a second: a power of ten.

    Examples
    --------
    >>> StampedPairs([0, 33], [4, 41], 1000).paired(0.02)
    {'0.000': (0, 4), '0.033': (33, 41)}
    """

    def __init__(self, colours: Iterable[int], depths: Iterable[int], per_second: int) -> None:
        self._colours, self._depths, self._per_second = sorted(colours), sorted(depths), per_second
        self._digits = len(str(per_second)) - 1
        self._paired: dict[float, dict[str, tuple[int, int]]] = {}

    def paired(self, max_gap: float) -> dict[str, tuple[int, int]]:
        """Key -> stamps of colour and depth that lie at most `max_gap` [s] apart, in the order of time."""
        known = self._paired.get(max_gap)
        if known is None:
            colours, depths = (
                [(stamp / self._per_second, str(stamp)) for stamp in stamps] for stamps in (self._colours, self._depths)
            )
            pairs = [(int(colour), int(depth)) for colour, depth in associated(colours, depths, max_gap)]
            known = self._paired[max_gap] = {self._key(colour): (colour, depth) for colour, depth in pairs}
        return known

    def find(self, key: str) -> tuple[int, int] | None:
        """The stamps of colour and depth of a key, however far apart they are; None if there is none."""
        return next((pairs[key] for gap in _GAPS if key in (pairs := self.paired(gap))), None)

    def index(self, max_gap: float, path: Path) -> RecordingIndex:
        """The frames of the recording at `path`; raises InputError if there are none."""
        pairs = self.paired(max_gap)
        if not pairs:
            raise InputError(
                f"{path}: no colour image lies within {max_gap:g} s of a depth image; there are {len(self._colours)} "
                f"and {len(self._depths)}. Allow a larger gap (--max-gap) if they belong together."
            )
        lonely = (("colour", len(self._colours) - len(pairs)), ("depth", len(self._depths) - len(pairs)))
        notes = tuple(
            f"{count} {what} image{'s' * (count != 1)} left out: nothing to go with {max_gap:g} s near."
            for what, count in lonely
            if count
        )
        times = tuple(colour / self._per_second for colour, _ in pairs.values())
        return RecordingIndex(tuple(pairs), times, notes)

    def _key(self, stamp: int) -> str:
        seconds, rest = divmod(stamp, self._per_second)
        return f"{seconds}.{rest:0{self._digits}d}"
