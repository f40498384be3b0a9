"""ILF on one block, inside its pass band: the iterates of section 3 at a fraction of the cost.

With c the coefficients of P_i inside the band, M the mask of known pixels and b = DFT(M * raw), one iteration is

    c_i = G_i W (b + c_(i-1) - DFT(M P_(i-1))),

which is the paper's low-pass filtering of "raw where known, P_(i-1) elsewhere" on the padded grid. Two transforms of
full size set a block up; an iteration needs two of the small grid alone. The paper's own loop, on the padded grid, is
`tests/reference/full_grid.py`; tests hold this one to it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..blocks import Block
from ..frame import RGBDFrame
from ..parameters import Parameters
from .band import Band
from .convergence import IterationRecord, l1_norm
from .lengths import principal_lengths
from .lowpass import inside_ellipse
from .schedule import LinearSchedule, Schedule, StagedSchedule
from .spectrum import colour_weight

_GROWTH = 1.1
"""By how much the reach of the small grid grows when the pass band has outgrown it."""

_OVERSHOOT = 2.0
"""A field of the band is nowhere larger than this times its largest sample: sqrt(2) per axis, at 4 r + 1 points
(Ehlich and Zeller's bound for trigonometric polynomials, 1 / cos(pi r / points))."""


class BlockIteration(Iterator[IterationRecord]):
    """The stepper: every `next()` is one iteration of one block and gives its record.

    The iterator ends when sigma_i < S_criteria and the schedule has reached its last radius, Eq. (1), or
    after `max_iterations`.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth.
    parameters : Parameters
    """

    def __init__(self, frame: RGBDFrame, block: Block, parameters: Parameters) -> None:
        self._start = time.perf_counter()
        self._parameters = parameters
        self._mask = block.mask
        height, width = block.mask.shape
        grid = math.ceil(parameters.padding * height), math.ceil(parameters.padding * width)
        self._pixels = int(np.count_nonzero(block.mask))

        raw = frame.depth[block.box].astype(np.float64)
        known = block.mask & np.isfinite(raw)
        self._mean = float(raw[known].mean()) if parameters.centred else 0.0
        raw = np.where(known, raw - self._mean, 0.0)
        self._raw_squares = float(np.sum(raw * raw))
        self._spectra = {
            "raw": scipy.fft.rfft2(raw, s=grid),
            "unknown": scipy.fft.rfft2(_outside(known, grid)),
            "block": scipy.fft.rfft2(block.mask.astype(np.float64), s=grid),
        }
        self._colour: NDArray[np.float64] | None = None  # W, while i <= rgb_iterations
        self._weight: NDArray[Any] | None = None  # its part on the small grid
        if parameters.rgb_iterations:
            self._colour = colour_weight(frame.rgb[block.box], block.mask, grid, parameters.rgb_dilation)
        self._schedule: Schedule
        if parameters.schedule == "staged":
            self._schedule = StagedSchedule(grid, principal_lengths(block.mask), parameters)
        else:
            self._schedule = LinearSchedule(grid, (height, width), parameters)

        self._dtype = np.dtype(parameters.precision)
        self._use_band(Band(grid, (0, 0), self._dtype))
        self._coefficients = np.zeros(self._band.coefficient_shape, self._raw.dtype)  # of P_(i-1)
        self._samples = self._band.samples(self._coefficients)
        # one assignment, so that another thread may look at the surface while an iteration is under way
        self._current = self._band, self._coefficients
        self._sum = 0.0  # of P_i over the block, without the mean
        self._least = -math.inf  # no value of P_i in the block, with the mean, is below this
        self._iterations = 0
        self.settled = False
        """Whether the last iteration was the schedule's end: steady at the last radius, or the last of a linear one."""
        self._ended = False

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; the mean depth before i = 1."""
        band, coefficients = self._current
        field = band.synthesise(coefficients, *self._mask.shape)
        return field[self._mask].astype(np.float64) + self._mean

    def __next__(self) -> IterationRecord:
        if self._ended:
            raise StopIteration
        self._iterations += 1
        stage, radii = self._schedule.stage, self._schedule.radii
        if self._iterations > self._parameters.rgb_iterations:
            self._colour = self._weight = None
        self._make_room(radii)

        band = self._band
        coefficients = band.coefficients_of(self._unknown * self._samples)
        coefficients += self._raw
        coefficients *= self._filter(radii)
        samples = band.samples(coefficients)
        sigma = self._compare(samples)
        self._coefficients, self._samples = coefficients, samples
        self._current = band, coefficients
        l1 = self._l1_norm()
        self._note(sigma)
        return IterationRecord(
            i=self._iterations,
            stage=stage,
            radii=radii,
            sigma_i=sigma,
            l1=l1,
            weighted=self._colour is not None,
            seconds=time.perf_counter() - self._start,
        )

    def _use_band(self, band: Band) -> None:
        """Bring everything that lives on the small grid to a band's."""
        self._band = band
        self._raw = band.cut(self._spectra["raw"]).astype(_complex(self._dtype), copy=False)
        self._unknown = band.low_passed(self._spectra["unknown"])
        self._block = band.low_passed(self._spectra["block"])
        self._squared = band.squared_wave_numbers()
        if self._colour is not None:
            self._weight = band.cut(self._colour).astype(self._dtype, copy=False)

    def _make_room(self, radii: tuple[float, float]) -> None:
        """Move to a larger small grid if the pass band has outgrown the present one."""
        needed = math.floor(radii[0] * (1 + 1e-9)), math.floor(radii[1] * (1 + 1e-9))
        old = self._band
        if old.holds(needed):
            return
        band = Band(old.grid, (_roomier(needed[0]), _roomier(needed[1])), self._dtype)
        self._use_band(band)
        self._coefficients = band.moved_from(old, self._coefficients)
        self._samples = band.samples(self._coefficients)

    def _filter(self, radii: tuple[float, float]) -> NDArray[np.floating]:
        """G_i, times W while it is on."""
        inside = inside_ellipse(self._squared, radii).astype(self._dtype)
        return inside if self._weight is None else self._weight * inside

    def _compare(self, samples: NDArray[np.floating]) -> float:
        """sigma_i, Eq. (2), by sums over the small grid. Keeps the sum of P_i and its lower bound up to date."""
        weight = self._band.weight
        if self._iterations == 1:  # P_0 is U_0, which is not in the band
            raw = self._band.low_passed(self._spectra["raw"])
            here = self._block * samples
            squares = float(np.sum(here * samples)) / weight
            squares += self._raw_squares - 2 * float(np.sum(raw * samples))
            self._sum, self._least = float(np.sum(here, dtype=np.float64)), -math.inf
        else:
            change = samples - self._samples
            here = self._block * change
            squares = float(np.einsum("yx,yx", here, change)) / weight
            self._sum += float(np.sum(here, dtype=np.float64))
            low, high = float(change.min()) / weight, float(change.max()) / weight
            self._least += (low + high) / 2 - _OVERSHOOT * (high - low) / 2
        return math.sqrt(max(squares, 0.0) / self._pixels)

    def _l1_norm(self) -> float:
        """L1 norm of P_i over the block [m]: a plain sum as long as no value can be negative."""
        if self._least <= 0:
            values = self.surface
            self._least = float(values.min())
            if self._least <= 0:
                return l1_norm(values)
        return self._sum + self._pixels * self._mean

    def _note(self, sigma: float) -> None:
        """Decide whether to stop, and let the schedule go on."""
        self.settled = self._schedule.advance(sigma < self._parameters.s_criteria)
        stop = self.settled and self._parameters.stop_when_steady
        self._ended = stop or self._iterations >= self._parameters.max_iterations


def _outside(known: NDArray[np.bool_], grid: tuple[int, int]) -> NDArray[np.float64]:
    """1 on the padded grid, 0 where depth is known."""
    unknown = np.ones(grid)
    unknown[: known.shape[0], : known.shape[1]][known] = 0.0
    return unknown


def _roomier(reach: int) -> int:
    return max(math.ceil(_GROWTH * reach), reach + 2)


def _complex(dtype: np.dtype) -> np.dtype:
    return np.result_type(dtype, np.complex64)
