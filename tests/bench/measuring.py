"""Time and memory of this process, and a yardstick that makes times comparable between machines."""

import ctypes
import gc
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
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


def memory_in_use() -> float:
    """Return the resident memory without freed memory that the C library keeps [MB]; on Linux."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def held() -> dict[str, int]:
    """Return the numbers of threads, open files and child processes; on Linux."""
    children = sum(_children(task) for task in Path("/proc/self/task").iterdir())
    return {"threads": threading.active_count(), "files": len(os.listdir("/proc/self/fd")), "children": children}


def _children(task: Path) -> int:
    """Return the number of processes that a thread has started; a thread that has just ended has none."""
    try:
        return len((task / "children").read_text().split())
    except (FileNotFoundError, ProcessLookupError):
        return 0
