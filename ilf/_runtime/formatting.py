"""Small lengths and counts in words, the same in all tables, lines and reports."""

from __future__ import annotations

import math
from typing import SupportsFloat

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


def covered(blocks: int, share: float) -> str:
    """How many blocks there are, and how much of the frame they cover.

    Examples
    --------
    >>> covered(1, 0.083)
    '1 block covers 8.3% of the frame'
    """
    return f"{counted(blocks, 'block')} cover{'s' * (blocks == 1)} {share:.1%} of the frame"


def length_text(metres: float) -> str:
    """A length with the unit that reads best, to three significant digits: 10 m, 100 mm, 0.1 mm, 1 µm."""
    if not math.isfinite(metres):
        return "–"
    size = abs(metres)
    if size >= 0.9995:
        scaled, unit = metres, "m"
    elif size >= 0.99e-4 or size == 0:
        scaled, unit = metres * 1e3, "mm"
    else:
        scaled, unit = metres * 1e6, "µm"
    text = f"{scaled:.3g}" if abs(scaled) < 999.5 else f"{scaled:,.0f}"
    return f"{text} {unit}"


# Numbers as they come from files, forms and callers, which may be of any size.


def as_float(number: SupportsFloat) -> float:
    """A number as float; infinite where it is too large to be one, as whole numbers may be."""
    try:
        return float(number)
    except OverflowError:
        return math.inf
