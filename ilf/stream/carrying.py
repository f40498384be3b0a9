"""Carrying values of an earlier frame to the current one: by optical flow, and depth by the motion of the camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.frame import RGBDFrame
from ..segmentation.propagation.motion import flow_between

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]
T = TypeVar("T")

_REDUCED = 320
"""Longer side [px] of the brightness images for flow: at half of 640 x 480 it is as accurate as needed here, in a
quarter of the time."""

_ALIKE = 20.0
"""Maximum difference of brightness [of 255] from the earlier frame along the flow, apart from a common change."""

_LEAST_SEEN = 0.3
"""Minimum share of the image that is visible in the earlier frame; below it, the scene has changed: between frames of
a video it is 0.7 to 0.95, after a turn by 30 degrees 0.37, between pictures of different places less than 0.25."""

# Offsets between frames, on the reduced grid.


def reduced_grey(frame: RGBDFrame) -> NDArray[np.uint8]:
    """Brightness of a frame for flow, reduced."""
    grey = cv2.cvtColor(frame.edge_rgb, cv2.COLOR_RGB2GRAY)
    height, width = grey.shape
    scale = min(1.0, _REDUCED / max(height, width))
    size = max(1, round(scale * width)), max(1, round(scale * height))
    return np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA) if scale < 1 else grey, np.uint8)


@dataclass(frozen=True, eq=False)
class Offsets:
    """For every pixel of the current frame, the offset of the same point in an earlier frame.

    Attributes
    ----------
    reduced : ndarray of float32, shape (h, w, 2)
        Offsets x, y in pixels of the reduced grid.
    seen : ndarray of bool, shape (h, w)
        Where the point is visible in the earlier frame, as far as the flow shows it.
    shape : tuple of int
        Height and width [px] of the frames.
    """

    reduced: Array
    seen: Mask
    shape: tuple[int, int]

    @classmethod
    def none(cls, shape: tuple[int, int], size: tuple[int, int]) -> Offsets:
        """From a frame to itself."""
        return cls(np.zeros((*size, 2), np.float32), np.ones(size, bool), shape)

    @classmethod
    def between(cls, current: NDArray[np.uint8], earlier: NDArray[np.uint8], shape: tuple[int, int]) -> Offsets | None:
        """By optical flow of two frames' reduced brightness; None if the two show different scenes."""
        found = cls(*flow_between(current, earlier), shape)
        moved = cv2.remap(earlier, *found._positions, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        change = current.astype(np.float32) - moved
        seen = found.seen & found._inside() & (np.abs(change - np.median(change)) <= _ALIKE)
        return None if np.count_nonzero(seen) < _LEAST_SEEN * seen.size else cls(found.reduced, seen, shape)

    def then(self, further: Offsets) -> Offsets:
        """The offsets to a still earlier frame, from those of the earlier frame to it."""
        x, y = self._positions
        more = cv2.remap(further.reduced, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        visible = cv2.remap(further.seen.astype(np.uint8), x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
        both = Offsets(self.reduced + more, self.seen & (visible > 0), self.shape)
        return Offsets(both.reduced, both.seen & both._inside(), self.shape)

    @property
    def visible(self) -> Mask:
        """`seen` at the frame's pixels, bool (H, W)."""
        height, width = self.shape
        return cv2.resize(self.seen.astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST) > 0

    def nearest(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of the earlier frame, (H, W), at the pixels of the current one: those of the nearest pixel."""
        return values.ravel()[self._index]

    def interpolated(self, values: Array) -> Array:
        """The same with bilinear interpolation."""
        return np.asarray(cv2.remap(values, *self._map, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)

    @cached_property
    def _positions(self) -> tuple[Array, Array]:
        height, width = self.reduced.shape[:2]
        return _at(self.reduced, width, height)

    def _inside(self) -> Mask:
        x, y = self._positions
        height, width = x.shape
        return (x > -0.5) & (x < width - 0.5) & (y > -0.5) & (y < height - 0.5)

    @cached_property
    def _map(self) -> tuple[Array, Array]:
        """Positions in the earlier frame, at full size."""
        height, width = self.shape
        full = cv2.resize(self.reduced, (width, height), interpolation=cv2.INTER_LINEAR)
        scale_y, scale_x = height / self.reduced.shape[0], width / self.reduced.shape[1]
        return _at(full * np.array([scale_x, scale_y], np.float32), width, height)

    @cached_property
    def _index(self) -> NDArray[np.intp]:
        height, width = self.shape
        x, y = self._map
        columns = np.clip(np.rint(x), 0, width - 1).astype(np.intp)
        return np.clip(np.rint(y), 0, height - 1).astype(np.intp) * width + columns


def _at(offsets: NDArray[Any], width: int, height: int) -> tuple[Array, Array]:
    """Positions x, y of all pixels plus their offsets."""
    x = offsets[..., 0] + np.arange(width, dtype=np.float32)
    y = offsets[..., 1] + np.arange(height, dtype=np.float32)[:, None]
    return np.asarray(x, np.float32), np.asarray(y, np.float32)


@dataclass(frozen=True, eq=False)
class Carried(Generic[T]):
    """Something found in an earlier frame, with the offsets of the current frame to it."""

    value: T
    offsets: Offsets

    def to_next(self, step: Offsets) -> Carried[T]:
        """The same for the next frame, from the offsets of that frame to the current one."""
        return Carried(self.value, step.then(self.offsets))


# Depth: carried, and changed as the camera's motion changes it.

_SIMILAR = 0.02
"""Between pixels whose depth differs by more than this share, depth is not interpolated."""

_STRIDE, _LEAST_PIXELS = 4, 50
"""The change of depth is fitted to every so many rows and columns of known depth, at least to so many pixels."""

_FIT_ROUNDS, _OFF = 4, 0.01
"""Rounds of reweighting, and the deviation [share of depth] at which a pixel's weight is halved."""


_NEARBY = 0.125
"""Side of the square in which known depth speaks for or against carried depth, as a share of the frame's longer
side."""

_CONTRADICTED, _TIMES_USUAL = 0.05, 5.0
"""Carried depth is dropped where known depth nearby is off by more than this share of depth and, as depth may be noisy,
by more than so many times what is usual in the frame."""

_MOST_OFF = 0.5
"""Share of depth as which a larger deviation counts."""


def carry_depth(before: Array, step: Offsets, frame: RGBDFrame) -> Array:
    """Depth [m] expected in a frame from the completed depth of the one before; NaN where that is not visible.

    With a rigid motion of the camera, depth z at image position (x, y) becomes a + z (b x + c y + d): this is fitted to
    the known depth, robustly, so that moving things do not matter.

    Parameters
    ----------
    before : ndarray of float32, shape (H, W)
        Completed depth [m] of the frame before, NaN = missing.
    step : Offsets
        From the frame to the one before.
    frame : RGBDFrame
    """
    expected, smooth = step.nearest(before), step.interpolated(before)
    with np.errstate(invalid="ignore"):
        np.copyto(expected, smooth, where=np.abs(smooth - expected) < np.float32(_SIMILAR) * expected)
    expected[~step.visible] = np.nan
    height, width = frame.shape
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j].astype(np.float32)
    lattice = np.s_[_STRIDE // 2 :: _STRIDE, _STRIDE // 2 :: _STRIDE]
    z, now = expected[lattice], frame.depth[lattice]
    both = np.isfinite(z) & np.isfinite(now)
    if np.count_nonzero(both) < _LEAST_PIXELS:
        return expected
    z, now = z[both], now[both]
    terms = np.stack([np.ones_like(z), x[lattice][both] * z, y[lattice][both] * z, z], axis=1)
    change, found = now - z, np.zeros(4, np.float32)
    weights = np.ones_like(z)
    found[3] = np.median(change / z)
    for _ in range(_FIT_ROUNDS):
        off = (change - terms @ found) / (np.float32(_OFF) * z)
        weights = 1 / ((1 + np.square(off)) * z)
        found = np.linalg.lstsq(terms * weights[:, None], change * weights, rcond=None)[0]
    a, b, c, d = (np.float32(one) for one in found)
    return np.asarray(expected + a + expected * (b * x + c * y + d), np.float32)


def drop_contradicted(expected: Array, depth: Array) -> None:
    """Set expected depth to NaN where known depth nearby contradicts it: beside moving things, and where a mistake has
    been carried. Both float32 (H, W) [m]; `depth` is NaN where it is missing."""
    lattice = np.s_[_STRIDE // 2 :: _STRIDE, _STRIDE // 2 :: _STRIDE]
    off = np.abs(expected[lattice] - depth[lattice]) / depth[lattice]
    known = np.isfinite(off)
    side = max(round(_NEARBY * max(expected.shape) / _STRIDE), 1)
    if not known.any():
        return
    limit = max(_CONTRADICTED, _TIMES_USUAL * float(np.median(off[known])))
    off = np.where(known, np.minimum(off, np.float32(_MOST_OFF)), np.float32(0))
    total, count = (cv2.boxFilter(one.astype(np.float32), -1, (side, side), normalize=False) for one in (off, known))
    contradicted = (count > 0.5) & (total > limit * count)  # the mean over the known pixels nearby
    full = cv2.resize(contradicted.astype(np.uint8), expected.shape[::-1], interpolation=cv2.INTER_NEAREST)
    expected[full > 0] = np.nan
