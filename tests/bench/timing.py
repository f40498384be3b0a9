"""Wall clock and processor time, and a yardstick that makes them comparable between machines."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import scipy.fft

T = TypeVar("T")


def timed(work: Callable[[], T]) -> tuple[list[float], T]:
    """Return the wall clock and the processor time of some work [s], and its result."""
    wall, processor = time.perf_counter(), time.process_time()
    result = work()
    return [time.perf_counter() - wall, time.process_time() - processor], result


def hundred_dcts() -> None:
    """Transform a 640 x 480 float64 array a hundred times, by one thread."""
    values = np.random.default_rng(0).random((480, 640))
    for _ in range(100):
        scipy.fft.dctn(values, workers=1)
