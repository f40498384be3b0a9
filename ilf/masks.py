"""Masks that go with a frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError


def checked_mask(mask: ArrayLike, shape: tuple[int, ...], what: str) -> NDArray[np.bool_]:
    """A read-only copy of a mask of `what`; raises InputError if it does not fit a frame of this shape (H, W)."""
    array = np.asarray(mask)
    if array.dtype != np.bool_ or array.shape != shape:
        raise InputError(
            f"A mask of {what} must be bool with the frame's shape {shape}, not {array.dtype} with shape {array.shape}."
        )
    result = array.copy()
    result.setflags(write=False)
    return result
