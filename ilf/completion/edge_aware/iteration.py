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

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import inner
from ...data.blocks import Block
from ...data.frame import RGBDFrame
from ...data.parameters import Parameters
from ...data.results import EdgeAwareRecord, deviation
from ...segmentation.edges.frame_edges import FrameEdges
from ..stepper import Snapshot
from .fitted_guide import fit_guide
from .grid import Grid, Pixels, seen_in
from .kernels import Sums
from .noise import Noise, frame_noise
from .shape import noise_of, polynomial_trend
from .smoothness import SmoothnessEnergy, Told, Weights, make_weights
from .view import NEAREST, WIDE, View

Array = NDArray[np.float32]

# Taking noise off known depth, in the mode fill+denoise: as stiff as the noise calls for, and over no jump.
#
# From the raw depth on, the surface is made stiffer from round to round. How rough noise can make it after each is
# known; where it bends or steps by more than that, it lets go in the next. So jumps of known depth are edges, and
# show in ever finer detail as the noise around them goes down.

_DENOISING_ROUNDS = ((5, 4), (30, 6), (200, 16), (1000, 28))
"""In every round, how many times more bending weighs than it does to fill, and the steps, at most."""

_EXPLAINED = 3.0
"""A surface bends by more than noise explains at so many deviations of what the noise leaves of itself there."""

_NOISY_SLOPE_JUMPS = 8.0
"""First differences let go at so many times the second difference that does."""

_FILLED = 0.1
"""What missing depth has been filled with counts so much, a known pixel being 1."""

_BORNE_OUT, _SQUARES = 5.0, (3, 7)
"""Beside a trend that explains all of the known depth, what is left stays where its mean over squares of one of these
sides is so many deviations of noise."""

_STEADY = 0.01
"""A round is steady if it changes depth by less than this share of its noise."""


@dataclass(frozen=True, eq=False)
class Denoising:
    """The known depth of a window, and how noisy it is.

    Attributes
    ----------
    known : ndarray of bool, shape (h, w)
    samples : ndarray of float32, shape (h, w)
        Known depth less the trend [m]; 0 where there is none.
    deviation : ndarray of float32, shape (h, w)
        Standard deviation of its noise [m].
    grain : float
        As `Noise` has it.
    bending : float
        Weight of bending that the rounds' are multiples of.
    smoothness : float
        Factor on all weights.
    lets_go : bool
        Whether the surface lets go anywhere.
    explained : bool
        Whether the trend explains all of the known depth, up to its noise.
    """

    known: NDArray[np.bool_]
    samples: Array
    deviation: Array
    grain: float
    bending: float
    smoothness: float
    lets_go: bool
    explained: bool

    @classmethod
    def of(cls, depth: Array, trend: Array, noise: Noise, parameters: Parameters, explained: bool) -> Denoising:
        """Of depth [m], NaN = missing, and a trend [m], which explains it or does not."""
        known = np.isfinite(depth)
        return cls(
            known=known,
            samples=np.where(known, depth - trend, np.float32(0)),
            deviation=noise.deviation(np.where(known, depth, trend)),
            grain=noise.grain,
            bending=parameters.bending_weight,
            smoothness=parameters.smoothness,
            lets_go=parameters.jump_share > 0,
            explained=explained,
        )

    def start(self, filled: Array | None) -> Array:
        """The known depth less the trend, and where it is missing what it has been filled with; None is the trend."""
        return self.samples if filled is None else np.where(self.known, self.samples, filled)

    def rounds(self, filled: Array | None, weights: Weights) -> Iterator[Round]:
        """The rounds, from what missing depth has been filled with, less the trend, and the weights of filling."""
        counts = np.full(self.known.shape, _FILLED, np.float32)
        if self.known.any():
            usual = np.median(self.deviation[self.known])
            counts[self.known] = np.square(usual / self.deviation[self.known])
        totals = counts * self.start(filled)
        before = _DENOISING_ROUNDS[0][0]
        for times, steps in _DENOISING_ROUNDS:
            stiff = weights.bent(np.float32(times * self.grain))
            scale = None
            if self.lets_go:  # later where more smoothness is asked for than noise calls for
                scale = np.float32(_EXPLAINED * self.smoothness) * self._bent_by_noise(before)
            yield Round(counts, totals, stiff, scale, steps)
            before = times

    def cleared(self, u: Array) -> Array:
        """The surface after the last round, beside a trend that explains it less what noise alone may have left."""
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
        """Second differences that noise leaves in a surface so many times as stiff against bending.

        Noise whose power is one over a surface that weights w make stiff: with frequencies k, what is left of it is
        1 / (1 + w k^4), so its variance is 1 / (16 w^(1/2)), that of second differences 1 / (16 w^(3/2)).
        """
        power = self.deviation * np.float32(math.sqrt(self.grain))
        # weights that are asked to be larger or smaller do not change what counts as a jump
        stiffness = np.float32(max(self.bending * times * self.grain, 1e-6))
        return power * (stiffness**-0.75 / 4)


@dataclass(frozen=True, eq=False)
class Round:
    """One round: samples, weights of its own, where they let go if they do, and steps at most."""

    counts: Array
    totals: Array
    weights: Weights
    scale: Array | None
    steps: int

    def energy(self, u: Array) -> SmoothnessEnergy:
        """What the round minimises, from the surface at its start; once."""
        if self.scale is not None:
            self.weights.loosen(u, self.scale, _NOISY_SLOPE_JUMPS)
        return SmoothnessEnergy(self.counts, self.totals, self.weights)


# The iteration: grids from the coarsest to the finest, then rounds in which jumps let go or noise is taken off.

_Step = tuple[Grid, Array, Sums]
"""The grid, the surface on it, and what there is to tell of the step."""

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
        view = View(frame, block, parameters, drawn)
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
        self._jump = max(noise, parameters.jump_share * max(depth, NEAREST)) if parameters.jump_share else math.inf

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
        self._outside = float(raw[~seen_in(block, view.window)].sum(dtype=np.float64))
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
    def _all(self) -> Pixels:
        """All of the block's pixels in the window; only found where someone looks, since they take much memory."""
        return self._pixels_of()

    def _pixels_of(self, changing: bool = False) -> Pixels:
        """The block's pixels in the window, all or those without depth."""
        return Pixels.of(self._frame, self._block, self._window, self._levels, self._finest.trend, changing)

    def snapshot(self) -> Snapshot:
        """The surface as it stands, where it may become depth; at other pixels, raw depth.

        It is held on the grid of its iteration, of the finest just what is needed: it costs time, too, to fill memory.
        """
        return self._held(self._changing)

    def _held(self, pixels: Pixels) -> Snapshot:
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
        return "Step limit reached in the last stage."

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

    def _held_out(self, grid: Grid, u: Array) -> float:
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

    def _denoise(self, grid: Grid, known: Denoising) -> Iterator[_Step]:
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

    def _descend(self, grid: Grid, energy: SmoothnessEnergy, u: Array, limit: int) -> Generator[_Step, None, Array]:
        """One stage: until steady, or so many steps."""
        self._stage += 1
        told = Told(grid.inside, grid.trend, grid.counts, grid.totals, self._pixels * self._least**2)
        steps = energy.descend(u, told, min(limit, self._parameters.max_iterations - self._iterations))
        for u, sums in steps:
            yield grid, u, sums
        return u

    def _energy(self, grid: Grid, weights: Weights) -> SmoothnessEnergy:
        return SmoothnessEnergy(grid.counts + self._levelling, grid.totals, weights)

    def _weights(self, grid: Grid, out: Weights | None = None) -> Weights:
        # of a surface on cells of c pixels, slopes add up to the same, bending to c^2 times as much
        smooth = grid.smooth(self._parameters.edge_scale)
        return make_weights(*smooth, self._slope, self._bending / grid.cell**2, grid.stiff, out)


def _root_mean(squares: float, samples: float) -> float:
    """Of so many squares; rounding may have left less than nothing of them."""
    return math.sqrt(max(squares, 0.0) / samples) if samples else math.nan
