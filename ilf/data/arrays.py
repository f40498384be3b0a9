"""Arrays of callers: numpy masked arrays become plain ones."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import size_text
from ..errors import InputError, told_as

Array = TypeVar("Array", bound=NDArray[Any])


def plain_array(values: ArrayLike) -> NDArray[Any]:
    """Return values as a plain array, in which those masked in a numpy masked array are missing: NaN, or 0 or False in
    types without NaN.

    Raises
    ------
    InputError
        If these are sequences of unequal lengths.

    Examples
    --------
    >>> plain_array(np.ma.masked_equal([1.5, 9.0], 9.0)), plain_array(np.ma.masked_equal([3, 9], 9))
    (array([1.5, nan]), array([3, 0]))
    """
    if isinstance(values, np.ma.MaskedArray):
        return np.asarray(values.filled(np.nan if values.dtype.kind == "f" else 0))
    with told_as(InputError, "These values do not form an array: give rows of equal lengths.", ValueError):
        return np.asarray(values)


def frozen(array: Array) -> Array:
    """Return the same array, which is read-only from now on."""
    array.setflags(write=False)
    return array


def check_shape(
    what: str,
    found: tuple[int, ...],
    wanted: tuple[int, ...],
    whole: str = "the frame",
    remedy: str = "Both must have the same pixels.",
) -> None:
    """Raise InputError if the array of what is named has another shape than the array that it belongs to."""
    if found != wanted:
        given = size_text(found) if len(found) == len(wanted) else f"of shape {found}"
        raise InputError(f"{what} is {given}, but {whole} is {size_text(wanted)}. {remedy}")


def real_image(values: ArrayLike, name: str) -> NDArray[Any]:
    """Return values as a plain array; raise InputError if they are not one real number per pixel."""
    array = plain_array(values)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iuf":
        raise InputError(f"{name} must be one real number per pixel, (H, W), not {array.dtype} {array.shape}.")
    return array


def without_mask(colour: ArrayLike) -> NDArray[Any]:
    """Return colour as a plain array; raise InputError if some of it is masked."""
    if np.ma.is_masked(colour):
        raise InputError("Colour is masked, but cannot be missing: give colour.filled(0) or .data, and mask depth.")
    return plain_array(colour)
