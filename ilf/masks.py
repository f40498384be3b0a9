"""Masks that go with a frame, and arrays that stay as they are."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

Array = TypeVar("Array", bound=NDArray[Any])


def fixed(array: Array) -> Array:
    """An array that nobody can write to: this very one if it is so already, as another frame's or run's, so that they
    share it; else a copy.

    Examples
    --------
    >>> mask = np.zeros((2, 3), bool)
    >>> once = fixed(mask)
    >>> once is mask, fixed(once) is once, once.flags.writeable
    (False, True, False)
    """
    if not array.flags.writeable and array.base is None and array.flags.c_contiguous:
        return array
    copied: Array = array.copy()
    copied.setflags(write=False)
    return copied


def checked_mask(mask: ArrayLike, shape: tuple[int, ...], what: str) -> NDArray[np.bool_]:
    """A mask of `what` that nobody can write to; raises InputError if it does not fit a frame of this shape (H, W)."""
    array = np.asarray(mask)
    if array.dtype != np.bool_ or array.shape != shape:
        raise InputError(
            f"A mask of {what} must be bool with the frame's shape {shape}, not {array.dtype} with shape {array.shape}."
        )
    return fixed(array)
