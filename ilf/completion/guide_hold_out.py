"""The hold-out test of a frame's guide: what the whole method makes of hidden depth with the guide, and without it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import length_text
from ..data.frame import RGBDFrame

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

_LARGEST_RATIO = 0.9
"""Largest ratio of the mean error with the guide to that without, in every hold-out, with which it is followed."""

_RANGES = 4
"""Number of ranges of depth, from near to far, that the hidden pixels are divided into, as many in each."""

_LARGEST_RATIO_OF_RANGE, _LEAST_ERROR = 1.4, 0.003
"""A guide is not followed if the mean error in any range of depth grows beyond this ratio and this share of depth. Most
of the error is far away: a guide that halves it may spoil what is near."""

_LEAST_HIDDEN = 0.01
"""Minimum share of the known depth that a hold-out hides."""

_TURNS = (np.s_[::-1, ::-1], np.s_[:, ::-1])
"""The frame's own gaps are turned by half a turn, then mirrored, to hide known depth."""


@dataclass(frozen=True)
class GuideHoldOut:
    """Errors of hold-outs with a guide and without it.

    Attributes
    ----------
    with_guide, without : tuple of float
        Mean absolute error in all hold-outs [m].
    followed : bool
        Whether it is smaller enough with the guide in each of them, the root mean square error no larger, and the mean
        error in no range of depth much larger.
    """

    with_guide: float
    without: float
    followed: bool

    def to_text(self) -> str:
        """The result as text for the user, after "The guide is"."""
        found, before = length_text(self.with_guide), length_text(self.without)
        errors = f"on a hold-out of known depth, the mean error is {found} with it and {before} without"
        if self.followed:
            return f"followed: {errors}"
        demand = "; it must be clearly smaller, and in no part larger" if self.with_guide < self.without else ""
        return f"not used: {errors}{demand}"


def held_out_frames(frame: RGBDFrame) -> Iterator[RGBDFrame]:
    """The frame without known depth where its own gaps lie when they are turned, one frame for each way."""
    for turn in _TURNS:
        hidden = frame.missing[turn] & frame.own
        if _LEAST_HIDDEN * frame.own.sum() <= hidden.sum() < frame.own.sum():
            depth = np.where(hidden, np.float32(np.nan), frame.own_depth)
            yield replace(frame, depth=depth, invalid_mask=None, ground_truth=None)


@dataclass(frozen=True)
class HeldOutErrors:
    """Sums of the absolute and squared errors of one hold-out, and whether no range of depth has become much worse."""

    pixels: int
    with_guide: tuple[float, float]
    without: tuple[float, float]
    unspoilt: bool

    @classmethod
    def of(cls, frame: RGBDFrame, held_out: RGBDFrame, with_guide: Array, without: Array) -> HeldOutErrors:
        """From the frame, that without the hidden depth, and its completed depths [m]."""
        there = frame.own & ~held_out.own & np.isfinite(with_guide) & np.isfinite(without)
        found, before = (np.abs((one - frame.depth)[there].astype(np.float64)) for one in (with_guide, without))
        excess = found - _LARGEST_RATIO_OF_RANGE * before - _LEAST_ERROR * frame.depth[there]
        ranges = np.array_split(excess[np.argsort(without[there], kind="stable")], _RANGES)
        summed, summed_before = ((float(error.sum()), float(np.square(error).sum())) for error in (found, before))
        return cls(found.size, summed, summed_before, all(excess_there.sum() <= 0 for excess_there in ranges))

    @property
    def better(self) -> bool:
        """Whether the mean error is smaller enough with the guide, the root mean square error no larger, and no range
        of depth much worse."""
        (mean, square), (mean_before, square_before) = self.with_guide, self.without
        return self.unspoilt and mean <= _LARGEST_RATIO * mean_before and square <= square_before


def decided(found: list[HeldOutErrors]) -> GuideHoldOut | None:
    """The test's result; None if no depth was hidden, so that nothing speaks for the guide or against it."""
    pixels = sum(one.pixels for one in found)
    if not pixels:
        return None
    return GuideHoldOut(
        sum(one.with_guide[0] for one in found) / pixels,
        sum(one.without[0] for one in found) / pixels,
        all(one.better for one in found),
    )
