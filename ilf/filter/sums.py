"""Sums of products that come out the same for any number of threads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def inner(a: NDArray[np.inexact], b: NDArray[np.inexact]) -> float:
    """Sum of products of two real arrays, or of real with real and imaginary with imaginary parts of complex ones.

    Row by row, and the rows' sums in float64, so that float32 keeps its digits. Rows are too short for BLAS to use
    threads on, whose number would show in the sums.
    """
    if np.iscomplexobj(a):
        a, b = a.view(a.real.dtype), b.view(b.real.dtype)
    return float(np.vecdot(a, b).sum(dtype=np.float64))
