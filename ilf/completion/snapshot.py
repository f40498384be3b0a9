"""P_i of one iteration, held as its filter has it: to be worked out at the pixels by whoever looks at it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Snapshot(NamedTuple):
    """What an iteration has come to. It costs next to nothing, and stays as it is when the iteration goes on.

    Attributes
    ----------
    work_out : callable
        Gives P_i at the block's pixels; from any thread.
    nbytes : int
        Memory that it holds for itself.
    shared : int
        Memory that it holds together with all other snapshots of its stepper.
    """

    work_out: Callable[[], NDArray[np.float64]]
    nbytes: int
    shared: int

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values."""
        return self.work_out()
