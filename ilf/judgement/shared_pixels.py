"""Where several completions of a frame can be compared: over the pixels that all of them have filled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..outcomes import Completion
from .judged import ENOUGH


def shared_pixels(completions: Sequence[Completion], *, every: bool = False) -> NDArray[np.bool_]:
    """Pixels that all completions have filled.

    Those that leave more than a tenth of what the best one fills open have no say.

    Parameters
    ----------
    completions : sequence of Completion
        Of one frame, at least one.
    every : bool
        Pixels where all have depth, whether it was filled or known.

    Returns
    -------
    ndarray of bool, shape (H, W)

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> whole = ilf.complete(frame, np.ones((20, 30), np.int32))
    >>> half = ilf.complete(frame, np.repeat([[1, 0]], 20, axis=0).repeat(15, axis=1))
    >>> int(shared_pixels([whole, whole]).sum()), int(shared_pixels([whole, half]).sum())
    (40, 40)
    """
    counts = [int(np.count_nonzero(completion.filled)) for completion in completions]
    leading = [one for one, count in zip(completions, counts, strict=True) if count >= ENOUGH * max(counts)]
    there = [np.isfinite(completion.depth) if every else completion.filled for completion in leading]
    return np.logical_and.reduce(there)
