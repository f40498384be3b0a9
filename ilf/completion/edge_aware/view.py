"""What the iteration sees of a frame to begin with: where the surface is sought, and what is known there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Block, Box, union, within
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.parameters import Parameters
from ...data.results import held_out_of
from ...segmentation.edges.frame_edges import FrameEdges
from .fitted_guide import FittedGuide, fit_guide
from .grid import Grid, Parting
from .shape import trend_of

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Block-local edges: around wide gaps, edges fade towards the block's own known depth alone.
#
# Among dense samples the depth itself says where the jumps are, so edges fade towards known depth. But beside a wide
# gap, what is known of other blocks says nothing of this one: there it is the edge that must part them.

WIDE = 8
"""A gap is wide where a pixel is so far [px] from known depth; up to there, samples on both sides say enough."""


def around_wide_gaps(distance: Array) -> Mask:
    """Pixels of wide gaps and beside them, bool (H, W), from every pixel's distance to known depth."""
    square = np.ones((2 * WIDE + 1,) * 2, np.uint8)
    return cv2.dilate((distance >= WIDE).astype(np.uint8), square) > 0


def own_distance(distance: Array, inside: Mask) -> Array:
    """How far [px] pixels are from the known depth that edges fade towards: in the block and around wide gaps, its own.

    Parameters
    ----------
    distance : ndarray of float32, shape (H, W)
        To any known depth, 0 there.
    inside : ndarray of bool, shape (H, W)
        The block's pixels.
    """
    if not (distance >= WIDE).any():
        return distance
    own = cv2.distanceTransform((~(inside & (distance == 0))).astype(np.uint8), cv2.DIST_L2, 5)
    return np.where(inside & around_wide_gaps(distance), own, distance).astype(np.float32)


# Sensor range: what is missing in holes that begin where it ends lies beyond all that is known around.

_REACH_SHARE = 0.99
"""So much of a frame's known depth lies within the reach."""

_AT_REACH = 0.98
"""Known depth is at the reach from so much of it on."""

_RIM, _LEAST_RIM = 4, 20
"""The rim of a hole is the block's known depth up to so many pixels from it, and has so many pixels. Its median, the
hole's limit, must be at the reach."""

_DENSE = 0.5
"""So much of what is up to that far from the hole must be known: where depth is thin everywhere, rims say little."""

_BACK = 8, 24
"""Between these distances [px] from a hole lies the block's known depth that its rim must rise above."""

_RISING = 1.03
"""By how much, in medians."""

_NEARER = 0.85
"""Known depth beside the hole that is less than so much of its limit belongs to something in front."""


@dataclass(frozen=True, eq=False)
class Beyond:
    """Holes of a block that lie beyond the sensor's reach, as their rims say.

    Attributes
    ----------
    pixels : ndarray of bool, shape (H, W)
        The block's missing pixels there.
    in_front : ndarray of bool, shape (H, W)
        Known pixels beside them, of whatever block, of something in front.
    limit : float
        Depth [m] at which the nearest of the holes begins.
    """

    pixels: Mask
    in_front: Mask
    limit: float


@once_per_frame
def reach_of(frame: RGBDFrame) -> float:
    """Depth [m] beyond which the frame knows hardly any."""
    return float(np.quantile(frame.depth[frame.known], _REACH_SHARE))


def beyond_reach(frame: RGBDFrame, block: Block) -> Beyond | None:
    """Wide holes of a block whose rims rise to the sensor's reach; None if there is none, or if a guide that known
    depth bears out tells what lies there.

    Nothing that was measured vouches for what is filled in there.
    """
    guide = fit_guide(frame)
    if guide is not None and guide.carries(block):
        return None
    at_reach = _AT_REACH * reach_of(frame)
    if not (frame.depth[block.box][block.mask] >= at_reach).any():
        return None
    rows, columns = (slice(max(side.start - _BACK[1], 0), side.stop + _BACK[1]) for side in block.box)
    depth, known = frame.depth[rows, columns], frame.known[rows, columns]
    inside = np.zeros(frame.shape, bool)
    inside[block.box] = block.mask
    distance = cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 5).astype(np.float32, copy=False)
    missing = inside[rows, columns] & ~known & around_wide_gaps(distance)
    count, holes, boxes, _ = cv2.connectedComponentsWithStats(missing.astype(np.uint8), connectivity=4)
    pixels, in_front, limits = np.zeros(frame.shape, bool), np.zeros(frame.shape, bool), []
    for number in range(1, count):
        x, y, width, height = boxes[number, :4]
        part = np.s_[max(y - _BACK[1], 0) : y + height + _BACK[1], max(x - _BACK[1], 0) : x + width + _BACK[1]]
        hole, there = holes[part] == number, depth[part]
        own = inside[rows, columns][part] & known[part]
        off = cv2.distanceTransform((~hole).astype(np.uint8), cv2.DIST_L2, 5)
        rim, back = there[own & (off <= _RIM)], there[own & (off > _BACK[0]) & (off <= _BACK[1])]
        if rim.size < _LEAST_RIM or back.size == 0 or known[part][(off <= _RIM) & ~hole].mean() < _DENSE:
            continue
        limit = float(np.median(rim))
        if limit < max(at_reach, _RISING * float(np.median(back))):
            continue
        pixels[rows, columns][part] |= hole
        in_front[rows, columns][part] |= (off <= _BACK[0]) & (there < _NEARER * limit)
        limits.append(limit)
    return Beyond(pixels, in_front, min(limits)) if limits else None


# Flying pixels: samples that the known depth around them does not bear out.

_REACH = 2
"""Neighbours are the pixels up to so many pixels away along each axis."""

_LIKE = 0.05
"""Samples are alike if they differ by less than this share of their depth."""

_FEW = 8
"""With fewer known neighbours than that, a sample is all there is."""

_LEAST_SHARE = 0.1
"""A sample flies if no larger share of its known neighbours is like it: a line that is one pixel wide does not."""


@once_per_frame
def flying_pixels(frame: RGBDFrame) -> NDArray[np.bool_]:
    """Known pixels that hardly any known neighbour is like, bool (H, W)."""
    height, width = frame.shape
    known = frame.known
    depth = np.where(known, frame.depth, np.float32(0))
    neighbours, alike = np.zeros(frame.shape, np.uint8), np.zeros(frame.shape, np.uint8)
    for dy in range(_REACH + 1):
        for dx in range(-_REACH, _REACH + 1):
            if (dy, dx) <= (0, 0):
                continue  # every pair once
            here = np.s_[: height - dy, max(0, -dx) : min(width, width - dx)]
            there = np.s_[dy:, max(0, dx) : min(width, width + dx)]
            both = known[here] & known[there]
            near = np.abs(depth[here] - depth[there]) < np.float32(_LIKE) * np.minimum(depth[here], depth[there])
            near &= both
            for part in (here, there):
                neighbours[part] += both
                alike[part] += near
    return known & (neighbours >= _FEW) & (alike <= np.float32(_LEAST_SHARE) * neighbours)


# The view: the window around the block, and the finest grid that is made of it.

_CONTEXT = {"fill": 20, "fill+denoise": 40}
"""Known depth around a block counts up to a distance of 1 / so much of the frame's longer side."""

_QUIET = 0.005
"""Noise, as a share of depth, up to which known pixels are followed as the weights say."""

_CALM = 10.0
"""Of heavier noise, known pixels are followed down to this many times less where a trend explains them all."""

_LEFT = 0.1
"""A trend explains the known depth if that deviates from it by less than so many deviations of noise beside that."""

_AROUND = 10.0
"""A guide is followed so far around what is farther from known depth than `WIDE` [px], which takes in the known depth
at the rim, and fades out over as much again."""

NEAREST = 0.1
"""Depth [m] below which what is given as a share of depth no longer shrinks."""

_APART = 10.0
"""Edge strength that leaves nothing of what comes from something in front of a hole beyond the sensor's reach."""


class View:
    """What the stepper sees of a frame: the window, and the block in it. It serves to begin with, and is let go."""

    def __init__(self, frame: RGBDFrame, block: Block, parameters: Parameters, drawn: NDArray[np.bool_] | None) -> None:
        self._frame = frame
        self._block = block
        self.window = _window(frame, block, parameters.mode)
        self._around = around = union(block.box, self.window)
        self.place = within(self.window, around)
        """The window in the box around block and window."""
        self.mask = np.zeros(frame.depth[around].shape, bool)
        """The block's pixels in the box around block and window."""
        self.mask[within(block.box, around)] = block.mask
        self._mask = self.mask[self.place]
        self._drawn: NDArray[np.bool_] | None = None
        if drawn is not None:
            at = np.zeros(self.mask.shape, bool)
            at[self.mask] = drawn
            self._drawn = at[self.place]

        known = np.isfinite(frame.depth[around])
        trusted = known
        if parameters.jump_share:
            trusted = known & ~flying_pixels(frame)[around]
            if not trusted[self.mask].any():
                trusted = known
        self._held_out = held_out_of(self._mask & trusted[self.place], parameters.validation_share)
        self.depth = np.where(trusted, frame.depth[around], np.float32(np.nan))
        """Depth [m] in that box, without flying pixels and what is held out."""
        self.depth[self.place][self._held_out] = np.nan
        unknown = np.isnan(self.depth[self.place])
        self._distance = cv2.distanceTransform(unknown.astype(np.uint8), cv2.DIST_L2, 5).astype(np.float32, copy=False)
        self.gap = float(self._distance[self._mask].max())
        """Largest distance [px] of the block's pixels in the window from known depth."""
        wanted = parameters.out_of_range and self.gap >= WIDE
        self.beyond = beyond_reach(frame, block) if wanted else None
        """What of the block lies beyond the sensor's reach; None if nothing."""

    @cached_property
    def raw(self) -> Array:
        """Depth [m] in the box around block and window, without what is held out."""
        raw = self._frame.depth[self._around].copy()
        raw[self.place][self._held_out] = np.nan
        return raw

    def mean_depth(self, guide: FittedGuide | None) -> float:
        """Of the block's known depth [m]; of what its guide says where there is none."""
        known = self.depth[self.mask]
        if guide is not None and not np.isfinite(known).any():
            known = guide.depth[self._block.box][self._block.mask]
        return float(np.nanmean(known, dtype=np.float64))

    def trend(self, depth: float, noise: float, shaped: bool) -> tuple[Array, float, bool]:
        """Trend [m] on the window, how much stiffer the surface is for the noise in the known depth, and whether the
        trend explains that depth up to its noise."""
        quiet = _QUIET * max(depth, NEAREST)
        found = trend_of(self.depth, self.mask, noise) if shaped else None
        # where what is left of the depth is noise more than anything, it is followed the less
        followed = quiet if found is None else min(quiet, max(found.spread, quiet / _CALM))
        stiffness = (noise / followed) ** 2 if noise > quiet else 1.0
        if found is None:
            return np.full(self._mask.shape, depth, np.float32), stiffness, False
        return found.surface[self.place], stiffness, found.spread < _LEFT * noise

    def guided(self, trend: Array, guide: FittedGuide) -> Array:
        """What a guide says in place of a trend [m], on the window, as far as it is believed: in and around wide gaps
        alone, since among dense samples its own details are worth less than theirs."""
        wide = self._distance >= WIDE
        if not wide.any():
            return trend
        away = cv2.distanceTransform((~wide).astype(np.uint8), cv2.DIST_L2, 5)
        share = guide.shares(self._block, self.window) * np.clip(2 - away / np.float32(_AROUND), 0, 1)
        return np.where(share > 0, trend + share * (guide.depth[self.window] - trend), trend)

    def grid(self, trend: Array, found: FrameEdges, parameters: Parameters) -> Grid:
        """The finest grid."""
        counts, totals = _samples(self.depth[self.place] - trend)
        held_out = None
        if self._held_out.any():
            rest = self._frame.depth[self.window] - trend
            held_out = _samples(np.where(self._held_out, rest, np.float32(np.nan)))
        mask = self._mask.astype(np.uint8)
        cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
        boundary = cv2.morphologyEx(mask, cv2.MORPH_GRADIENT, cross).astype(np.float32)
        # among dense samples the depth itself says where the jumps are, and colour is registered a few pixels off
        distance = self._distance
        if parameters.own_word:
            distance = own_distance(distance, self._mask)
        fade = np.minimum(distance / np.float32(parameters.trust_distance), 1)
        edges = fade * np.maximum(found.strength[self.window], np.float32(parameters.boundary_strength) * boundary)
        if self.beyond is not None:
            edges[self.beyond.in_front[self.window]] = _APART
        return Grid(
            cell=1,
            counts=counts,
            totals=totals,
            inside=mask.astype(np.float32),
            trend=trend,
            edges=edges.astype(np.float32),
            creases=None if found.crease is None else fade * found.crease[self.window],
            held_out=held_out,
            parting=None if self._drawn is None else Parting.around(self._mask, self._drawn),
        )


def _window(frame: RGBDFrame, block: Block, mode: str) -> Box:
    """Where the surface is sought: around all that may change, with some known depth beyond."""
    rows, columns = block.box
    wanted = block.mask & np.isnan(frame.depth[block.box]) if mode == "fill" else block.mask
    if not wanted.any():
        wanted = block.mask
    found = []
    for axis, side in enumerate((rows, columns)):
        places = np.flatnonzero(wanted.any(axis=1 - axis)) + side.start
        found.append(slice(int(places[0]), int(places[-1]) + 1))
    return widest_window(frame.shape, (found[0], found[1]), mode)


def widest_window(shape: tuple[int, int], box: Box, mode: str) -> Box:
    """Where the surface is sought in a frame of this shape (H, W), if all that may change is in a box."""
    margin = math.ceil(max(shape) / _CONTEXT[mode])
    rows, columns = (
        slice(max(side.start - margin, 0), min(side.stop + margin, size)) for side, size in zip(box, shape, strict=True)
    )
    return rows, columns


def _samples(values: Array) -> tuple[Array, Array]:
    """How many samples a pixel has, 1 or 0, and their sum."""
    known = np.isfinite(values)
    return known.astype(np.float32), np.where(known, values, np.float32(0))
