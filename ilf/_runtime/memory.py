"""How much memory work on a frame takes, told before it begins; and what is free given back."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Callable
from functools import cache

from ..errors import FormatError, InputError, ParameterError
from .formatting import as_float

_PROGRAM = 0.35e9
"""Bytes that the program takes for a tiny frame. These three are told by `python -m tests.bench.peaks`."""

_NETWORKS, _NETWORKS_PER_PIXEL = 0.6e9, 1200
"""What the networks take besides, at most and for each pixel of a small frame: they look at larger ones scaled down."""

_PER_PIXEL = 120
"""Bytes that completing takes besides for each pixel of the frame, all results and files included."""

_ADDRESSES, _ADDRESSES_PER_THREAD = 0.55e9, 0.25e9
"""Bytes of address space that the libraries take to be loaded, most of which are never used, and those of the threads
that OpenBLAS starts, one for each core unless told otherwise; without, they end the process or crash."""

_MOST_THREADS = 64
"""That OpenBLAS starts, on however many cores."""

_USUAL_GB = 8.0

_LARGE = 1 << 20
"""Work on fewer pixels leaves too little behind to be worth the while."""


def memory_limit() -> float:
    """Bytes that work on one frame may take: 8 GB, or as many GB as the environment variable ILF_MEMORY says.

    Raises
    ------
    ParameterError
        If that is not a positive number.
    """
    said = os.environ.get("ILF_MEMORY")
    try:
        limit = _USUAL_GB if not said else float(said)
    except ValueError:
        limit = math.nan
    if not limit > 0:
        raise ParameterError(f"The environment variable ILF_MEMORY must be a number of GB, not {said!r:.40}.")
    return 1e9 * limit


def check_address_space(cores: int) -> None:
    """Raise InputError if this process is allowed less address space (`ulimit -v`) than its libraries take to be
    loaded on so many cores: it must be asked before they are."""
    try:
        import resource
    except ImportError:  # on Windows there is no such limit
        return
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    said = os.environ.get("OPENBLAS_NUM_THREADS") or os.environ.get("OMP_NUM_THREADS") or ""
    threads = min(cores, int(said) if said.isdecimal() else _MOST_THREADS)
    needed = _ADDRESSES + _ADDRESSES_PER_THREAD * threads
    if limit != resource.RLIM_INFINITY and limit < needed:
        raise InputError(
            f"This process may take {limit / 1e6:.0f} MB of address space, and needs {needed / 1e6:.0f} MB to start "
            f"with {threads} threads of OpenBLAS. Raise the limit (ulimit -v), or set OPENBLAS_NUM_THREADS=1."
        )


def memory_needed(width: int, height: int) -> float:
    """Bytes that completing a frame of so many pixels takes at its peak, about; for any number of threads."""
    pixels = as_float(width * height)
    return _PROGRAM + min(_NETWORKS, _NETWORKS_PER_PIXEL * pixels) + _PER_PIXEL * pixels


def check_fits(what: object, width: int, height: int) -> None:
    """Refuse a frame that would take too much memory, before anything of it is read.

    Parameters
    ----------
    what : object
        Named in the message.
    width, height : int

    Raises
    ------
    FormatError
    """
    needed, limit = memory_needed(width, height), memory_limit()
    if needed > limit:
        # rounded up, so that what is told is enough
        more = (
            f": ILF_MEMORY={math.ceil(needed / 1e8) / 10:g} (GB, an environment variable)" if needed < math.inf else ""
        )
        raise FormatError(
            f"{what} says it has {width} x {height} pixels; completing such a frame takes about {needed / 1e9:.3g} GB "
            f"of memory, and {limit / 1e9:g} GB are allowed. Resize or crop it first, or allow more{more}."
        )


def give_back(pixels: int) -> None:
    """Give memory that is free back to the system, where work on so many pixels has ended.

    The GNU C library keeps arrays of up to 32 MB that have been freed for others of their size, of every thread apart:
    of a frame of 3840 x 2160 px, more than the work itself needs at a time.
    """
    trim = _trim()
    if pixels >= _LARGE and trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """What does so; None where there is no such function, or no need."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
