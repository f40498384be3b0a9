"""What the iteration sees of a frame to begin with: where the surface is sought, and what is known there."""

from __future__ import annotations

import math
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from ...blocks import Block, Box, union, within
from ...edges.frame_edges import FrameEdges
from ...frame import RGBDFrame
from ...parameters import Parameters
from ..convergence import held_out_of
from .flying import flying_pixels
from .grid import Grid
from .guiding import FittedGuide
from .own_word import WIDE, own_distance
from .parting import Parting
from .reach import beyond_reach
from .trend import trend_of

Array = NDArray[np.float32]

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
        self._held_out = held_out_of(self._mask & trusted[self.place], parameters.hold_out)
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
