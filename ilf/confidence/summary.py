"""Expected errors of many pixels in a few figures, and what these are called wherever they are shown."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..outcomes import Completion

RMS_NAME, MEDIAN_NAME = "Expected error, RMS", "Expected error, median"
RMS_MEANING = "Root mean square of the expected error, over the pixels that blocks have filled; large errors count most"
MEDIAN_MEANING = "Median of the expected error, over the pixels that blocks have filled: of half of them it is smaller"


class ErrorSummary(NamedTuple):
    """Figures of expected errors [m]; NaN where there are none.

    Attributes
    ----------
    rms, median : float
        Root mean square and median.
    p90 : float
        Of 90 % of the pixels it is at most so large.
    """

    rms: float
    median: float
    p90: float


def summarised(error: NDArray[np.floating]) -> ErrorSummary:
    """The figures of some pixels' expected errors.

    Parameters
    ----------
    error : ndarray of float, any shape
        [m]; pixels without, NaN, do not count.

    Examples
    --------
    >>> summarised(np.array([0.25, 0.5, 2.0, np.nan])).median
    0.5
    """
    known = error[np.isfinite(error)]
    if not known.size:
        return ErrorSummary(math.nan, math.nan, math.nan)
    rms = math.sqrt(float(np.mean(np.square(known, dtype=np.float64))))
    return ErrorSummary(rms, float(np.median(known)), float(np.quantile(known, 0.9)))


def error_summary(error: NDArray[np.floating], completion: Completion) -> ErrorSummary:
    """The figures of a completion: over the pixels that its blocks have filled, without guesses, whose expected errors
    are not calibrated.

    Parameters
    ----------
    error : ndarray of float, shape (H, W)
        `expected_error` of the completion.
    completion : Completion
    """
    return summarised(error[completion.filled_by_blocks])
