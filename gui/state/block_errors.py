"""Errors of the blocks of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

GROUND_TRUTH, HOLD_OUT, EXPECTED = "ground truth", "hold-out depth", "expected error"


@dataclass(frozen=True)
class BlockErrors:
    """Errors of the current results: against ground truth, on hold-out depth with the current parameters, or expected.

    Attributes
    ----------
    source : str
        `GROUND_TRUTH`, `HOLD_OUT` or `EXPECTED`; "" where no error is known.
    rmse : mapping of int to float
        Block label -> root mean square error [m]; blocks without a known error are left out.
    """

    source: str = ""
    rmse: Mapping[int, float] = field(default_factory=dict)

    @staticmethod
    def expected(error: NDArray[np.float32], labels: NDArray[np.int32]) -> BlockErrors:
        """Return the root mean square of the expected error [m], float32 (H, W), NaN = unknown, over each block."""
        known = np.isfinite(error)
        inside = labels[known]
        counts = np.bincount(inside)
        sums = np.bincount(inside, np.square(error[known], dtype=np.float64))
        there = [int(label) for label in np.flatnonzero(counts) if label]
        return BlockErrors(EXPECTED, {label: float(np.sqrt(sums[label] / counts[label])) for label in there})
