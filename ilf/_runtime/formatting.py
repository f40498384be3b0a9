"""Lengths and counts as text, formatted alike in all tables, messages and reports."""

from __future__ import annotations

import math
import re
from typing import SupportsFloat, SupportsInt

UNKNOWN = "\u2013"


def millimetres(metres: float) -> str:
    """Format an error or another small length in millimetres, to three digits; a dash if it is not finite.

    Examples
    --------
    >>> millimetres(0.01234), millimetres(1.5), millimetres(float("nan"))
    ('12.3', '1500', '–')
    """
    if not math.isfinite(metres):
        return UNKNOWN
    size = 1000 * abs(metres)
    return f"{1000 * metres:.{0 if size >= 99.95 else 1 if size >= 9.995 else 2}f}"


def grouped(count: SupportsInt) -> str:
    """Format a count with commas as thousands separators.

    Examples
    --------
    >>> grouped(1234567)
    '1,234,567'
    """
    return f"{int(count):,}"  # also for numpy's integers


def size_text(shape: tuple[int, ...]) -> str:
    """Format the size of an image of shape (H, W, ...) as width x height; another shape as it is."""
    return f"{shape[1]} x {shape[0]}" if len(shape) > 1 else str(shape)


def counted(count: SupportsInt, what: str) -> str:
    """Format a count with its noun, in the plural where needed.

    Examples
    --------
    >>> counted(1, "frame"), counted(1200, "frame")
    ('1 frame', '1,200 frames')
    """
    return f"{grouped(count)} {what}{'' if count == 1 else 's'}"


def covered(blocks: int, share: float) -> str:
    """Format the number of blocks and the share of the frame that they cover.

    Examples
    --------
    >>> covered(1, 0.083)
    '1 block covers 8.3% of the frame'
    """
    return f"{counted(blocks, 'block')} cover{'s' if blocks == 1 else ''} {share:.1%} of the frame"


def length_text(metres: float) -> str:
    """Format a length with a suitable unit, to three significant digits: 10 m, 100 mm, 0.1 mm, 1 µm."""
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


# Numbers from files, forms and callers, which may be of any size.


def as_float(number: SupportsFloat) -> float:
    """Convert a number to float; infinite if it is too large, as integers may be."""
    try:
        return float(number)
    except OverflowError:
        return math.inf


def natural(name: str) -> str:
    """Sort key for natural order.

    Examples
    --------
    >>> sorted(["frame-10", "Frame-2", "frame-1"], key=natural)
    ['frame-1', 'Frame-2', 'frame-10']
    """
    return re.sub(r"\d+", lambda number: number[0].zfill(20), name.casefold())
