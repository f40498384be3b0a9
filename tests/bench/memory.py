"""Memory of this process, on Linux."""

from __future__ import annotations

import ctypes
import gc
import os
from pathlib import Path


def resident() -> float:
    """Return the resident memory [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def in_use() -> float:
    """Return the same, without freed memory that the C library keeps [MB]."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return resident()
