"""A guide: what something else says of a frame's depth, in whatever unit and sense."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

_ASPECT = 0.01
"""Aspects that differ by less than this share are the same: sides are rounded to whole pixels."""

_LARGEST = 1e30
"""Values from there on stand for nothing in files that cannot say NaN."""

_MOSTLY = 0.5
"""Of what a resized pixel is made of, so much has to be known."""


@dataclass(frozen=True, eq=False)
class Guide:
    """Depth, inverse depth or anything else that rises or falls with depth, for the pixels of a frame; from a network
    that guesses depth or another sensor. One that was made with the measured depth in sight, as another completion is,
    agrees with it wherever it is known, and is followed more than it deserves. Immutable: its arrays are read-only
    copies.

    Parameters
    ----------
    values : array_like
        Shape (H, W), any real type. What is zero or not finite says nothing and becomes NaN.
    confidence : array_like, optional
        How far to believe each value, from 0 to 1; 1 if left out.
    path : str, optional
        The file that it was read from.

    Raises
    ------
    InputError
        If shapes or types do not fit, or the values say nothing.

    Examples
    --------
    >>> Guide([[1, 2], [0, 4]]).values
    array([[ 1.,  2.],
           [nan,  4.]], dtype=float32)
    """

    values: NDArray[np.float32]
    confidence: NDArray[np.float32] | None = None
    path: str | None = None

    def __post_init__(self) -> None:
        values = _real(self.values, "A guide")
        with np.errstate(over="ignore"):
            values = values.astype(np.float32)
        values[~(np.abs(values) < _LARGEST) | (values == 0)] = np.nan
        said = values[np.isfinite(values)]
        if said.size == 0 or said.min() == said.max():
            raise InputError("The guide says nothing: all its values are zero, not finite, or the same.")
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        if self.confidence is not None:
            confidence = np.nan_to_num(_real(self.confidence, "A guide's confidence").astype(np.float32))
            if confidence.shape != values.shape:
                raise InputError(
                    f"The guide's confidence is {_size(confidence.shape)} but the guide {_size(values.shape)}."
                )
            if not 0 <= confidence.min() <= confidence.max() <= 1:
                raise InputError(
                    f"The guide's confidence is {confidence.min():.3g} to {confidence.max():.3g}, not 0 to 1. Of an "
                    "array of shape (2, H, W), the second half is its confidence."
                )
            confidence.setflags(write=False)
            object.__setattr__(self, "confidence", confidence)

    def of_size(self, shape: tuple[int, int]) -> Guide:
        """The same guide for a frame of this height and width; raises InputError if it has another aspect."""
        height, width = self.values.shape
        if (height, width) == shape:
            return self
        ratio = height * shape[1] / (width * shape[0])
        if abs(ratio - 1) > _ASPECT:
            raise InputError(
                f"The guide is {_size((height, width))} but the frame is {_size(shape)}, which is another aspect: "
                "a guide must show the same part of the scene. Crop or pad it first."
            )
        known = np.isfinite(self.values)
        share = _resized(known.astype(np.float32), shape)
        total = _resized(np.where(known, self.values, np.float32(0)), shape)
        values = np.divide(total, share, out=np.full(shape, np.nan, np.float32), where=share >= _MOSTLY)
        confidence = None if self.confidence is None else _resized(self.confidence, shape)
        return replace(self, values=values, confidence=confidence)

    @property
    def array(self) -> NDArray[np.float32]:
        """All of it in one array: values (H, W), or values and confidence (2, H, W)."""
        return self.values if self.confidence is None else np.stack([self.values, self.confidence])

    @classmethod
    def of_array(cls, array: NDArray[Any], path: str | None = None) -> Self:
        """Inverse of `array`; of other shapes, sides of 1 do not count."""
        if array.ndim == 3 and array.shape[0] == 2:
            return cls(array[0], array[1], path)
        return cls(array.squeeze() if array.ndim > 2 else array, path=path)

    def says_the_same(self, other: Guide | None) -> bool:
        """Whether another guide has the same values and confidence."""
        return self is other or (other is not None and np.array_equal(self.array, other.array, equal_nan=True))


def as_guide(guide: ArrayLike | Guide) -> Guide:
    """A guide, of values alone if it is not one already."""
    return guide if isinstance(guide, Guide) else Guide(np.asarray(guide))


def _real(values: ArrayLike, name: str) -> NDArray[np.generic]:
    array = np.array(values)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iuf":
        raise InputError(
            f"{name} must be one real number per pixel with shape (H, W), not {array.dtype} with shape {array.shape}."
        )
    return array


def _resized(values: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    smaller = shape[0] < values.shape[0]
    size = (shape[1], shape[0])
    return cv2.resize(values, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR).astype(np.float32)


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]} x {shape[0]}"
