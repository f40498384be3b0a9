"""Small lengths and counts in words, the same in all tables and lines of the window."""

from __future__ import annotations

import math

UNKNOWN = "\u2013"


def millimetres(metres: float) -> str:
    """An error or another small length in millimetres, to three digits; a dash for none.

    Examples
    --------
    >>> millimetres(0.01234), millimetres(1.5), millimetres(float("nan"))
    ('12.3', '1500', '–')
    """
    if not math.isfinite(metres):
        return UNKNOWN
    size = 1000 * abs(metres)
    return f"{1000 * metres:.{0 if size >= 99.95 else 1 if size >= 9.995 else 2}f}"


def grouped(count: int) -> str:
    """A count with thin spaces between its thousands.

    Examples
    --------
    >>> grouped(1234567) == "1\\u202f234\\u202f567"
    True
    """
    return f"{count:,}".replace(",", "\u202f")


def counted(count: int, what: str) -> str:
    """A count of things.

    Examples
    --------
    >>> counted(1, "frame"), counted(1200, "frame")
    ('1 frame', '1\u202f200 frames')
    """
    return f"{grouped(count)} {what}{'s' * (count != 1)}"
