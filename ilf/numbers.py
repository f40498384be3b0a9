"""Numbers as they come from files, forms and callers, which may be of any size."""

from __future__ import annotations

import math
from typing import SupportsFloat


def as_float(number: SupportsFloat) -> float:
    """A number as float; infinite where it is too large to be one, as whole numbers may be."""
    try:
        return float(number)
    except OverflowError:
        return math.inf
