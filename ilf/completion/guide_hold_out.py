"""The hold-out test of a frame's guide: what the whole method makes of hidden depth with the guide, and without it, in
all and in ranges of depth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import length_text
from ..data.frame import RGBDFrame

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

_LARGEST_RATIO = 0.9
"""Largest ratio of the mean error with the guide to that without, in every hold-out, with which it is followed."""

_RANGES = 4
"""Number of ranges of depth, from near to far, that pixels are divided into, as many in each."""

_LARGEST_RATIO_OF_RANGE, _LEAST_ERROR = 1.4, 0.003
"""A guide is not followed if the mean error in any range of depth grows beyond this ratio and this share of depth. Most
of the error is far away: a guide that halves it may spoil what is near."""

_BLEND = 0.2
"""Difference of the logarithm of depth over which a range begins or ends."""

_LEAST_HIDDEN = 0.01
"""Minimum share of the known depth that a hold-out hides, or in a range of depth."""

_TURNS = (np.s_[::-1, ::-1], np.s_[:, ::-1])
"""The frame's own gaps are turned by half a turn, then mirrored, to hide known depth."""


@dataclass(frozen=True)
class FollowedRanges:
    """Ranges of depth in which a guide is followed, from near to far.

    Attributes
    ----------
    limits : tuple of float
        Between the ranges [m].
    followed : tuple of bool
        For each range.
    """

    limits: tuple[float, ...]
    followed: tuple[bool, ...]

    def share(self, depth: Array) -> Array:
        """Share of the guide, 0-1, in a pixel of this depth [m] without it; changes slowly at the limits."""
        share = np.full(depth.shape, float(self.followed[0]), np.float32)
        for limit, before, after in zip(self.limits, self.followed[:-1], self.followed[1:], strict=True):
            if before != after:
                share += (int(after) - int(before)) * np.clip(np.log(depth / limit) / _BLEND + 0.5, 0, 1)
        return share

    def mixed(self, with_guide: Array, without: Array) -> Array:
        """Depth [m] with the guide where it is followed, and without it elsewhere."""
        if all(self.followed):
            return with_guide
        there = np.isfinite(with_guide) & np.isfinite(without)
        share = self.share(np.where(there, without, np.float32(1)))
        return np.where(there, without + share * (with_guide - without), without).astype(np.float32)

    def to_text(self) -> str:
        """The followed ranges as text for the user."""
        bounds, around = ("", *map(length_text, self.limits), ""), (False, *self.followed, False)
        changes = list(zip(bounds, around[:-1], around[1:], strict=True))
        starts = [bound for bound, before, after in changes if after and not before]
        ends = [bound for bound, before, after in changes if before and not after]
        return " and ".join(
            f"from {near} to {far}" if near and far else f"up to {far}" if far else f"from {near} on"
            for near, far in zip(starts, ends, strict=True)
        )


@dataclass(frozen=True)
class GuideHoldOut:
    """Errors of hold-outs with a guide, in the ranges of depth in which it is followed, and without it.

    Attributes
    ----------
    with_guide, without : tuple of float
        Mean absolute error in all hold-outs [m]; NaN if there were none.
    ranges : FollowedRanges
        All of them if the mean error is smaller enough with the guide in each hold-out, the root mean square error no
        larger, and the mean error in no range of depth much larger; otherwise those where most errors are smaller, if
        the same is true when it is followed in them alone.
    """

    with_guide: float
    without: float
    ranges: FollowedRanges

    @property
    def compared(self) -> bool:
        """Whether there were any hold-outs."""
        return not math.isnan(self.without)

    @property
    def followed(self) -> bool:
        """Whether the guide is followed, at least in some ranges of depth."""
        return any(self.ranges.followed)

    @property
    def everywhere(self) -> bool:
        """Whether it is followed at any depth."""
        return all(self.ranges.followed)

    def to_text(self) -> str:
        """The result as text for the user, after "The guide is"."""
        found, before = length_text(self.with_guide), length_text(self.without)
        errors = f"on a hold-out of known depth, the mean error is {found} with it and {before} without"
        if self.everywhere:
            return f"followed: {errors}"
        if self.followed:
            return f"followed in a part, at depth {self.ranges.to_text()}: {errors}"
        demand = "; it must be clearly smaller, and in no part larger" if self.with_guide < self.without else ""
        return f"not used: {errors}{demand}"


def held_out_frames(frame: RGBDFrame) -> Iterator[RGBDFrame]:
    """The frame without known depth where its own gaps lie when they are turned, one frame for each way."""
    for turn in _TURNS:
        hidden = frame.missing[turn] & frame.own
        if _LEAST_HIDDEN * frame.own.sum() <= hidden.sum() < frame.own.sum():
            depth = np.where(hidden, np.float32(np.nan), frame.own_depth)
            yield replace(frame, depth=depth, invalid_mask=None, ground_truth=None)


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Depth [m] of the pixels of one hold-out: known, and completed with the guide and without."""

    depth: Array
    with_guide: Array
    without: Array
    limits: tuple[float, ...]
    least: float
    """Minimum number of pixels in a range of depth that it is judged by."""

    @classmethod
    def of(cls, frame: RGBDFrame, held_out: RGBDFrame, with_guide: Array, without: Array) -> HeldOut:
        """From the frame, that without the hidden depth, and its completed depths [m]."""
        there = frame.own & ~held_out.own & np.isfinite(with_guide) & np.isfinite(without)
        known = frame.depth[frame.own]
        limits = np.quantile(known, np.arange(1, _RANGES) / _RANGES)
        depth, found, before = (one[there] for one in (frame.depth, with_guide, without))
        return cls(depth, found, before, tuple(map(float, limits)), _LEAST_HIDDEN * known.size)

    @cached_property
    def errors(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Absolute errors with the guide and without [m]."""
        found, before = (np.abs((one - self.depth).astype(np.float64)) for one in (self.with_guide, self.without))
        return found, before

    @property
    def better(self) -> bool:
        """Whether the mean error is smaller enough with the guide, the root mean square error no larger, and no range
        of depth much worse."""
        found, before = self.errors
        excess = found - _LARGEST_RATIO_OF_RANGE * before - _LEAST_ERROR * self.depth
        ranges = np.array_split(excess[np.argsort(self.without, kind="stable")], _RANGES)
        unspoilt = all(excess_there.sum() <= 0 for excess_there in ranges)
        smaller = found.sum() <= _LARGEST_RATIO * before.sum() and np.square(found).sum() <= np.square(before).sum()
        return bool(unspoilt and smaller)

    @property
    def better_ranges(self) -> tuple[bool, ...]:
        """For each range of depth, whether it has enough pixels, and both the large errors and most of them are smaller
        enough there with the guide."""
        place, better = np.digitize(self.without, self.limits), []
        for number in range(_RANGES):
            at = place == number
            found, before = (np.sqrt(error[at]).sum() for error in self.errors)
            # roots, since few large errors may hide that most have grown
            most = at.sum() >= self.least and found <= _LARGEST_RATIO * before
            part = replace(self, depth=self.depth[at], with_guide=self.with_guide[at], without=self.without[at])
            better.append(bool(most and part.better))
        return tuple(better)

    def followed_in(self, ranges: FollowedRanges) -> HeldOut:
        """The same with the guide followed in these ranges alone."""
        return replace(self, with_guide=ranges.mixed(self.with_guide, self.without))


def ranges_of_all(held_out: Sequence[HeldOut]) -> tuple[bool, ...]:
    """For each range of depth, whether the guide is to be followed there by every hold-out of it alone."""
    return tuple(map(all, zip(*(one.better_ranges for one in held_out), strict=True)))


def decided(held_out: Sequence[HeldOut], otherwise: bool) -> GuideHoldOut:
    """The test's result; if no depth was hidden, the guide is followed or not as `otherwise` says."""
    if not any(one.depth.size for one in held_out):
        return GuideHoldOut(math.nan, math.nan, FollowedRanges((), (otherwise,)))
    limits = held_out[0].limits
    for followed in ((True,) * _RANGES, ranges_of_all(held_out)):
        ranges = FollowedRanges(limits, followed)
        used = [one.followed_in(ranges) for one in held_out]
        if all(one.better for one in used):
            return GuideHoldOut(*_means(used), ranges)
    return GuideHoldOut(*_means(held_out), FollowedRanges(limits, (False,) * _RANGES))


def _means(held_out: Sequence[HeldOut]) -> tuple[float, float]:
    """Mean absolute errors with the guide and without [m]."""
    found, before = (np.concatenate(errors) for errors in zip(*(one.errors for one in held_out), strict=True))
    return float(found.mean()), float(before.mean())
