"""Files whose names are times."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable

from .frames import COLOUR_SUFFIXES
from .pairing import Pairs, depth_files
from .time_lists import associated

_TIME = re.compile(r"\d{9,10}\.\d+|\d{13}|\d{16}|\d{19}")
_UNITS = {13: 1e-3, 16: 1e-6, 19: 1e-9}


def time_of(name: str) -> float | None:
    """The time [s] that a file's name is: seconds with a fraction, or milli-, micro- or nanoseconds since 1970; None if
    it is none.

    Examples
    --------
    >>> time_of("rgb/1305031102.175304.png"), time_of("1305031102175.png"), time_of("000017.png")
    (1305031102.175304, 1305031102.175, None)
    """
    stem = os.path.splitext(os.path.basename(name))[0]
    if not _TIME.fullmatch(stem):
        return None
    return float(stem) if "." in stem else int(stem) * _UNITS[len(stem)]


def paired_by_time(colours: Iterable[str], depths: Iterable[str], max_gap: float) -> Pairs:
    """Names of colour files with those of the depth files that are nearest in time, each once; no pairs if names are no
    times.

    Parameters
    ----------
    colours, depths : iterable of str
    max_gap : float
        Pairs lie at most this many seconds apart.
    """
    images = [name for name in colours if name.lower().endswith(COLOUR_SUFFIXES)]
    timed = [
        [(time, name) for name in names if (time := time_of(name)) is not None]
        for names in (images, depth_files(depths))
    ]
    pairs = associated(timed[0], timed[1], max_gap)
    return Pairs(pairs, len(timed[0]) - len(pairs), len(timed[1]) - len(pairs))
