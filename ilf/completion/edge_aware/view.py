"""The input of the iteration: the window of the frame that it works on, and the known depth there."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Block, Box, bounds, grown, moved, union, within
from ...data.by_hand import DepthByHand
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.neighbours import WEIGHT
from ...data.parameters import Parameters
from ...data.pixel_grids import distance_to, sides
from ...data.results import hold_out_mask
from ...segmentation.edges.frame_edges import FrameEdges
from .fitted_guide import FittedGuide, fit_guide
from .grid import CutLinks, Grid
from .noise import frame_noise
from .shape import trend_of

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Block-local edges: around wide gaps, edges fade only towards the block's own known depth.
#
# Among dense samples, depth itself contains the jumps, so edges fade towards known depth. But beside a wide gap, the
# known depth of other blocks is not informative: there, the edge must separate them.

WIDE = 8
"""Distance [px] from known depth at which a gap is wide; below it, the samples on both sides suffice."""


def around_wide_gaps(distance: Array) -> Mask:
    """Find pixels in and beside wide gaps, bool (H, W), from every pixel's distance to known depth."""
    square = np.ones((2 * WIDE + 1,) * 2, np.uint8)
    return cv2.dilate((distance >= WIDE).view(np.uint8), square) > 0


def edge_fade_distance(distance: Array, inside: Mask) -> Array:
    """Distance [px] to the known depth that edges fade towards: in the block around wide gaps, to the block's own.

    Parameters
    ----------
    distance : ndarray of float32, shape (H, W)
        Distance to any known depth, 0 there.
    inside : ndarray of bool, shape (H, W)
        The block's pixels.
    """
    if not (distance >= WIDE).any():
        return distance
    own = distance_to(inside & (distance == 0))
    np.copyto(own, distance, where=~(inside & around_wide_gaps(distance)))
    return own


# Sensor range: holes whose rims lie at the end of the range are farther than all known depth around.

_REACH_SHARE = 0.99
"""Quantile of a frame's known depth that is its sensor range."""

_AT_REACH = 0.98
"""Share of the sensor range from which on known depth is at its end."""

_RIM, _LEAST_RIM = 4, 20
"""The rim of a hole is the block's known depth up to so many pixels from it; it has at least so many pixels. Its
median, the hole's limit, must be at the end of the range."""

_DENSE = 0.5
"""Minimum share of known pixels up to that distance from the hole: with sparse depth, rims are not informative."""

_BACK = 8, 24
"""Distances [px] from a hole between which the block's known depth must be nearer than the rim."""

_RISING = 1.03
"""Minimum ratio of the two medians."""

_NEARER = 0.85
"""Known depth beside the hole below this share of its limit belongs to something in front."""


@dataclass(frozen=True, eq=False)
class BeyondRange:
    """Holes of a block beyond the sensor range, detected by their rims.

    Attributes
    ----------
    pixels : ndarray of bool, shape (H, W)
        The block's missing pixels there.
    in_front : ndarray of bool, shape (H, W)
        Known pixels beside them, in any block, of something in front.
    limit : float
        Depth [m] at which the nearest of the holes begins.
    """

    pixels: Mask
    in_front: Mask
    limit: float


@once_per_frame
def _missing_in_wide_gaps(frame: RGBDFrame) -> Mask:
    return ~frame.known & around_wide_gaps(distance_to(frame.known))


@once_per_frame
def sensor_range_of(frame: RGBDFrame) -> float:
    """The sensor range of a frame: depth [m] beyond which hardly any is known."""
    return float(np.quantile(frame.depth[frame.known], _REACH_SHARE))


def beyond_sensor_range(frame: RGBDFrame, block: Block) -> BeyondRange | None:
    """Find wide holes of a block whose rims rise to the sensor range; None if there are none, or if a guide suffices to
    fill them.

    Depth that is filled in there is unsupported by measurements.
    """
    missing = _missing_in_wide_gaps(frame)
    if not (missing[block.box] & block.mask).any():
        return None
    if frame.guide is not None and fit_guide(frame).suffices_for(block):
        return None
    at_reach = _AT_REACH * sensor_range_of(frame)
    if not (frame.depth[block.box][block.mask] >= at_reach).any():
        return None
    rows, columns = grown(block.box, _BACK[1], frame.shape)
    depth, known = frame.depth[rows, columns], frame.known[rows, columns]
    inside = np.zeros(depth.shape, bool)
    inside[within(block.box, (rows, columns))] = block.mask
    own_missing = (inside & missing[rows, columns]).view(np.uint8)
    count, holes, boxes, _ = cv2.connectedComponentsWithStats(own_missing, connectivity=4)
    pixels, in_front, limits = np.zeros(frame.shape, bool), np.zeros(frame.shape, bool), []
    at_end = inside & (depth >= at_reach)
    for number in range(1, count):
        x, y, width, height, _ = boxes[number].tolist()
        box = slice(y, y + height), slice(x, x + width)
        # else the rim's median cannot be at the end
        if 2 * np.count_nonzero(at_end[grown(box, _RIM, depth.shape)]) < _LEAST_RIM:
            continue
        part = grown(box, _BACK[1], depth.shape)
        hole, there = holes[part] == number, depth[part]
        own = inside[part] & known[part]
        off = distance_to(hole)
        rim, back = there[own & (off <= _RIM)], there[own & (off > _BACK[0]) & (off <= _BACK[1])]
        if rim.size < _LEAST_RIM or back.size == 0 or known[part][(off <= _RIM) & ~hole].mean() < _DENSE:
            continue
        limit = float(np.median(rim))
        if limit < max(at_reach, _RISING * float(np.median(back))):
            continue
        pixels[rows, columns][part] |= hole
        in_front[rows, columns][part] |= (off <= _BACK[0]) & (there < _NEARER * limit)
        limits.append(limit)
    return BeyondRange(pixels, in_front, min(limits)) if limits else None


# Flying and swapped pixels: samples that differ from the known depth around them.

_REACH = 2
"""Maximum distance [px] of neighbours along each axis."""

_SIMILAR = 0.05
"""Samples are alike if they differ by less than this share of their depth."""

_FEW = 8
"""Minimum number of known neighbours for the test."""

_LEAST_SHARE = 0.1
"""Maximum share of similar known neighbours of a flying pixel; a line of one pixel's width has more."""


@once_per_frame
def flying_pixels(frame: RGBDFrame) -> Mask:
    """Find known pixels that hardly any known neighbour is similar to, bool (H, W)."""
    depth = frame.depth
    beside = np.zeros(frame.shape, np.uint8)
    for pair, counts in zip(sides(depth), sides(beside), strict=True):
        near = _similar(*pair)
        for count in counts:
            count += near
    # the others have too many similar neighbours even if all neighbours are known
    rows, columns = np.nonzero(frame.known & (beside <= _LEAST_SHARE * len(_DIRECTIONS)))
    own = depth[rows, columns]
    neighbours, alike = np.zeros(own.shape, np.uint8), np.zeros(own.shape, np.uint8)
    for _, other in _around(depth, rows, columns):
        neighbours += np.isfinite(other)
        alike += _similar(own, other)
    flying = np.zeros(frame.shape, bool)
    flying[rows, columns] = (neighbours >= _FEW) & (alike <= np.float32(_LEAST_SHARE) * neighbours)
    return flying


_JAGGED, _FEWEST_BESIDE = 0.03, 200
"""Jumps are jagged if this share of the pixels beside them differs from three or all of the four pixels around it and
has similar depth on one side only, and there are enough pixels to tell. Structured light registered to colour has 3 to
8 %, other sensors at most 2 %, exact jumps and thin things, even of one pixel's width, less than 2 %."""

_CLEAR = 4.0
"""Jumps can be told from noise if samples are alike up to so many deviations of it."""


@once_per_frame
def swapped_pixels(frame: RGBDFrame) -> Mask:
    """Find known pixels that show the depth of the other side of a jagged jump, bool (H, W); none where jumps are even.

    Structured light assigns some pixels beside a jump to its other side. Single pixels that differ may also be thin
    things, so they count only if the frame's jumps are jagged as a whole. A thin thing goes on in two directions, so
    its pixels make no jump jagged.
    """
    depth, none = frame.depth, np.zeros(frame.shape, bool)
    known = depth[frame.known]
    if _CLEAR * frame_noise(frame).deviation(known).mean() > _SIMILAR * known.mean():
        return none
    different = np.zeros(frame.shape, np.uint8)
    for (one, other), counts in zip(sides(depth), sides(different), strict=True):
        far = np.abs(one - other) >= np.float32(_SIMILAR) * np.minimum(one, other)
        for count in counts:
            count += far
    swapped = different >= 3
    beside, jagged = np.count_nonzero(different), np.count_nonzero(~_goes_on(depth, *np.nonzero(swapped)))
    return swapped if beside >= _FEWEST_BESIDE and jagged >= _JAGGED * beside else none


_DIRECTIONS = [(y, x) for y in range(-_REACH, _REACH + 1) for x in range(-_REACH, _REACH + 1) if (y, x) != (0, 0)]
_OPPOSITE = {1: 0.0, _REACH: 0.85}
"""Distance [px] along the longer axis of two similar pixels -> minimum negative cosine of the angle between them at
which they are on two sides."""


def _goes_on(depth: Array, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Mask:
    """Whether similar known depth lies on two sides of some pixels, as along a line."""
    own = depth[rows, columns]
    similar = {at: _similar(own, there) for at, there in _around(depth, rows, columns)}
    found = np.zeros(rows.shape, bool)
    for distance, least in _OPPOSITE.items():
        ring = [at for at in _DIRECTIONS if max(map(abs, at)) == distance]
        for one, other in itertools.combinations(ring, 2):
            cosine = (one[0] * other[0] + one[1] * other[1]) / (math.hypot(*one) * math.hypot(*other))
            if cosine < -least:
                found |= similar[one] & similar[other]
    return found


def _around(depth: Array, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Iterator[tuple[tuple[int, int], Array]]:
    """Every direction, and depth there from some pixels, NaN beyond the frame."""
    around = np.pad(depth, _REACH, constant_values=np.nan)
    for y, x in _DIRECTIONS:
        yield (y, x), around[rows + _REACH + y, columns + _REACH + x]


def _similar(one: Array, other: Array) -> Mask:
    """Whether depth is known and alike."""
    off, limit = one - other, np.minimum(one, other)
    limit *= np.float32(_SIMILAR)
    return np.abs(off, out=off) < limit


# The view: the window around the block, and the finest grid made from it.

_CONTEXT = {"fill": 20, "fill+denoise": 40}
"""Known depth around a block is used up to a distance of the frame's longer side divided by this."""

_LOW_NOISE = 0.005
"""Noise, as a share of depth, up to which the weights are not adapted."""

_MAX_SOFTENING = 10.0
"""Maximum factor by which known pixels with more noise are followed less where a trend explains them all."""

_EXPLAINED_SPREAD = 0.1
"""A trend explains the known depth if the deviation beyond noise is less than so many deviations of noise."""

_AROUND = 10.0
"""Distance [px] up to which a guide is followed around pixels of wide gaps, which includes the known depth at the rim;
it fades out over the same distance again."""

NEAREST = 0.1
"""Depth [m] below which thresholds given as a share of depth are constant."""

CARRIED_WEIGHT = 0.02
"""Weight of depth carried from another frame, at missing pixels, relative to a known pixel."""

_COVERED = 0.9
"""Minimum share of the missing pixels for which carried depth replaces the trend."""

WELL_KNOWN = 0.5
"""Minimum known share of a block whose filled depth keeps to the range of its known depth."""

_SEPARATING_EDGE = 10.0
"""Edge strength that fully separates a hole beyond the sensor range from something in front of it."""


class View:
    """The stepper's view of a frame: the window, and the block in it. Used for set-up only."""

    def __init__(
        self,
        frame: RGBDFrame,
        block: Block,
        parameters: Parameters,
        drawn: NDArray[np.bool_] | None,
        by_hand: DepthByHand | None,
        carried: Array | None,
    ) -> None:
        self._frame = frame
        self._block = block
        self.window = _window(frame, block, parameters.mode)
        around = union(block.box, self.window)
        self.place = within(self.window, around)
        """The window in the box around block and window."""
        self.mask = np.zeros(frame.depth[around].shape, bool)
        """The block's pixels in the box around block and window."""
        self.mask[within(block.box, around)] = block.mask
        self._mask = self.mask[self.place]
        self._carried = carried
        self._drawn: NDArray[np.bool_] | None = None
        if drawn is not None:
            at = np.zeros(self.mask.shape, bool)
            at[self.mask] = drawn
            self._drawn = at[self.place]

        self._measured = frame.depth[around]
        if parameters.mode == "fill+denoise":
            even = np.where(swapped_pixels(frame)[around], np.float32(np.nan), self._measured)
            if np.isfinite(even[self.mask]).any():
                self._measured = even
        known = np.isfinite(self._measured)
        trusted = known
        if parameters.jump_share:
            trusted = known & ~flying_pixels(frame)[around]
            if not trusted[self.mask].any():
                trusted = known
        self._held_out = hold_out_mask(self._mask & trusted[self.place], parameters.validation_share)
        self.depth = np.where(trusted, self._measured, np.float32(np.nan))
        """Depth [m] in that box, without flying and held-out pixels; to be denoised, without swapped ones."""
        self.depth[self.place][self._held_out] = np.nan
        added = frame.from_neighbours
        self.weights = None if added is None else np.where(added[self.window], np.float32(WEIGHT), np.float32(1))
        """Weights of the known depth in the window; None for 1."""
        self._by_hand: tuple[Array, float] | None = None
        """Depth by hand [m] in that box, NaN for none, and its weight. Edges fade towards measured depth only."""
        if by_hand is not None:
            stated = np.full(self.mask.shape, np.nan, np.float32)
            stated[self.mask] = by_hand.depth
            self._by_hand = stated, by_hand.weight
        unknown = np.isnan(self.depth[self.place])
        self._distance = distance_to(~unknown)
        self.gap = float(self._distance[self._mask].max())
        """Largest distance [px] of the block's pixels in the window from known depth."""
        self.is_carried = False
        """Whether carried depth covers nearly all that is missing, so that no trend is needed."""
        if carried is not None:
            missing = self._mask & unknown
            covered = np.isfinite(carried[self.window]) & missing
            self.is_carried = bool(np.count_nonzero(covered) >= _COVERED * np.count_nonzero(missing))
        wanted = parameters.out_of_range and self.gap >= WIDE
        self.beyond = beyond_sensor_range(frame, block) if wanted else None
        """The block's holes beyond the sensor range; None without any."""

    @cached_property
    def raw(self) -> Array:
        """Depth [m] in the box around block and window, without held-out pixels; to be denoised, without swapped
        ones."""
        raw = self._measured.copy()
        raw[self.place][self._held_out] = np.nan
        return raw

    @cached_property
    def _stated(self) -> Array:
        """The depth [m] in the box with depth by hand in its gaps."""
        return self.depth if self._by_hand is None else np.where(np.isnan(self.depth), self._by_hand[0], self.depth)

    def mean_depth(self, guide: FittedGuide | None) -> float:
        """Mean of the block's known depth and depth by hand [m]; of its guide if there is neither."""
        known = self._stated[self.mask]
        if guide is not None and not np.isfinite(known).any():
            known = guide.depth[self._block.box][self._block.mask]
        return float(np.nanmean(known, dtype=np.float64))

    def trend(self, depth: float, noise: float, shaped: bool) -> tuple[Array, float, bool]:
        """Trend [m] of known depth and depth by hand in the window, factor on the stiffness due to noise in the known
        depth, and whether the trend explains that depth up to its noise."""
        quiet = _LOW_NOISE * max(depth, NEAREST)
        found = trend_of(self._stated, self.mask, noise) if shaped else None
        # where the residual is mostly noise, known depth is followed less
        followed = quiet if found is None else min(quiet, max(found.spread, quiet / _MAX_SOFTENING))
        stiffness = (noise / followed) ** 2 if noise > quiet else 1.0
        if found is None:
            return np.full(self._mask.shape, depth, np.float32), stiffness, False
        return found.surface[self.place], stiffness, found.spread < _EXPLAINED_SPREAD * noise

    def limits(self, trend: Array) -> tuple[float, float]:
        """Limits of the block's surface [m]: the range of its known depth, depth by hand and trend, unless most of the
        block is missing. Depth of other blocks that leaks through a gap in an edge is often beyond them."""
        known, filled = self._stated[self.mask], trend[self._mask]
        if np.count_nonzero(np.isfinite(known)) < WELL_KNOWN * known.size:
            return -math.inf, math.inf
        return float(min(np.nanmin(known), filled.min())), float(max(np.nanmax(known), filled.max()))

    def guided(self, trend: Array, guide: FittedGuide) -> Array:
        """Replace a trend [m] in the window by the guide, as far as it is believed: only in and around wide gaps, since
        among dense samples the guide's details are less accurate than theirs."""
        wide = self._distance >= WIDE
        if not wide.any():
            return trend
        away = distance_to(wide)
        share = guide.shares(self._block, self.window) * np.clip(2 - away / np.float32(_AROUND), 0, 1)
        return np.where(share > 0, trend + share * (guide.depth[self.window] - trend), trend)

    def grid(self, trend: Array, found: FrameEdges, parameters: Parameters) -> Grid:
        """The finest grid."""
        counts, totals = _samples(self.depth[self.place] - trend)
        if self.weights is not None:
            counts, totals = counts * self.weights, totals * self.weights
        if self._by_hand is not None:
            stated, weight = self._by_hand[0][self.place], np.float32(self._by_hand[1])
            added = np.isfinite(stated)
            counts[added] += weight
            totals[added] += weight * (stated - trend)[added]
        held_out = None
        if self._held_out.any():
            rest = self._frame.depth[self.window] - trend
            held_out = _samples(np.where(self._held_out, rest, np.float32(np.nan)))
        carried = None
        if self._carried is not None:
            expected, sums = _samples(self._carried[self.window] - trend)
            hint = np.float32(CARRIED_WEIGHT) * (counts == 0)
            carried = hint * expected, hint * sums
        mask = self._mask.astype(np.uint8)
        cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
        boundary = cv2.morphologyEx(mask, cv2.MORPH_GRADIENT, cross).astype(np.float32)
        # among dense samples depth itself contains the jumps, and colour is registered a few pixels off
        distance = self._distance
        if parameters.block_local_edges:
            distance = edge_fade_distance(distance, self._mask)
        fade = distance / np.float32(parameters.trust_distance)
        np.minimum(fade, 1, out=fade)
        # in place, since fresh memory takes longer than all of this
        edges = np.multiply(np.float32(parameters.boundary_strength), boundary, out=boundary)
        np.maximum(found.strength[self.window], edges, out=edges)
        edges *= fade
        if self.beyond is not None:
            edges[self.beyond.in_front[self.window]] = _SEPARATING_EDGE
        edges /= np.float32(-parameters.edge_scale)
        return Grid(
            cell=1,
            counts=counts,
            totals=totals,
            inside=mask.astype(np.float32),
            trend=trend,
            smooth=np.exp(edges, out=edges),
            creases=None if found.crease is None else fade * found.crease[self.window],
            held_out=held_out,
            carried=carried,
            cut_links=None if self._drawn is None else CutLinks.around(self._mask, self._drawn),
        )


def _window(frame: RGBDFrame, block: Block, mode: str) -> Box:
    """The window of the surface: all that may change, with some known depth around."""
    wanted = bounds(block.mask & ~frame.own[block.box]) if mode == "fill" else None
    box = block.box if wanted is None else moved(wanted, block.box[0].start, block.box[1].start)
    return max_window(frame.shape, box, mode)


def max_window(shape: tuple[int, int], box: Box, mode: str) -> Box:
    """The window of the surface in a frame of this shape (H, W), if all that may change is in a box."""
    return grown(box, math.ceil(max(shape) / _CONTEXT[mode]), shape)


def _samples(values: Array) -> tuple[Array, Array]:
    """Number of samples of every pixel, 1 or 0, and their sum."""
    known = np.isfinite(values)
    return known.astype(np.float32), np.where(known, values, np.float32(0))
