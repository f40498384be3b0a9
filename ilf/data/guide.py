"""Guide: depth or inverse depth of a frame from another source, in any unit; the card of a network that gives it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import size_text
from ..errors import InputError
from .arrays import check_shape, frozen, real_image

_ASPECT = 0.01
"""Relative difference below which aspect ratios count as equal: sides are rounded to whole pixels."""

_LARGEST = 1e30
"""Values from here on count as missing, for files that cannot store NaN."""

_MIN_KNOWN_SHARE = 0.5
"""Minimum known share of the area that a resized pixel covers."""


Gives = Literal["relative-inverse", "affine-inverse", "affine", "metric"]
"""What a network predicts: a decreasing function of depth, a linear function of inverse depth, a linear function of
depth, or depth in metres."""


def _check_gives(gives: Gives) -> None:
    if gives not in get_args(Gives):
        raise InputError(f"A guide cannot give {gives!r}. Known: {', '.join(map(repr, get_args(Gives)))}.")


@dataclass(frozen=True)
class GuideCard:
    """What is known of a network that predicts guides from colour.

    Attributes
    ----------
    name, maker, licence : str
    gives : str
        See `Gives`.
    bytes : int
        Size of its file, rounded until there is one on this computer.
    terms : str
        What the licence does not permit, in a few words; "" for the usual open ones.
    address : str
        Where the file is fetched from; "" for files that were added.
    sha256 : str or None
        Hash of the file; None if it is not known before the first fetch.
    size, step : int or None, int
        Shorter side of the input [px], and the number that its sides are multiples of, unless the file fixes them. None
        tries the usual ones.
    keep_aspect : bool
        Whether the input keeps the image's aspect ratio; otherwise it is a square.
    mean, deviation : (float, float, float)
        Subtracted from colour in [0, 1], and what it is divided by.
    output : str
        Name of the output; "" for the first.

    Raises
    ------
    InputError
        If `gives` is none of `Gives`.
    """

    name: str
    maker: str
    licence: str
    gives: Gives
    bytes: int
    terms: str = ""
    address: str = ""
    sha256: str | None = None
    size: int | None = None
    step: int = 1
    keep_aspect: bool = True
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    deviation: tuple[float, float, float] = (0.229, 0.224, 0.225)
    output: str = ""

    def __post_init__(self) -> None:
        _check_gives(self.gives)


@dataclass(frozen=True, eq=False)
class Guide:
    """Depth, inverse depth or any other monotone function of depth for the pixels of a frame, from a depth estimation
    network or another sensor. A guide made from the measured depth itself, such as another completion, agrees with it
    wherever it is known and is therefore followed too closely. Immutable: its arrays are read-only copies.

    Parameters
    ----------
    values : array_like
        Shape (H, W), any real type. Zero and non-finite values are ignored and become NaN.
    confidence : array_like, optional
        Confidence of each value, 0 to 1; 1 if omitted.
    path : str, optional
        The file that it was read from.
    network : GuideCard, optional
        The known network that predicted it.
    gives : str, optional
        What the values are, by which they are fitted to known depth: "affine-inverse" or "affine" for a linear function
        of inverse depth or of depth, "metric" for depth in one unit. By default what the network gives; otherwise any
        function that rises or falls with depth.

    Raises
    ------
    InputError
        If shapes or types do not fit, or there are no usable values.

    Examples
    --------
    >>> Guide([[1, 2], [0, 4]]).values
    array([[ 1.,  2.],
           [nan,  4.]], dtype=float32)
    """

    values: NDArray[np.float32]
    confidence: NDArray[np.float32] | None = None
    path: str | None = None
    network: GuideCard | None = None
    gives: Gives | None = None

    if TYPE_CHECKING:  # as in RGBDFrame

        def __init__(
            self,
            values: ArrayLike,
            confidence: ArrayLike | None = None,
            path: str | None = None,
            network: GuideCard | None = None,
            gives: Gives | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        if self.gives is None and self.network is not None:
            object.__setattr__(self, "gives", self.network.gives)
        if self.gives is not None:
            _check_gives(self.gives)
        real = real_image(self.values, "A guide")
        with np.errstate(over="ignore"):
            values = real.astype(np.float32)
        values[~(np.abs(values) < _LARGEST) | (values == 0)] = np.nan
        if self.gives == "metric":
            values[values < 0] = np.nan
        usable = values[np.isfinite(values)]
        if usable.size == 0 or usable.min() == usable.max():
            raise InputError("The guide has no usable values: all are equal, 0, negative or not finite. Check it.")
        object.__setattr__(self, "values", frozen(values))
        if self.confidence is not None:
            confidence = np.nan_to_num(real_image(self.confidence, "A guide's confidence").astype(np.float32))
            check_shape("The guide's confidence", confidence.shape, values.shape, "the guide")
            if not 0 <= confidence.min() <= confidence.max() <= 1:
                raise InputError(
                    f"The guide's confidence is {confidence.min():.3g} to {confidence.max():.3g}, not 0 to 1. In an "
                    "array of shape (2, H, W), the second half is the confidence."
                )
            object.__setattr__(self, "confidence", frozen(confidence))

    def resized_to(self, shape: tuple[int, int]) -> Guide:
        """Return the guide resized to this height and width; raise InputError if the aspect ratio differs."""
        height, width = self.values.shape
        if (height, width) == shape:
            return self
        ratio = height * shape[1] / (width * shape[0])
        if abs(ratio - 1) > _ASPECT:
            raise InputError(
                f"The guide is {size_text((height, width))} but the frame is {size_text(shape)}, which has another "
                "aspect ratio: a guide must show the same part of the scene. Crop or pad it first."
            )
        known = np.isfinite(self.values)
        share = _resized(known.astype(np.float32), shape)
        total = _resized(np.where(known, self.values, np.float32(0)), shape)
        values = np.divide(total, share, out=np.full(shape, np.nan, np.float32), where=share >= _MIN_KNOWN_SHARE)
        confidence = None if self.confidence is None else _resized(self.confidence, shape)
        return replace(self, values=values, confidence=confidence)

    @property
    def array(self) -> NDArray[np.float32]:
        """Values (H, W), or values and confidence (2, H, W), in one array."""
        return self.values if self.confidence is None else np.stack([self.values, self.confidence])

    @classmethod
    def from_array(cls, array: NDArray[Any], path: str | None = None) -> Self:
        """Create a guide from an array, the inverse of `array`; axes of length 1 are dropped."""
        if array.ndim == 3 and array.shape[0] == 2:
            return cls(array[0], array[1], path)
        return cls(array.squeeze() if array.ndim > 2 else array, path=path)

    def is_same_as(self, other: Guide | None) -> bool:
        """Whether another guide has the same values and confidence, gives the same, and is of the same network."""
        return self is other or (
            other is not None
            and (self.gives, self.network) == (other.gives, other.network)
            and np.array_equal(self.array, other.array, equal_nan=True)
        )


def as_guide(guide: ArrayLike | Guide) -> Guide:
    """Return a guide unchanged, or make one from an array of values."""
    return guide if isinstance(guide, Guide) else Guide(guide)


def _resized(values: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    smaller = shape[0] < values.shape[0]
    size = (shape[1], shape[0])
    return cv2.resize(values, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR).astype(np.float32)
