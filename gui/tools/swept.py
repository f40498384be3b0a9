"""All that a brush has swept since the button went down."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gui.state.stroke import around
from ilf.blocks import Box
from ilf.ebs.edit import Stroke


class Swept:
    """Pixels of several short strokes together."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.mask: NDArray[np.bool_] = np.zeros(shape, bool)
        self._box: Box | None = None

    def add(self, stroke: Stroke) -> None:
        """Take in a stroke's pixels."""
        self.mask[stroke.box] |= stroke.mask
        self._box = stroke.box if self._box is None else around(self._box, stroke.box)

    @property
    def stroke(self) -> Stroke | None:
        """All of them; None if there are none."""
        return None if self._box is None else Stroke(self._box, self.mask[self._box])
