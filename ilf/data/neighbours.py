"""Depth that other frames have measured, in the view of a frame's camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .arrays import frozen, plain_array

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]

AGREEMENT = 0.03
"""Depths agree if they differ by at most this share."""

WEIGHT = 0.3
"""Weight of a pixel's depth from neighbours; a measured pixel has weight 1."""

_JUMP = 0.05
"""Relative difference of depth within 3 x 3 pixels from which on they lie beside a jump."""

_AROUND = 15
"""Side [px] of the squares in which the depth of a neighbour is compared with the frame's own."""

_MAX_DIFFERING = 0.3
"""Maximum share of compared pixels of a square that may differ."""

_WITHIN = 0.68
"""Share of the compared pixels that lie within the expected error."""

_MIN_COMPARED = 100
"""Minimum number of compared pixels for an expected error."""


@dataclass(frozen=True, eq=False)
class Neighbour:
    """A frame whose depth is used in another frame.

    Attributes
    ----------
    name : str
    motion : tuple of tuple of float
        Transform of points [m] from its camera to the other frame's camera, as rows of a matrix.
    sha256 : tuple of str
        SHA-256 of its colour and depth in its files; empty if it was not read from files.
    source : mapping
        Location and reading options of its files, as `FrameRef.to_json`; empty if it was not read from files.
    """

    name: str
    motion: tuple[tuple[float, ...], ...]
    sha256: tuple[str, ...] = ()
    source: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class NeighbourDepth:
    """Depth of a frame's neighbours in the view of its camera. Immutable.

    Attributes
    ----------
    layers : ndarray of float32, shape (N, H, W)
        Depth [m] of every neighbour; NaN where it has measured none, or shows something else.
    neighbours : tuple of Neighbour
        In the same order.
    """

    layers: Depth
    neighbours: tuple[Neighbour, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", frozen(plain_array(self.layers)))

    def is_same_as(self, other: NeighbourDepth | None) -> bool:
        """Whether another one has the same depth."""
        return self is other or (other is not None and np.array_equal(self.layers, other.layers, equal_nan=True))

    def fused(self, depth: Depth) -> Depth:
        """Fuse the neighbours' depth: the median where most of those that show a pixel agree, except beside jumps.

        A neighbour is left out where its depth differs from the frame's own at the pixel or at many pixels around it:
        something has moved, or the motion of the camera is not exact.

        Parameters
        ----------
        depth : ndarray of float32, shape (H, W)
            The frame's own depth [m], NaN = missing.

        Returns
        -------
        ndarray of float32, shape (H, W)
            Depth [m], also where the frame has its own; NaN = none.

        Examples
        --------
        >>> layers = np.array([[[2.0, 2.0, 2.06]], [[2.02, 2.4, np.nan]]], np.float32)
        >>> NeighbourDepth(layers, ()).fused(np.array([[2.0, np.nan, np.nan]], np.float32)).round(2)
        array([[2.01,  nan, 2.06]], dtype=float32)
        """
        layers = np.stack([np.where(_differs(layer, depth), np.float32(np.nan), layer) for layer in self.layers])
        median = median_of_known(layers)
        agreeing = np.count_nonzero(agrees(layers, median), axis=0)
        most = 2 * agreeing > np.count_nonzero(np.isfinite(layers), axis=0)
        found = np.where(most, median, np.float32(np.nan))
        return np.where(beside_jumps(np.where(np.isfinite(depth), depth, found)), np.float32(np.nan), found)

    def relative_error(self, depth: Depth) -> float:
        """Estimate the error of the fused depth, as a share of depth, by its differences from the frame's own.

        Parameters
        ----------
        depth : ndarray of float32, shape (H, W)
            The frame's own depth [m], NaN = missing.
        """
        median = median_of_known(self.layers)
        both = np.isfinite(median) & np.isfinite(depth)
        if np.count_nonzero(both) < _MIN_COMPARED:
            return AGREEMENT
        return float(np.quantile(np.abs(median[both] - depth[both]) / depth[both], _WITHIN))


def agrees(one: Depth, other: Depth) -> Mask:
    """Find pixels, bool (H, W), with depth in both images [m] that agrees."""
    with np.errstate(invalid="ignore"):
        return np.abs(one - other) <= np.float32(AGREEMENT) * other


def median_of_known(depths: Depth) -> Depth:
    """Compute the median of the known depths, (N, H, W), along the first axis."""
    ordered = np.sort(depths, axis=0)  # NaN comes last
    known = np.count_nonzero(np.isfinite(depths), axis=0)
    low, high = (
        np.take_along_axis(ordered, place[None], axis=0)[0] for place in (np.maximum(known - 1, 0) // 2, known // 2)
    )
    return np.where(known % 2 == 1, low, (low + high) / 2).astype(np.float32)


def beside_jumps(depth: Depth) -> Mask:
    """Find pixels, bool (H, W), within one pixel of a jump of known depth [m]."""
    known, square = np.isfinite(depth), np.ones((3, 3), np.uint8)
    near = cv2.erode(np.where(known, depth, np.float32(np.inf)), square)
    far = cv2.dilate(np.where(known, depth, np.float32(0)), square)
    return np.asarray(far / np.float32(1 + _JUMP) > near)


def _differs(layer: Depth, depth: Depth) -> Mask:
    """Pixels where a layer differs from the frame's own depth, at the pixel or at many pixels around it."""
    both = np.isfinite(layer) & np.isfinite(depth)
    differing = both & ~agrees(layer, depth)
    compared, apart = (cv2.blur(mask.astype(np.float32), (_AROUND, _AROUND)) for mask in (both, differing))
    return differing | (apart > np.float32(_MAX_DIFFERING) * compared + np.float32(1e-6))
