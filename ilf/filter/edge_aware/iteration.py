"""ILF on one block with a low-pass filter that lets go at edges: as smooth as the data allow, and no smoother.

The iteration u <- S(raw where known, u elsewhere) with the soft low-pass S = (1 + L)^-1 has the minimum of an energy as
its fixed point (`smoothness`). Conjugate gradients go there in far fewer steps; and what would take thousands of them,
the long waves, is found on a coarse grid first. So the stages are grids here: the coarsest, solved directly, then
finer and finer ones up to the pixels, and last a few rounds in which differences far above the noise let go.
"""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ...blocks import Block, Box, union, within
from ...edges.frame_edges import FrameEdges
from ...frame import RGBDFrame
from ...parameters import Parameters
from ..convergence import deviation, held_out_of
from ..pyramid import enlarged, largest_of_four, sums_of_four
from ..snapshot import Snapshot
from ..sums import inner
from .denoising import Denoising
from .flying import flying_pixels
from .guiding import FittedGuide, fit_guide
from .kernels import Sums, tally
from .noise import Noise, frame_noise
from .own_word import WIDE, own_distance
from .parting import Parting
from .polynomial import polynomial_trend
from .reach import beyond_reach
from .record import EdgeAwareRecord
from .smoothness import SmoothnessEnergy, Told, Weights, make_weights
from .trend import noise_of, trend_of

Array = NDArray[np.float32]

_CONTEXT = {"fill": 20, "fill+denoise": 40}
"""Known depth around a block counts up to a distance of 1 / so much of the frame's longer side."""

_DIRECT_CELLS = 2000
"""The coarsest grid has no more cells than that."""

_HALVINGS = 2
"""The coarsest grid has cells of at least 2^so many pixels."""

_STEPS, _FINEST_STEPS = 40, 20
"""Steps of conjugate gradients on every grid between the coarsest and the finest, and on the finest, at most."""

_BEFORE_ROUNDS = 8
"""The same on the finest where rounds that take off noise follow."""

_ROUNDS, _ROUND_STEPS = 2, 8
"""Rounds in which jumps let go, and the steps in each, at most."""

_SLOPE_JUMPS = 4.0
"""First differences let go at so many times the second difference that does."""

_QUIET = 0.005
"""Noise, as a share of depth, up to which known pixels are followed as the weights say."""

_CALM = 10.0
"""Of heavier noise, known pixels are followed down to this many times less where a trend explains them all."""

_LEFT = 0.1
"""A trend explains the known depth if that deviates from it by less than so many deviations of noise beside that."""

_AROUND = 10.0
"""A guide is followed so far around what is farther from known depth than `WIDE` [px], which takes in the known depth
at the rim, and fades out over as much again."""

_NEAREST = 0.1
"""Depth [m] below which what is given as a share of depth no longer shrinks."""

_APART = 10.0
"""Edge strength that leaves nothing of what comes from something in front of a hole beyond the sensor's reach."""

_OUT_OF_RANGE = (
    "Depth is missing where it rises to the sensor's reach, at {:.1f} m: it is taken to go on beyond, and nothing that "
    "was measured vouches for it."
)

_LEVELLING = 1e-9
"""Weight of the trend where there is no data, in the largest of all weights: keeps corners that edges cut off from
being singular."""


class EdgeAwareIteration(Iterator[EdgeAwareRecord]):
    """The `Stepper` of filter "edge-aware": every `next()` is one iteration of one block and gives its record.

    Works on a window around the block's missing pixels (around all of its pixels in the mode fill+denoise). Known
    depth in the window counts whatever block it is in, as far as the edges between let it; the block's pixels outside
    the window keep their raw depth, as P_i. sigma_i and the L1 norm are those of the grid that the stage works on. So
    are residual and hold-out error: of a surface that is constant in every cell but for the trend, against the depth
    of the single pixels, so coarse grids have what varies inside their cells in it. The residual is over all known
    depth in the window; held out are pixels of the block in it. Edges, flying pixels and noise are those of the frame,
    found with all of its depth; so is the guide, which takes the trend's place as far as it is believed: what it says
    of shape and jumps stays in, and what is filtered is what the known depth says otherwise.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth, unless a guide carries them.
    parameters : Parameters
        With filter "edge-aware".
    edges : FrameEdges
        Those of the frame.
    drawn : ndarray of bool, optional
        The block's pixels, in the order of `block.mask`'s True values, whose border was drawn by hand: nothing passes
        there from beyond it.
    """

    def __init__(
        self,
        frame: RGBDFrame,
        block: Block,
        parameters: Parameters,
        edges: FrameEdges,
        drawn: NDArray[np.bool_] | None = None,
    ) -> None:
        self._start = time.perf_counter()
        self._frame, self._block, self._parameters = frame, block, parameters
        view = _View(frame, block, parameters, drawn)
        self._window, self._gap = view.window, view.gap
        guide = fit_guide(frame)
        depth = view.mean_depth(guide)
        noise = parameters.noise or noise_of(view.depth, view.mask)
        shaped = parameters.trend and view.gap >= WIDE
        found = None if parameters.mode == "fill" else self._noise(frame)
        explained = polynomial_trend(view.raw, view.mask, found) if found and parameters.trend else None
        if explained is not None:
            trend, stiffness, follows = explained[view.place], 1.0, True
        else:
            trend, stiffness, follows = view.trend(depth, noise, shaped)
        if guide is not None:
            trend = view.guided(trend, guide)
        self._denoising = None
        if found is not None:
            self._denoising = Denoising.of(view.raw[view.place], trend, found, parameters, follows)
        self._least = parameters.s_criteria
        self._finest_steps = _FINEST_STEPS if self._denoising is None else _BEFORE_ROUNDS
        weights = parameters.smoothness * stiffness
        self._slope, self._bending = weights * parameters.slope_weight, weights * parameters.bending_weight
        self._levelling = np.float32(_LEVELLING * max(1.0, self._slope, self._bending))
        self._jump = max(noise, parameters.jump_share * max(depth, _NEAREST)) if parameters.jump_share else math.inf

        self._finest = finest = view.grid(np.ascontiguousarray(trend), edges, parameters)
        self._known_squares = inner(finest.totals, finest.totals)
        self._held_out_squares = inner(finest.held_out[1], finest.held_out[1]) if finest.held_out else 0.0
        grids = [finest]
        while len(grids) <= _HALVINGS or grids[-1].counts.size > _DIRECT_CELLS:
            grids.append(grids[-1].halved())
        self._levels = tuple(grid.level for grid in grids)
        self._coarser = grids[1:]
        self._changing = self._pixels_of(changing=parameters.mode == "fill")
        self._current = finest, np.zeros(finest.counts.shape, np.float32)
        raw = frame.depth[block.box][block.mask]
        # all of it is known: the window is around the gaps
        self._outside = float(raw[~_seen(block, view.window)].sum(dtype=np.float64))
        self._pixels = raw.size
        self._iterations = 0
        self._stage = self._round = 0
        self._sigma = math.inf
        self._truth: tuple[NDArray[np.bool_], NDArray[np.float64]] | None = None
        self._steps = self._run()
        self.settled = False
        """Whether the last stage has come to its end."""
        self.network = edges.network
        self.notes = edges.notes if guide is None else (*edges.notes, *guide.notes)
        if found is not None and not parameters.noise:
            self.notes += (found.note,)
        if view.beyond is not None:
            self.notes += (_OUT_OF_RANGE.format(view.beyond.limit),)

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; the trend before i = 1."""
        return self._held(self._all).surface

    @cached_property
    def _all(self) -> _Pixels:
        """All of the block's pixels in the window; only found where someone looks, since they take much memory."""
        return self._pixels_of()

    def _pixels_of(self, changing: bool = False) -> _Pixels:
        """The block's pixels in the window, all or those without depth."""
        return _Pixels.of(self._frame, self._block, self._window, self._levels, self._finest.trend, changing)

    def snapshot(self) -> Snapshot:
        """The surface as it stands, where it may become depth; at other pixels, raw depth.

        It is held on the grid of its iteration, of the finest just what is needed: it costs time, too, to fill memory.
        """
        return self._held(self._changing)

    def _held(self, pixels: _Pixels) -> Snapshot:
        grid, u = self._current
        held = u.copy() if grid.coarseness else pixels.on(u)  # u lies in memory that holds other iterations, too
        return Snapshot(partial(pixels.on_block, grid.coarseness, held), held.nbytes, pixels.nbytes)

    @property
    def explained(self) -> bool:
        """Whether the trend explains all of the known depth, up to its noise; in the mode fill+denoise."""
        return self._denoising is not None and self._denoising.explained

    @property
    def remark(self) -> str:
        """Said of an iteration whose last stage was not steady at its end."""
        if self._steady:
            return ""
        return f"The last stage ended by its number of steps, at sigma_i = {1000 * self._sigma:.2g} mm."

    @property
    def _steady(self) -> bool:
        return self._sigma < self._least

    def __next__(self) -> EdgeAwareRecord:
        if self._iterations >= self._parameters.max_iterations:
            raise StopIteration
        grid, u, sums = next(self._steps)
        self._iterations += 1
        self._sigma = math.sqrt(sums.changes / self._pixels)
        # one assignment, so that another thread may look at the surface while an iteration is under way
        self._current = grid, u
        return EdgeAwareRecord(
            i=self._iterations,
            stage=self._stage,
            sigma_i=self._sigma,
            l1=sums.sizes + self._outside,
            residual=_root_mean(sums.misfits + self._known_squares, grid.samples),
            held_out=self._held_out(grid, u),
            seconds=time.perf_counter() - self._start,
            error=self._error(),
            cell=grid.cell,
            round=self._round,
        )

    def _held_out(self, grid: _Grid, u: Array) -> float:
        if grid.held_out is None:
            return math.nan
        counts, totals = grid.held_out
        squares = inner(counts * u - 2 * totals, u) + self._held_out_squares
        return _root_mean(squares, float(counts.sum(dtype=np.float64)))

    def judge(self, pixels: NDArray[np.bool_], truth: NDArray[np.float64]) -> None:
        """Let records tell the error against a truth from now on, see `Stepper`."""
        self._truth = pixels, truth

    def _error(self) -> float:
        if self._truth is None:
            return math.nan
        pixels, truth = self._truth
        return deviation(self.surface[pixels], truth)

    def _run(self) -> Iterator[_Step]:
        """All stages: of every iteration its grid, P_i there less the trend, and what there is to tell of it."""
        if self._denoising is None:
            yield from self._fill()
        else:
            yield from self._denoise(self._finest, self._denoising)
        self.settled = True

    def _fill(self) -> Generator[_Step, None, Array]:
        """From the coarsest grid to the finest, and there the rounds in which jumps let go.

        Grids that are done with are let go, and weights have one memory on the finest: those of windows that are as
        large as the frame are most of what a run takes.
        """
        finest, grid = self._finest, self._coarser.pop()
        self._stage = 1
        u = self._energy(grid, self._weights(grid)).minimum()
        yield grid, u, grid.sums(u, grid.start)
        while grid is not finest:
            level, grid = grid.level, self._coarser.pop() if self._coarser else finest
            limit = self._finest_steps if grid is finest else _STEPS
            weights = self._weights(grid)
            u = yield from self._descend(grid, self._energy(grid, weights), level.enlarged(u, grid.level), limit)
        if math.isfinite(self._jump) and self._denoising is None:
            for self._round in range(1, _ROUNDS + 1):
                weights = self._weights(finest, weights)
                weights.loosen(u, np.full(u.shape, self._jump, np.float32), _SLOPE_JUMPS)
                u = yield from self._descend(finest, self._energy(finest, weights), u, _ROUND_STEPS)
        return u

    def _denoise(self, grid: _Grid, known: Denoising) -> Iterator[_Step]:
        """The gaps first, unless the trend says what is there, and then the rounds that take the noise off."""
        filled = None
        stiffer = self._parameters.smoothness > 1
        if stiffer or (self._gap > 0 and not known.explained):
            filled = yield from self._fill()
        parameters = self._parameters
        smooth = grid.smooth(parameters.edge_scale)
        slope, bending = (parameters.smoothness * w for w in (parameters.slope_weight, parameters.bending_weight))
        self._least = min(self._least, known.least)
        # what is to be smoother than noise calls for starts smooth
        u = filled if stiffer and filled is not None else known.start(filled)
        weights = make_weights(*smooth, slope, bending, grid.stiff)
        for self._round, step in enumerate(known.rounds(filled, weights), 1):
            u = yield from self._descend(grid, step.energy(u), u, step.steps)
        if known.explained or not self._iterations:
            cleared = known.cleared(u)
            yield grid, cleared, grid.sums(cleared, u)

    def _noise(self, frame: RGBDFrame) -> Noise:
        return Noise(self._parameters.noise) if self._parameters.noise else frame_noise(frame)

    def _descend(self, grid: _Grid, energy: SmoothnessEnergy, u: Array, limit: int) -> Generator[_Step, None, Array]:
        """One stage: until steady, or so many steps."""
        self._stage += 1
        told = Told(grid.inside, grid.trend, grid.counts, grid.totals, self._pixels * self._least**2)
        steps = energy.descend(u, told, min(limit, self._parameters.max_iterations - self._iterations))
        for u, sums in steps:
            yield grid, u, sums
        return u

    def _energy(self, grid: _Grid, weights: Weights) -> SmoothnessEnergy:
        return SmoothnessEnergy(grid.counts + self._levelling, grid.totals, weights)

    def _weights(self, grid: _Grid, out: Weights | None = None) -> Weights:
        # of a surface on cells of c pixels, slopes add up to the same, bending to c^2 times as much
        smooth = grid.smooth(self._parameters.edge_scale)
        return make_weights(*smooth, self._slope, self._bending / grid.cell**2, grid.stiff, out)


class _Level(NamedTuple):
    """What surfaces need to know of a grid to get from it to the next finer one."""

    shape: tuple[int, ...]
    parting: Parting | None

    def enlarged(self, u: Array, finer: _Level) -> Array:
        """A surface on this grid on the next finer one."""
        if self.parting is None or finer.parting is None:
            return enlarged(u, finer.shape)
        return self.parting.enlarged(u, finer.parting)


@dataclass(frozen=True, eq=False)
class _Grid:
    """A level of the pyramid over the window.

    `counts` and `totals` are of the known depth less the trend, `inside` counts the block's pixels in every cell;
    `edges` is the largest edge strength there, `creases` the largest probability of a crease, or None where nothing
    tells of them. `held_out` is counts and totals of the depth that is held out, or None; `parting` is what a drawn
    border parts, or None.
    """

    cell: int
    counts: Array
    totals: Array
    inside: Array
    trend: Array
    edges: Array
    creases: Array | None
    held_out: tuple[Array, Array] | None
    parting: Parting | None

    @property
    def coarseness(self) -> int:
        """How many levels it is above the finest."""
        return self.cell.bit_length() - 1

    @cached_property
    def samples(self) -> float:
        """How many pixels of known depth there are."""
        return float(self.counts.sum(dtype=np.float64))

    @property
    def start(self) -> Array:
        """The cells' known depth less the trend; 0 where there is none."""
        return np.divide(self.totals, np.maximum(self.counts, 1))

    def sums(self, u: Array, previous: Array) -> Sums:
        """What there is to tell of a step to u."""
        return Sums(*tally(u, previous, self.inside, self.trend, self.counts, self.totals))

    def smooth(self, edge_scale: float) -> tuple[Array, Array]:
        """How much smoothness is left between neighbours along x and y: as much as in the lesser of the two."""
        left = np.exp(-self.edges / np.float32(edge_scale))
        smooth = np.minimum(left[:, 1:], left[:, :-1]), np.minimum(left[1:], left[:-1])
        return smooth if self.parting is None else self.parting.cut(*smooth)

    @property
    def stiff(self) -> Array | None:
        """How much of the bending counts around every cell; None for all."""
        return None if self.creases is None else 1 - self.creases

    @property
    def level(self) -> _Level:
        """What surfaces need to know of it."""
        return _Level(self.counts.shape, self.parting)

    def halved(self) -> _Grid:
        """The next level: cells of twice the size."""
        counts, totals, edges = self.counts, self.totals, self.edges
        if self.parting is not None:
            counts, totals, edges = (
                np.where(self.parting.kept, values, np.float32(0)) for values in (counts, totals, edges)
            )
        return _Grid(
            cell=2 * self.cell,
            counts=sums_of_four(counts),
            totals=sums_of_four(totals),
            inside=sums_of_four(self.inside),
            trend=np.float32(0.25) * sums_of_four(self.trend, "edge"),
            edges=largest_of_four(edges),
            creases=None if self.creases is None else largest_of_four(self.creases),
            held_out=self.held_out and (sums_of_four(self.held_out[0]), sums_of_four(self.held_out[1])),
            parting=self.parting and self.parting.halved(),
        )


_Step = tuple[_Grid, Array, Sums]


class _View:
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
        quiet = _QUIET * max(depth, _NEAREST)
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

    def grid(self, trend: Array, found: FrameEdges, parameters: Parameters) -> _Grid:
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
        return _Grid(
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


@dataclass(frozen=True, eq=False)
class _Pixels:
    """Brings surfaces from any grid to pixels of the block: holds no more for it, since it lives as long as snapshots.

    `places` are those of the pixels in the window, `seen` those among the block's pixels.
    """

    levels: tuple[_Level, ...]
    places: NDArray[np.intp]
    seen: NDArray[np.intp]
    trend: Array
    frame: RGBDFrame
    block: Block

    @classmethod
    def of(
        cls,
        frame: RGBDFrame,
        block: Block,
        window: Box,
        levels: tuple[_Level, ...],
        trend: Array,
        changing: bool = False,
    ) -> _Pixels:
        """The block's pixels in a window, all or those without depth, for surfaces on grids of these levels and a trend
        on the window."""
        around = union(block.box, window)
        mask = np.zeros(tuple(side.stop - side.start for side in around), bool)
        mask[within(block.box, around)] = block.mask
        inside = mask[within(window, around)]
        among = inside & np.isnan(frame.depth[window]) if changing else inside
        places = np.flatnonzero(among)
        seen = np.flatnonzero(_seen(block, window))[among[inside]]
        return cls(levels, places, seen, trend.ravel()[places], frame, block)

    @property
    def nbytes(self) -> int:
        """Memory of what is not the frame's or the block's."""
        return self.places.nbytes + self.seen.nbytes + self.trend.nbytes

    def on(self, surface: Array) -> Array:
        """A surface on the window, at the pixels."""
        return surface.ravel()[self.places]

    def on_block(self, coarseness: int, held: Array) -> NDArray[np.float64]:
        """Depth [m] at all of the block's pixels, raw where a surface is not held: it is less the trend, and on a grid
        so many above the finest, or at the pixels."""
        u = held
        for coarser, finer in pairwise(reversed(self.levels[: coarseness + 1])):
            u = coarser.enlarged(u, finer)
        result = self.frame.depth[self.block.box][self.block.mask].astype(np.float64)
        result[self.seen] = (self.on(u) if coarseness else u) + self.trend
        return result


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


def _seen(block: Block, window: Box) -> NDArray[np.bool_]:
    """Which of a block's pixels lie in a window, in the order of `block.mask`'s True values."""
    rows, columns = (
        slice(max(a.start - b.start, 0), max(a.stop - b.start, 0)) for a, b in zip(window, block.box, strict=True)
    )
    seen = np.zeros(block.mask.shape, bool)
    seen[rows, columns] = True
    return seen[block.mask]


def _samples(values: Array) -> tuple[Array, Array]:
    """How many samples a pixel has, 1 or 0, and their sum."""
    known = np.isfinite(values)
    return known.astype(np.float32), np.where(known, values, np.float32(0))


def _root_mean(squares: float, samples: float) -> float:
    """Of so many squares; rounding may have left less than nothing of them."""
    return math.sqrt(max(squares, 0.0) / samples) if samples else math.nan
