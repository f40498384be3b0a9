"""ILF on one block, computed inside its pass band: the iterates of section 3 at a fraction of the cost.

With c the coefficients of P_i inside the band, M the mask of known pixels and b = DFT(M * raw), one iteration is

    c_i = G_i W (c_(i-1) + e_(i-1)),    e_i = b - DFT(M P_i) = e_(i-1) - DFT(M (P_i - P_(i-1))),

which is the paper's low-pass filtering of "raw where known, P_(i-1) elsewhere" on the padded grid. The set-up needs a
few transforms of full size; an iteration needs only two of the small grid. A sum of squares of P_i over any pixels
follows from their mask's part in twice the band, a sum of a * P_i from the coefficients, so sigma_i, the residual and
the hold-out error are those over all pixels. The paper's own loop, on the padded grid, is
`tests/reference/full_grid.py`; tests compare this one with it.
"""

from __future__ import annotations

import math
import time
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import compiled, inner
from ..._runtime.long_work import check_cancelled
from ...data.blocks import Block
from ...data.by_hand import DepthByHand
from ...data.frame import RGBDFrame
from ...data.parameters import Parameters
from ...data.results import PassBandRecord, deviation, hold_out_mask, l1_norm
from ..stepper import Snapshot, Stepper
from .band import Band, Grid, Real, colour_weight, fast_reach, half_spectrum, inside_ellipse, synthesise

Radii = tuple[float, float]

# Schedules of the cut-off radius: growth of the pass band over the iterations (section 3).
#
# The `stage` is the number of different pass bands so far, from 1; `radii` are (r_y, r_x) of the next iteration, in
# cycles per padded grid; `advance` registers an iteration, and is True at the end of the schedule.


class StagedSchedule:
    """The paper's text: iterate until steady, then enlarge the radius.

    The cut-off frequency, equal in all directions of the image, starts at `staged_start` basebands (by default
    0: the mean only, which lifts the defective area from 0 m), passes the baseband 1 / longest length and
    1 / shortest length, and rises by at most `stage_step` basebands per stage to 1 / `shortest_wavelength`, or to
    1 / shortest length if the block is narrower than that. The stages are equidistant, so the last one ends exactly
    there.

    Parameters
    ----------
    grid : tuple of int
        Padded grid (H, W).
    lengths : tuple of float
        Longest and shortest length of the block [px].
    parameters : Parameters
    """

    def __init__(self, grid: tuple[int, int], lengths: tuple[float, float], parameters: Parameters) -> None:
        longest, shortest = lengths
        self._grid = grid
        self._first = parameters.staged_start / longest
        self._last = max(1.0 / parameters.shortest_wavelength, min(1.0 / shortest, 0.5), self._first)
        self._steps = math.ceil((self._last - self._first) * longest / parameters.stage_step)
        self.stage = 1

    @property
    def radii(self) -> Radii:
        share = (self.stage - 1) / self._steps if self._steps else 0.0
        frequency = self._first + share * (self._last - self._first)
        return self._grid[0] * frequency, self._grid[1] * frequency

    def advance(self, steady: bool) -> bool:
        if steady and self.stage > self._steps:
            return True
        self.stage += steady
        return False


class LinearSchedule:
    """The released code: r = start * (H/h, W/w) + (H, W) / (wavelength * iterations) * (i - 1)."""

    def __init__(self, grid: tuple[int, int], block: tuple[int, int], parameters: Parameters) -> None:
        start = parameters.linear_start
        self._start = start * grid[0] / block[0], start * grid[1] / block[1]
        span = parameters.shortest_wavelength * parameters.max_iterations
        self._growth = grid[0] / span, grid[1] / span
        self._iterations = parameters.max_iterations
        self.stage = 1

    @property
    def radii(self) -> Radii:
        done = self.stage - 1
        return self._start[0] + self._growth[0] * done, self._start[1] + self._growth[1] * done

    def advance(self, steady: bool) -> bool:
        at_end = self.stage >= self._iterations
        self.stage += not at_end
        return at_end


# Longest and shortest length of a block, which determine the start of the pass band (section 3).


def principal_lengths(mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Compute the extent of a block along the two principal axes of its pixel coordinates.

    Parameters
    ----------
    mask : ndarray of bool, shape (h, w)
        The block's pixels; at least one.

    Returns
    -------
    longest, shortest : float
        Lengths [px]; a single pixel has length 1 in both directions.
    """
    coordinates = np.argwhere(mask).astype(np.float64)
    coordinates -= coordinates.mean(axis=0)
    _, axes = np.linalg.eigh(coordinates.T @ coordinates)
    along = coordinates @ axes
    extents = along.max(axis=0) - along.min(axis=0) + 1.0
    return float(extents.max()), float(extents.min())


# The iteration, on the small grid of the band.

_GROWTH = 1.06
"""Minimum factor by which the reach of the small grid grows when the pass band exceeds it."""

_OVERSHOOT = 2.0
"""Bound of a field in the band, relative to its largest sample: sqrt(2) per axis, at 4 r + 1 points (Ehlich and
Zeller's bound for trigonometric polynomials, 1 / cos(pi r / points))."""


class PassBandIteration(Stepper):
    """The `Stepper` of filter "ideal": every `next()` runs one iteration of one block and returns its record.

    The iterator ends when sigma_i < S_criteria and the schedule has reached its last radius, Eq. (1), or
    after `max_iterations`.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth or depth by hand.
    parameters : Parameters
    by_hand : DepthByHand, optional
        Depth by hand at the block's pixels, in the order of `block.mask`'s True values: known depth here, whatever its
        weight.
    """

    def __init__(
        self, frame: RGBDFrame, block: Block, parameters: Parameters, by_hand: DepthByHand | None = None
    ) -> None:
        self._start = time.perf_counter()
        self._parameters = parameters
        self._mask = block.mask
        height, width = block.mask.shape
        grid = math.ceil(parameters.padding * height), math.ceil(parameters.padding * width)
        self._grid = grid
        self._pixels = int(np.count_nonzero(block.mask))

        raw = frame.depth[block.box].astype(np.float64)
        known = block.mask & np.isfinite(raw)
        held_out = hold_out_mask(known, parameters.validation_share)
        taken = known & ~held_out
        if by_hand is not None:
            raw[block.mask] = np.where(by_hand.pixels, by_hand.depth, raw[block.mask])
            taken[block.mask] |= by_hand.pixels
        self._mean = float(raw[taken].mean()) if parameters.centred else 0.0
        self._known = _MaskedValues(taken, grid, raw - self._mean)
        self._held_out = _MaskedValues(held_out, grid, raw - self._mean) if held_out.any() else None
        self._ground_truth: _MaskedValues | None = None
        self._evaluated: tuple[NDArray[np.bool_], NDArray[np.float64]] | None = None
        self._block = _MaskedValues(block.mask, grid)
        self._colour: NDArray[np.float64] | None = None  # W, while i <= rgb_iterations
        self._weight: NDArray[Any] | None = None  # W on the small grid
        if parameters.rgb_iterations:
            self._colour = colour_weight(frame.edge_rgb[block.box], block.mask, grid, parameters.rgb_dilation)
        check_cancelled()
        self._schedule: StagedSchedule | LinearSchedule
        if parameters.schedule == "staged":
            self._schedule = StagedSchedule(grid, principal_lengths(block.mask), parameters)
        else:
            self._schedule = LinearSchedule(grid, (height, width), parameters)

        self._dtype = np.dtype(parameters.precision)
        self._use_band(Band(grid, (0, 0), self._dtype))
        self._coefficients = np.zeros_like(self._known.coefficients)  # of P_(i-1)
        self._error_coefficients = self._known.coefficients  # e_(i-1), the error of P_(i-1) at known pixels
        self._samples = self._band.samples(self._coefficients)  # updated for `_misfit` only
        self._lower_bound = -math.inf  # lower bound of P_i in the block, including the mean
        self._iterations = 0
        self._ended = False

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; the mean depth before i = 1."""
        return self.snapshot().surface()

    def snapshot(self) -> Snapshot:
        """The current surface: its coefficients, which later iterations do not modify."""
        coefficients = self._coefficients
        compute = partial(_on_block, coefficients, self._grid, self._mask, self._mean)
        return Snapshot(compute, coefficients.nbytes, self._mask.nbytes)

    def evaluate(self, pixels: NDArray[np.bool_], ground_truth: NDArray[np.float64]) -> None:
        """Add the error against ground truth to later records, see `Stepper`."""
        if self._dtype == np.float32:  # differences of sums of squares would be too inaccurate
            self._evaluated = pixels, ground_truth
            return
        at = np.zeros(self._mask.shape, bool)
        at[self._mask] = pixels
        values = np.zeros(self._mask.shape)
        values[at] = ground_truth - self._mean
        self._ground_truth = _MaskedValues(at, self._grid, values)
        self._ground_truth.use_band(self._band, self._dtype)
        self._samples = self._band.samples(self._coefficients)

    def __next__(self) -> PassBandRecord:
        if self._ended:
            raise StopIteration
        self._iterations += 1
        stage, radii = self._schedule.stage, self._schedule.radii
        if self._iterations > self._parameters.rgb_iterations:
            self._colour = self._weight = None
        self._enlarge_band(radii)

        band = self._band
        coefficients = self._coefficients + self._error_coefficients
        if self._weight is not None:
            coefficients *= self._weight
        np.copyto(coefficients, 0, where=self._stopped(radii))
        change = band.samples(coefficients - self._coefficients)
        part = np.empty_like(change)
        sigma = self._compare(coefficients, change, part)
        self._error_coefficients = self._error_coefficients - band.coefficients_of(part)
        # one assignment, so that another thread may read the surface during an iteration
        self._coefficients = coefficients
        residual = self._residual()
        if self._held_out is not None or self._ground_truth is not None:
            self._samples += change
        l1 = self._l1_norm()
        self._advance(sigma)
        return PassBandRecord(
            i=self._iterations,
            stage=stage,
            sigma_i=sigma,
            l1=l1,
            residual=residual,
            held_out=self._misfit(self._held_out),
            seconds=time.perf_counter() - self._start,
            error=self._error(),
            radii=radii,
            weighted=self._colour is not None,
        )

    def _use_band(self, band: Band) -> None:
        """Move everything on the small grid to the grid of a band."""
        self._band = band
        self._squared = band.squared_wave_numbers()
        self._stopping: tuple[Radii, NDArray[np.bool_]] | None = None
        if self._colour is not None:
            # complex, since otherwise the product with coefficients would convert it in chunks
            self._weight = band.cut(self._colour).astype(np.result_type(self._dtype, np.complex64))
        for values in (self._known, self._block, self._held_out, self._ground_truth):
            if values is not None:
                values.use_band(band, self._dtype)

    def _enlarge_band(self, radii: tuple[float, float]) -> None:
        """Move to a larger small grid if the pass band exceeds the present one."""
        needed = [math.floor(radius * (1 + 1e-9)) for radius in radii]
        old = self._band
        if old.holds((needed[0], needed[1])):
            return
        reach_y, reach_x = (fast_reach(math.ceil(_GROWTH * least)) for least in needed)
        band = Band(old.grid, (reach_y, reach_x), self._dtype)
        self._use_band(band)
        self._coefficients = band.moved_from(old, self._coefficients)
        self._samples = band.samples(self._coefficients)
        self._error_coefficients = self._known.coefficients - band.coefficients_of(self._known.mask * self._samples)

    def _stopped(self, radii: Radii) -> NDArray[np.bool_]:
        """The wave numbers that G_i does not pass."""
        if self._stopping is None or self._stopping[0] != radii:
            self._stopping = radii, ~inside_ellipse(self._squared, radii)
        return self._stopping[1]

    def _compare(
        self, coefficients: NDArray[np.complexfloating], change: NDArray[np.floating], part: NDArray[np.floating]
    ) -> float:
        """sigma_i, Eq. (2), from the change of P_i, whose part at known pixels is written to `part`. Also updates the
        lower bound of P_i."""
        weight = self._band.weight
        squares, low, high = (value / weight for value in _changes(change, self._block.mask, self._known.mask, part))
        if self._iterations == 1:  # P_0 is U_0, which is not in the band; `change` is from 0
            squares += self._known.squares - 2 * self._band.sum_of_product(self._known.coefficients, coefficients)
        self._lower_bound += (low + high) / 2 - _OVERSHOOT * (high - low) / 2
        return math.sqrt(max(squares, 0.0) / self._pixels)

    def _residual(self) -> float:
        """Root mean square of P_i - raw over the known pixels; sum(M P_i (raw - P_i)) follows from the coefficients."""
        known = self._known
        explained = self._band.sum_of_product(self._coefficients, known.coefficients + self._error_coefficients)
        return math.sqrt(max(known.squares - explained, 0.0) / known.pixels)

    def _error(self) -> float:
        if self._evaluated is None:
            return self._misfit(self._ground_truth)
        pixels, ground_truth = self._evaluated
        return deviation(self.surface[pixels], ground_truth)

    def _misfit(self, values: _MaskedValues | None) -> float:
        """Root mean square of P_i - values over the pixels with values; NaN if there are none."""
        band = self._band
        if values is None:
            return math.nan
        squares = inner(values.mask * self._samples, self._samples) / band.weight
        squares += values.squares - 2 * band.sum_of_product(values.coefficients, self._coefficients)
        return math.sqrt(max(squares, 0.0) / values.pixels)

    def _l1_norm(self) -> float:
        """L1 norm of P_i over the block [m]: a plain sum unless a value may be negative."""
        if self._lower_bound <= 0:
            values = self.surface
            self._lower_bound = float(values.min())
            if self._lower_bound <= 0:
                return l1_norm(values)
        return self._band.sum_of_product(self._block.coefficients, self._coefficients) + self._pixels * self._mean

    def _advance(self, sigma: float) -> None:
        """Advance the schedule and decide whether to stop."""
        self.settled = self._schedule.advance(sigma < self._parameters.s_criteria)
        stop = self.settled and self._parameters.stop_when_steady
        self._ended = stop or self._iterations >= self._parameters.max_iterations


def _changes_by_row(change: Real, block: Real, known: Real, part: Real) -> tuple[float, float, float]:
    low, high, squares = change[0].copy(), change[0].copy(), 0.0
    for y in range(change.shape[0]):
        of_row = change.dtype.type(0)
        for x in range(change.shape[1]):
            of_row += block[y, x] * change[y, x] * change[y, x]
            part[y, x] = known[y, x] * change[y, x]
        squares += float(of_row)
        for x in range(change.shape[1]):
            low[x], high[x] = min(low[x], change[y, x]), max(high[x], change[y, x])
    return squares, float(low.min()), float(high.max())


@compiled(_changes_by_row)
def _changes(change: Real, block: Real, known: Real, part: Real) -> tuple[float, float, float]:
    """Sum of squares in the block, smallest and largest value; writes those at known pixels to `part`."""
    np.multiply(block, change, out=part)
    squares = inner(part, change)
    np.multiply(known, change, out=part)
    return squares, float(change.min()), float(change.max())


def _on_block(
    coefficients: NDArray[np.complexfloating], grid: Grid, mask: NDArray[np.bool_], mean: float
) -> NDArray[np.float64]:
    """The field with these coefficients at the block's pixels, plus the mean [m]."""
    values = synthesise(grid, coefficients, *mask.shape)[mask].astype(np.float64, copy=False)
    values += mean
    return values


class _MaskedValues:
    """Values at some of the block's pixels, 0 elsewhere, represented in the band.

    Parameters
    ----------
    pixels : ndarray of bool, shape (h, w)
    grid : tuple of int
        Padded grid (H, W).
    raw : ndarray of float64, shape (h, w), optional
        An array with the values at these pixels; all are 1 if left out.
    """

    def __init__(
        self, pixels: NDArray[np.bool_], grid: tuple[int, int], raw: NDArray[np.float64] | None = None
    ) -> None:
        self._mask_spectrum = self._spectrum = half_spectrum(pixels.astype(np.float64), grid)
        self.pixels = int(np.count_nonzero(pixels))
        self.squares = float(self.pixels)
        """Sum of the values' squares."""
        if raw is not None:
            values = np.where(pixels, raw, 0.0)
            self._spectrum = half_spectrum(values, grid)
            self.squares = float(np.sum(values * values))

    def use_band(self, band: Band, dtype: np.dtype) -> None:
        """Restrict the mask and the values to a band."""
        self.mask = band.low_passed(self._mask_spectrum)
        """1 at the pixels and 0 elsewhere, at the small grid's points."""
        self.coefficients = band.cut(self._spectrum).astype(np.result_type(dtype, np.complex64), copy=False)
        """The values' part in the band."""
