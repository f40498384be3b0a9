"""Depth by hand: depth that the user states where none was measured, as a constraint on the completion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import as_float
from ..errors import InputError
from .arrays import check_shape, plain_array
from .frame import FARTHEST_DEPTH, RGBDFrame, read_only

USUAL_WEIGHT = 0.3
"""Weight of a pixel's depth by hand; a measured pixel has weight 1."""


@dataclass(frozen=True, eq=False)
class DepthByHand:
    """Depth stated by the user. It counts at pixels of blocks without measured depth, also where that is marked
    invalid, and never as measured. Immutable: its array is a read-only copy.

    Parameters
    ----------
    depth : array_like
        Depth [m], any real type, shape (H, W), or at the pixels of one block. NaN and 0 state nothing and become NaN.
    weight : float
        Weight of each pixel relative to a measured one, 0 to 1; 0 has no effect. The pass band ignores it.

    Raises
    ------
    InputError
        If it is not an array of real numbers, a depth is negative, infinite or above 300 m, or the weight is out of
        range.

    Examples
    --------
    >>> DepthByHand([[1.5, 0.0], [np.nan, 2.0]]).pixels
    array([[ True, False],
           [False,  True]])
    >>> DepthByHand([[-1.0]])
    Traceback (most recent call last):
    ilf.errors.InputError: Depth by hand must be 0 to 300 m, not -1 m. 0 or NaN is none.
    """

    depth: NDArray[np.float32]
    weight: float = USUAL_WEIGHT

    if TYPE_CHECKING:  # as in RGBDFrame

        def __init__(self, depth: ArrayLike, weight: float = USUAL_WEIGHT) -> None: ...

    def __post_init__(self) -> None:
        array = plain_array(self.depth)
        if array.dtype.kind not in "iuf":
            raise InputError(f"Depth by hand must be one real number per pixel, not {array.dtype}.")
        wrong = array[(array < 0) | (array > FARTHEST_DEPTH)]
        if wrong.size:
            raise InputError(f"Depth by hand must be 0 to {FARTHEST_DEPTH:g} m, not {wrong[0]:g} m. 0 or NaN is none.")
        depth = array.astype(np.float32, copy=False)
        if (depth == 0).any():
            depth = np.where(depth == 0, np.float32(np.nan), depth)
        object.__setattr__(self, "depth", read_only(depth))
        weight = as_float(self.weight)
        if not 0 <= weight <= 1:
            raise InputError(f"The weight of depth by hand must lie between 0 and 1, not {self.weight!r:.60}.")
        object.__setattr__(self, "weight", weight)

    @property
    def pixels(self) -> NDArray[np.bool_]:
        """Pixels with depth by hand, of the shape of `depth`."""
        return np.isfinite(self.depth)

    def is_same_as(self, other: DepthByHand | None) -> bool:
        """Whether another one has the same depth and weight."""
        return self is other or (
            other is not None
            and self.weight == other.weight
            and np.array_equal(self.depth, other.depth, equal_nan=True)
        )

    def check_counts(self, frame: RGBDFrame, labels: NDArray[np.int32]) -> None:
        """Raise InputError if it counts nowhere: all its pixels have measured depth, or are in no block."""
        missing = self.pixels & frame.missing
        if not missing.any():
            raise InputError("Depth by hand counts only where depth is missing. Mark the measured depth invalid first.")
        if not labels[missing].any():
            raise InputError(
                "Depth by hand counts only in blocks, and no block has its pixels. Add them to a block first."
            )


def as_by_hand(given: ArrayLike | DepthByHand, shape: tuple[int, int]) -> DepthByHand | None:
    """Return depth by hand from an array or unchanged; None if it states nothing or has no weight. Raise InputError if
    it does not have this shape (H, W)."""
    by_hand = given if isinstance(given, DepthByHand) else DepthByHand(given)
    check_shape("Depth by hand", by_hand.depth.shape, shape)
    return by_hand if by_hand.weight > 0 and by_hand.pixels.any() else None
