"""Memory: estimate of what a frame needs before work begins, and release of free memory."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Callable
from functools import cache

from ..errors import FormatError, ParameterError
from .formatting import as_float

_PROGRAM = 0.35e9
"""Bytes used by the program for a tiny frame. These three are fitted to measured peaks of `ilf complete`."""

_NETWORKS, _NETWORKS_PER_PIXEL = 0.6e9, 1200
"""Additional bytes for the networks, maximum and per pixel of a small frame: they run on larger frames scaled down."""

_PER_PIXEL = 120
"""Additional bytes for completion per pixel of the frame, including all results and files."""

_DEFAULT_GB = 8.0

MIN_PIXELS_TO_RELEASE = 1 << 20
"""Number of pixels below which releasing memory is not worth its time."""


def memory_limit() -> float:
    """Return the bytes that work on one frame may use: 8 GB, or the environment variable ILF_MEMORY in GB.

    Raises
    ------
    ParameterError
        If ILF_MEMORY is not a positive number.
    """
    setting = os.environ.get("ILF_MEMORY")
    try:
        limit = _DEFAULT_GB if not setting else float(setting)
    except ValueError:
        limit = math.nan
    if not limit > 0:
        raise ParameterError(f"ILF_MEMORY must be a positive number of GB, not {setting!r:.40}: correct the variable.")
    return 1e9 * limit


def memory_needed(width: int, height: int) -> float:
    """Estimate the peak memory [bytes] of completing a frame of this size, for any number of threads."""
    pixels = as_float(width * height)
    return _PROGRAM + min(_NETWORKS, _NETWORKS_PER_PIXEL * pixels) + _PER_PIXEL * pixels


def check_memory(what: object, width: int, height: int) -> None:
    """Raise FormatError for a frame that would need too much memory, before any of it is read.

    Parameters
    ----------
    what : object
        The file or frame that the message names.
    width, height : int

    Raises
    ------
    FormatError
    """
    needed, limit = memory_needed(width, height), memory_limit()
    if needed > limit:
        # rounded up, so that the value in the message is enough
        more = f": environment variable ILF_MEMORY={math.ceil(needed / 1e8) / 10:g} (GB)" if needed < math.inf else ""
        raise FormatError(
            f"{what} has {width} x {height} pixels by its header; completing such a frame needs about "
            f"{needed / 1e9:.3g} GB of memory, but only {limit / 1e9:g} GB are allowed. Resize or crop it first, or "
            f"raise the limit{more}."
        )


def release_memory(pixels: int) -> None:
    """Return free memory to the system after work on this many pixels has ended.

    The GNU C library keeps freed arrays of up to 32 MB for reuse, separately for each thread: for a frame of
    3840 x 2160 px, this is more than the work itself needs at a time.
    """
    trim = _trim()
    if pixels >= MIN_PIXELS_TO_RELEASE and trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """Return the function malloc_trim; None where it does not exist or is not needed."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
