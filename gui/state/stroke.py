"""A stroke in progress: the label map before it and the box that it has changed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box, union
from ilf.segmentation.editing.patches import LabelPatch, patch_between


class StrokeInProgress:
    """The label map, int32 (H, W), before a stroke in progress, and the box that the stroke has changed."""

    def __init__(self, labels: NDArray[np.int32]) -> None:
        self._before = labels.copy()
        self._box: Box | None = None

    def reach(self, box: Box) -> None:
        """Note that the stroke changed pixels in a box."""
        self._box = box if self._box is None else union(self._box, box)

    def patch(self, labels: NDArray[np.int32]) -> LabelPatch | None:
        """Return what the stroke has changed so far; None for nothing."""
        if self._box is None:
            return None
        inside = patch_between(self._before[self._box], labels[self._box])
        if inside is None:
            return None
        rows, columns = (
            slice(whole.start + part.start, whole.start + part.stop)
            for whole, part in zip(self._box, inside.box, strict=True)
        )
        return LabelPatch((rows, columns), inside.before, inside.after)
