"""ILF on one block with an edge-aware low-pass filter.

The iteration u <- S(raw where known, u elsewhere) with the soft low-pass S = (1 + L)^-1 has the minimum of an energy as
its fixed point (`smoothness`). Conjugate gradients reach it in far fewer steps; long waves, which would need thousands
of them, are found on a coarse grid first. So the stages are grids: the coarsest, solved directly, then finer ones up to
the pixels, and last a few rounds in which links are weakened where differences are far above the noise.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import inner
from ...data.blocks import Block
from ...data.by_hand import DepthByHand
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.parameters import Parameters
from ...data.pixel_grids import contrast, strips
from ...data.results import EdgeAwareRecord, deviation
from ...segmentation.edges.frame_edges import FrameEdges
from ..stepper import Snapshot, Stepper
from .fitted_guide import fit_guide
from .grid import Grid, Pixels, pixels_in_window
from .noise import Noise, frame_noise
from .shape import noise_of, polynomial_trend
from .smoothness import SmoothnessEnergy, Sums, Weights
from .view import NEAREST, WIDE, View

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Denoising of known depth, in the mode fill+denoise: as stiff as the noise requires, and not across jumps.
#
# Starting from the raw depth, the surface becomes stiffer from round to round. The roughness that noise can cause after
# each round is known; where the surface bends or steps by more, its links are weakened in the next. So jumps of known
# depth act as edges, in finer detail as the noise around them decreases.

_DENOISING_ROUNDS = ((5, 4), (30, 6), (200, 16), (1000, 28))
"""For every round, the factor on the bending weight of filling, and the maximum number of steps."""

_EXPLAINED = 3.0
"""Bending is more than noise above so many standard deviations of the noise left in the surface."""

_NOISY_SLOPE_JUMPS = 8.0
"""Scale at which links of first differences are weakened, relative to that of second differences."""

_FILLED = 0.1
"""Weight of filled depth, relative to a known pixel."""

_BORNE_OUT, _SQUARES = 5.0, (3, 7)
"""With a trend that explains all of the known depth, a residual is kept where its mean over squares of one of these
sides exceeds so many standard deviations of noise."""

_STEADY = 0.01
"""A round is steady if it changes depth by less than this share of its noise."""


@dataclass(frozen=True, eq=False)
class Denoising:
    """The known depth of a window and its noise.

    Attributes
    ----------
    known : ndarray of bool, shape (h, w)
    samples : ndarray of float32, shape (h, w)
        Known depth minus the trend [m]; 0 where there is none.
    deviation : ndarray of float32, shape (h, w)
        Standard deviation of its noise [m].
    grain : float
        See `Noise`.
    parameters : Parameters
    explained : bool
        Whether the trend explains all of the known depth up to its noise.
    """

    known: NDArray[np.bool_]
    samples: Array
    deviation: Array
    grain: float
    parameters: Parameters
    explained: bool

    @classmethod
    def of(
        cls,
        depth: Array,
        trend: Array,
        noise: Noise,
        parameters: Parameters,
        explained: bool,
        weights: Array | None,
    ) -> Denoising:
        """From depth [m], NaN = missing, a trend [m], which explains it or does not, and the weights of the depth."""
        known = np.isfinite(depth)
        deviation = noise.deviation(np.where(known, depth, trend))
        return cls(
            known=known,
            samples=np.where(known, depth - trend, np.float32(0)),
            deviation=deviation if weights is None else np.asarray(deviation / np.sqrt(weights), np.float32),
            grain=noise.grain,
            parameters=parameters,
            explained=explained,
        )

    def start(self, filled: Array | None) -> Array:
        """The initial surface: known depth minus the trend, filled depth elsewhere; None for the trend itself."""
        return self.samples if filled is None else np.where(self.known, self.samples, filled)

    def rounds(
        self, filled: Array | None, weights: Weights
    ) -> Iterator[tuple[Callable[[Array], SmoothnessEnergy], int]]:
        """The rounds, from the filled depth minus the trend and the weights of filling: the energy to minimise, given
        the initial surface, and the maximum number of steps."""
        counts = np.full(self.known.shape, _FILLED, np.float32)
        if self.known.any():
            usual = np.median(self.deviation[self.known])
            counts[self.known] = np.square(usual / self.deviation[self.known])
        totals = counts * self.start(filled)
        before = _DENOISING_ROUNDS[0][0]
        for times, steps in _DENOISING_ROUNDS:
            stiff = weights.bent(np.float32(times * self.grain))
            scale = None
            if self.parameters.jump_share:  # at larger differences if more smoothness is requested than noise requires
                scale = np.float32(_EXPLAINED * self.parameters.smoothness) * self._bent_by_noise(before)
            yield partial(self._energy, counts, totals, stiff, scale), steps
            before = times

    @staticmethod
    def _energy(counts: Array, totals: Array, weights: Weights, scale: Array | None, u: Array) -> SmoothnessEnergy:
        if scale is not None:
            weights.weaken(u, scale, _NOISY_SLOPE_JUMPS)
        return SmoothnessEnergy(counts, totals, weights)

    def without_noise(self, u: Array) -> Array:
        """The surface after the last round; with a trend that explains it, without what noise alone may have left."""
        if not self.explained:
            return u
        borne_out = np.zeros_like(u)
        relative = self.samples / self.deviation
        for side in _SQUARES:
            mean, share = (cv2.blur(values, (side, side)) for values in (relative, self.known.astype(np.float32)))
            pixels = share * np.float32(side * side)
            expected = np.sqrt(pixels * np.minimum(pixels, np.float32(self.grain))) / np.float32(side * side)
            np.maximum(borne_out, np.abs(mean) / np.maximum(expected, np.float32(1e-6)), out=borne_out)
        ratio = np.float32(_BORNE_OUT) / np.maximum(borne_out, np.float32(1e-6))
        return u * np.maximum(1 - ratio * ratio, 0)

    @property
    def least(self) -> float:
        """Change [m] below which a round is steady."""
        return _STEADY * float(np.median(self.deviation))

    def _bent_by_noise(self, times: float) -> Array:
        """Second differences that noise leaves in a surface that is so many times as stiff.

        For noise of power 1 and a bending weight w, the part left at frequency k is 1 / (1 + w k^4), so its variance
        is 1 / (16 w^(1/2)), and that of second differences 1 / (16 w^(3/2)).
        """
        power = self.deviation * np.float32(math.sqrt(self.grain))
        # the requested smoothness does not change what counts as a jump
        stiffness = np.float32(max(self.parameters.bending_weight * times * self.grain, 1e-6))
        return power * (stiffness**-0.75 / 4)


# Gaps at jumps among scattered samples, where the surface is a ramp: each pixel joins most of those around it.

_APART, _BETWEEN = 1.03, np.ones((5, 5), np.uint8)
"""Ratio of the farthest known depth around a pixel to the nearest above which it joins one of the two."""

_SURFACE, _BESIDE = np.ones((3, 3), np.uint8), np.ones((7, 7), np.uint8)
"""Squares that are all known are no scattered samples, nor what is this near to one: there, colour is followed."""

_JOINS, _HALO, _ROWS = 10, 8, 512
"""Number of times that pixels join those around them; rows beside others that matter, and rows searched together."""


@once_per_frame
def scattered_gaps(frame: RGBDFrame) -> Mask:
    """Find missing pixels among scattered samples with a jump around, bool (H, W)."""
    found = np.zeros(frame.shape, bool)
    for rows, wider, middle in strips(len(found), _HALO, _ROWS):
        depth = frame.depth[wider]
        known = np.isfinite(depth)
        dense = cv2.dilate(cv2.morphologyEx(known.view(np.uint8), cv2.MORPH_OPEN, _SURFACE), _BESIDE)
        gaps = ~known & (dense == 0)
        if gaps.any():
            found[rows] = (gaps & (contrast(depth, known, _BETWEEN) > _APART))[middle]
    return found


def joined(surface: Array, changed: Mask) -> Array:
    """Replace some pixels, none of them in the first or last row or column, by medians of the four around, repeatedly.

    The median is the mean of the middle two: the surface of most of them, or the middle where they are tied. On a plane
    it changes nothing.

    Parameters
    ----------
    surface : ndarray of float32, shape (H, W)
    changed : ndarray of bool, shape (H, W)
    """
    values, places, row = surface.flatten(), np.flatnonzero(changed), surface.shape[1]
    around = [places + step for step in (-row, -1, 1, row)]
    for _ in range(_JOINS):
        above, left, right, below = (values[there] for there in around)
        lower = np.maximum(np.minimum(above, below), np.minimum(left, right))
        upper = np.minimum(np.maximum(above, below), np.maximum(left, right))
        values[places] = np.float32(0.5) * (lower + upper)
    return values.reshape(surface.shape)


# The iteration: grids from the coarsest to the finest, then rounds that weaken links at jumps or remove noise.

_Step = tuple[Grid, Array, Sums]
"""The grid, the surface on it, and the sums of the step."""

_DIRECT_CELLS = 2000
"""Maximum number of cells of the coarsest grid."""

_HALVINGS = 2
"""Minimum number of halvings from the finest to the coarsest grid."""

_STEPS, _FINEST_STEPS = 40, 20
"""Maximum number of conjugate-gradient steps on every grid between the coarsest and the finest, and on the finest."""

_BEFORE_ROUNDS = 8
"""The same on the finest if denoising rounds follow."""

_ROUNDS, _ROUND_STEPS = 2, 8
"""Number of rounds that weaken links at jumps, and maximum number of steps in each."""

_CARRIED_STEPS = 10
"""Maximum number of steps on the finest grid from carried depth, which shows where links are to be weakened."""

_SLOPE_JUMPS = 4.0
"""Scale at which links of first differences are weakened, relative to that of second differences."""

_OUT_OF_RANGE = (
    "Depth is missing beyond the sensor range, from {:.1f} m on: it is extrapolated there, unsupported by measurements."
)

_NOT_STEADY = (
    "Stopped at the limit of steps before it was steady: further steps usually change depth by less than its expected "
    "error."
)
"""Remark if the last stage was not steady at its end."""

_LEVELLING = 1e-9
"""Weight of the trend where there is no data, relative to the largest of all weights: keeps corners that are cut off by
edges from being singular."""


class EdgeAwareIteration(Stepper):
    """The `Stepper` of filter "edge-aware": every `next()` runs one iteration of one block and returns its record.

    Works on a window around the block's missing pixels (around all of its pixels in the mode fill+denoise). Known
    depth in the window is used whatever block it is in, as far as the edges between permit; for the block's pixels
    outside the window, P_i is their raw depth. sigma_i and the L1 norm are those of the stage's grid. So are residual
    and hold-out error: they compare a surface that is constant in every cell, apart from the trend, with the depth of
    single pixels, so on coarse grids they include the variation inside cells. The residual covers all known depth in
    the window; the hold-out, pixels of the block in it. Edges, flying pixels and noise are those of the frame, found
    with all of its depth; so is the guide, which replaces the trend as far as it is believed: its shape and jumps are
    kept, and the difference of the known depth from it is filtered.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth, unless a guide suffices.
    parameters : Parameters
        With filter "edge-aware".
    edges : FrameEdges
        The frame's edges.
    drawn : ndarray of bool, optional
        The block's pixels, in the order of `block.mask`'s True values, whose border was drawn by hand: no depth from
        beyond it is used there.
    by_hand : DepthByHand, optional
        Depth by hand at the block's missing pixels, in the same order: samples with its weight.
    carried : ndarray of float32, shape (H, W), optional
        Depth [m] expected from the previous frame of a sequence, NaN = none: the iteration starts from its details, and
        where depth is missing, it is followed with a small weight.
    """

    def __init__(
        self,
        frame: RGBDFrame,
        block: Block,
        parameters: Parameters,
        edges: FrameEdges,
        drawn: NDArray[np.bool_] | None = None,
        by_hand: DepthByHand | None = None,
        carried: Array | None = None,
    ) -> None:
        self._start = time.perf_counter()
        self._evaluated: tuple[Pixels, NDArray[np.float64]] | None = None
        self._frame, self._block, self._parameters = frame, block, parameters
        view = View(frame, block, parameters, drawn, by_hand, carried)
        self._window, self._gap = view.window, view.gap
        guide = None if frame.guide is None else fit_guide(frame)
        depth = view.mean_depth(guide)
        noise = parameters.noise or noise_of(view.depth, view.mask)
        shaped = parameters.trend and view.gap >= WIDE and not view.is_carried
        found = None if parameters.mode == "fill" else self._noise(frame)
        # depth by hand is not part of what noise explains: the gaps must be filled
        measured_only = by_hand is None
        fits = found is not None and parameters.trend and measured_only
        explained = polynomial_trend(view.raw, view.mask, found) if found is not None and fits else None
        if explained is not None:
            trend, stiffness, follows = explained[view.place], 1.0, True
        else:
            trend, stiffness, follows = view.trend(depth, noise, shaped)
        if guide is not None:
            trend = view.guided(trend, guide)
        self._denoising = None
        if found is not None:
            self.explained = follows and measured_only
            self._denoising = Denoising.of(view.raw[view.place], trend, found, parameters, self.explained, view.weights)
        self._least = parameters.s_criteria
        self._finest_steps = _FINEST_STEPS if self._denoising is None else _BEFORE_ROUNDS
        self._continues = view.is_carried
        weights = parameters.smoothness * stiffness
        self._slope, self._bending = weights * parameters.slope_weight, weights * parameters.bending_weight
        self._levelling = np.float32(_LEVELLING * max(1.0, self._slope, self._bending))
        self._jump = max(noise, parameters.jump_share * max(depth, NEAREST)) if parameters.jump_share else math.inf

        self._limits = view.limits(trend)
        self._finest = finest = view.grid(np.ascontiguousarray(trend), edges, parameters)
        # of samples of weight w: w times the square, as their total is w times their depth
        self._known_squares = inner(finest.totals, finest.start)
        self._held_out_squares = inner(finest.held_out[1], finest.held_out[1]) if finest.held_out else 0.0
        grids = [finest]
        while len(grids) <= _HALVINGS or grids[-1].counts.size > _DIRECT_CELLS:
            grids.append(grids[-1].halved())
        self._levels = tuple(grid.level for grid in grids)
        self._coarser = grids[1:]
        self._current = finest, np.zeros(finest.counts.shape, np.float32)
        raw = frame.depth[block.box][block.mask]
        # all known: the window contains the gaps
        self._outside = float(raw[~pixels_in_window(block, view.window)].sum(dtype=np.float64))
        self._pixels = raw.size
        self._iterations = 0
        self._stage = self._round = 0
        self._sigma = math.inf
        self._steps = self._run()
        self.network = edges.network
        self.notes = edges.notes
        if found is not None and not parameters.noise:
            self.notes += (found.note,)
        if view.beyond is not None:
            self.notes += (_OUT_OF_RANGE.format(view.beyond.limit),)

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; the trend before i = 1."""
        return self._held(self._all).surface()

    @cached_property
    def _all(self) -> Pixels:
        """All of the block's pixels in the window; computed on demand, since they need much memory."""
        return self._chosen(np.ones(self._pixels, bool))

    @cached_property
    def _changing(self) -> Pixels:
        """Those of them that may change; computed on demand, since only previews use them."""
        if self._parameters.mode != "fill":
            return self._all
        return self._chosen(~self._frame.own[self._block.box][self._block.mask])

    def _chosen(self, pixels: NDArray[np.bool_]) -> Pixels:
        """Some of the block's pixels, in the order of `block.mask`'s True values."""
        return Pixels(self._frame, self._block, self._window, self._levels, self._finest.trend, self._limits, pixels)

    def snapshot(self) -> Snapshot:
        """The current surface where it may become depth; raw depth at other pixels.

        It is stored on the grid of its iteration, on the finest only where needed, which saves memory and time.
        """
        return self._held(self._changing)

    def _held(self, pixels: Pixels) -> Snapshot:
        grid, u = self._current
        held = u.copy() if grid.coarseness else pixels.on(u)  # u is a view of an array with other iterations
        return Snapshot(partial(pixels.on_block, grid.coarseness, held), held.nbytes, pixels.nbytes)

    def evaluate(self, pixels: NDArray[np.bool_], ground_truth: NDArray[np.float64]) -> None:
        """Add the error against ground truth to later records, see `Stepper`."""
        self._evaluated = self._chosen(pixels), ground_truth

    def _error(self) -> float:
        if self._evaluated is None:
            return math.nan
        pixels, ground_truth = self._evaluated
        grid, u = self._current
        return deviation(pixels.depth(grid.coarseness, u if grid.coarseness else pixels.on(u)), ground_truth)

    def __next__(self) -> EdgeAwareRecord:
        if self._iterations >= self._parameters.max_iterations:
            raise StopIteration
        grid, u, sums = next(self._steps)
        self._iterations += 1
        self._sigma = math.sqrt(sums.changes / self._pixels)
        # one assignment, so that another thread may read the surface during an iteration
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

    def _held_out(self, grid: Grid, u: Array) -> float:
        if grid.held_out is None:
            return math.nan
        counts, totals = grid.held_out
        squares = inner(counts * u - 2 * totals, u) + self._held_out_squares
        return _root_mean(squares, float(counts.sum(dtype=np.float64)))

    def _run(self) -> Iterator[_Step]:
        """All stages: for every iteration its grid, P_i on it minus the trend, and the sums of the step."""
        if self._denoising is None:
            u = yield from self._fill()
            if math.isfinite(self._jump):
                self._current = self._finest, self._joined(u)
        else:
            yield from self._denoise(self._finest, self._denoising)
        self.settled = True
        if not self._sigma < self._least:
            self.remark = _NOT_STEADY

    def _fill(self) -> Generator[_Step, None, Array]:
        """From the coarsest grid to the finest, and there the rounds that weaken links at jumps.

        Grids are released after use, and the weights of the finest grid reuse one array: for windows as large as the
        frame, they are most of a run's memory.
        """
        finest, grid = self._finest, self._coarser.pop()
        self._stage = 1
        u = self._energy(grid, self._weights(grid)).minimum()
        yield grid, u, grid.sums(u, grid.start)
        while grid is not finest:
            level, grid = grid.level, self._coarser.pop() if self._coarser else finest
            limit = self._finest_steps if grid is finest else _STEPS
            weights = self._weights(grid)
            start = grid.started(level.enlarged(u, grid.level), u)
            if grid is finest and self._continues and math.isfinite(self._jump):
                weights.weaken(start, np.full(start.shape, self._jump, np.float32), _SLOPE_JUMPS)
                return (yield from self._descend(grid, self._energy(grid, weights), start, _CARRIED_STEPS))
            u = yield from self._descend(grid, self._energy(grid, weights), start, limit)
        if math.isfinite(self._jump) and self._denoising is None:
            for self._round in range(1, _ROUNDS + 1):
                weights = self._weights(finest, weights)
                weights.weaken(u, np.full(u.shape, self._jump, np.float32), _SLOPE_JUMPS)
                u = yield from self._descend(finest, self._energy(finest, weights), u, _ROUND_STEPS)
        return u

    def _joined(self, u: Array) -> Array:
        """The surface with gaps among scattered samples joined to one side of a jump, but not across drawn borders."""
        grid = self._finest
        own = cv2.dilate(grid.inside, _SURFACE) > 0
        changed = scattered_gaps(self._frame)[self._window] & own & (grid.counts == 0)
        if grid.cut_links is not None:
            changed &= grid.cut_links.uncut
        changed[[0, -1]] = changed[:, [0, -1]] = False
        return joined(u + grid.trend, changed) - grid.trend if changed.any() else u

    def _denoise(self, grid: Grid, known: Denoising) -> Iterator[_Step]:
        """Fill the gaps first, unless the trend already explains all known depth, then run the denoising rounds."""
        filled = None
        stiffer = self._parameters.smoothness > 1
        if stiffer or (self._gap > 0 and not known.explained):
            filled = yield from self._fill()
        parameters = self._parameters
        slope, bending = (parameters.smoothness * w for w in (parameters.slope_weight, parameters.bending_weight))
        self._least = min(self._least, known.least)
        # if more smoothness is requested than noise requires, start from the smooth surface
        u = filled if stiffer and filled is not None else known.start(filled)
        weights = grid.weights(slope, bending)
        for self._round, (energy, steps) in enumerate(known.rounds(filled, weights), 1):
            u = yield from self._descend(grid, energy(u), u, steps)
        if known.explained or not self._iterations:
            without_noise = known.without_noise(u)
            yield grid, without_noise, grid.sums(without_noise, u)

    def _noise(self, frame: RGBDFrame) -> Noise:
        return Noise(self._parameters.noise) if self._parameters.noise else frame_noise(frame)

    def _descend(self, grid: Grid, energy: SmoothnessEnergy, u: Array, limit: int) -> Generator[_Step, None, Array]:
        """One stage: until steady, or up to `limit` steps."""
        self._stage += 1
        inputs, steady = (grid.inside, grid.trend, grid.counts, grid.totals), self._pixels * self._least**2
        steps = energy.descend(u, inputs, steady, min(limit, self._parameters.max_iterations - self._iterations))
        for u, sums in steps:
            yield grid, u, sums
        return u

    def _energy(self, grid: Grid, weights: Weights) -> SmoothnessEnergy:
        counts, totals = grid.counts + self._levelling, grid.totals
        if grid.carried is not None:
            counts, totals = counts + grid.carried[0], totals + grid.carried[1]
        return SmoothnessEnergy(counts, totals, weights)

    def _weights(self, grid: Grid, out: Weights | None = None) -> Weights:
        # on cells of c pixels, the sum of squared slopes stays the same, that of bending is c^2 times as large
        return grid.weights(self._slope, self._bending / grid.cell**2, out)


def _root_mean(squares: float, samples: float) -> float:
    """Root mean square from a sum of squares, which rounding may have made negative."""
    return math.sqrt(max(squares, 0.0) / samples) if samples else math.nan
