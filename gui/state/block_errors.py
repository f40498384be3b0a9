"""How far off the blocks of a frame are known to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

TRUTH, HIDDEN_DEPTH = "the truth", "hidden depth"


@dataclass(frozen=True)
class BlockErrors:
    """Errors of the present results against the truth, or of the present values on hidden depth.

    Attributes
    ----------
    source : str
        `TRUTH` or `HIDDEN_DEPTH`; "" where nothing is known.
    rmse : mapping of int to float
        Block label -> root mean square error [m]; blocks of which none is known are left out.
    """

    source: str = ""
    rmse: Mapping[int, float] = field(default_factory=dict)
