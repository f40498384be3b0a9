"""What the views show while somebody looks back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Past:
    """The depth of the present frame as it was in the course of its last run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where there was none.
    iteration : int
        After which iteration of every block.
    """

    depth: NDArray[np.float32]
    iteration: int

    @property
    def text(self) -> str:
        """What to call it."""
        return f"as after iteration {self.iteration}"
