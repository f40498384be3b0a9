"""ILF on one block, as the paper has it: the reference that the library's iteration is held to."""

import math
import time
from collections.abc import Iterator

import numpy as np
import scipy.fft
from numpy.typing import NDArray

import ilf
from ilf.completion.pass_band.band import colour_weight, inside_ellipse
from ilf.completion.pass_band.iteration import LinearSchedule, StagedSchedule, principal_lengths
from ilf.data.blocks import Block
from ilf.data.results import PassBandRecord, deviation, hold_out_mask, l1_norm


class FullGridIteration(Iterator[PassBandRecord]):
    """The stepper: every `next()` is one iteration of one block and gives its record.

        U_0 = raw depth matrix                                (0 where unknown)
        F_i = G_i * DFT(U_(i-1)) [* W while i <= rgb_iterations]
        P_i = IDFT(F_i)
        U_i = raw where known, P_i elsewhere

    The iterator ends when sigma_i < S_criteria and the schedule has reached its last radius, Eq. (1), or
    after `max_iterations`.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth.
    parameters : Parameters
    """

    def __init__(self, frame: ilf.RGBDFrame, block: Block, parameters: ilf.Parameters) -> None:
        self._start = time.perf_counter()
        self._parameters = parameters
        self._mask = block.mask
        height, width = block.mask.shape
        self._crop = slice(0, height), slice(0, width)
        grid = math.ceil(parameters.padding * height), math.ceil(parameters.padding * width)

        raw = frame.depth[block.box].astype(np.float64)
        known = block.mask & np.isfinite(raw)
        self._held_out = hold_out_mask(known, parameters.validation_share)
        self._known = known & ~self._held_out
        self._mean = float(raw[self._known].mean()) if parameters.centred else 0.0
        self._raw, self._held_out_raw = raw[self._known] - self._mean, raw[self._held_out] - self._mean

        self._weight: NDArray[np.float64] | None = None  # W, while i <= rgb_iterations
        if parameters.rgb_iterations:
            self._weight = colour_weight(frame.rgb[block.box], block.mask, grid, parameters.rgb_dilation)
        self._schedule: StagedSchedule | LinearSchedule
        if parameters.schedule == "staged":
            self._schedule = StagedSchedule(grid, principal_lengths(block.mask), parameters)
        else:
            self._schedule = LinearSchedule(grid, (height, width), parameters)
        self._wave_numbers = squared_wave_numbers(grid)
        self._band: NDArray[np.bool_] | None = None
        self._band_radii: tuple[float, float] | None = None

        self._expanded = np.zeros(grid)  # U_0; later P_i, then U_i, in place
        self._reinsert()
        self._values = self._expanded[self._crop][self._mask]
        self._iterations = 0
        self.settled = False
        """Whether the last iteration was the schedule's end: steady at the last radius, or the last of a linear one."""
        self._ended = False

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values."""
        return self._values + self._mean

    def __next__(self) -> PassBandRecord:
        if self._ended:
            raise StopIteration
        self._iterations += 1
        stage, radii = self._schedule.stage, self._schedule.radii
        if self._iterations > self._parameters.rgb_iterations:
            self._weight = None

        spectrum = scipy.fft.rfft2(self._expanded)
        spectrum *= self._pass_band(radii)
        if self._weight is not None:
            spectrum *= self._weight
        self._expanded = scipy.fft.irfft2(spectrum, s=self._expanded.shape, overwrite_x=True)

        surface = self._expanded[self._crop]
        values = surface[self._mask]
        residual = deviation(surface[self._known], self._raw)
        held_out = math.nan
        if self._held_out.any():
            held_out = deviation(surface[self._held_out], self._held_out_raw)
        sigma = deviation(values, self._values)
        self._values = values
        self._reinsert()
        self._note(sigma)
        return PassBandRecord(
            i=self._iterations,
            stage=stage,
            radii=radii,
            sigma_i=sigma,
            l1=l1_norm(values + self._mean),
            residual=residual,
            held_out=held_out,
            weighted=self._weight is not None,
            seconds=time.perf_counter() - self._start,
        )

    def _note(self, sigma: float) -> None:
        """Decide whether to stop, and let the schedule go on."""
        self.settled = self._schedule.advance(sigma < self._parameters.s_criteria)
        stop = self.settled and self._parameters.stop_when_steady
        self._ended = stop or self._iterations >= self._parameters.max_iterations

    def _pass_band(self, radii: tuple[float, float]) -> NDArray[np.bool_]:
        if self._band is None or radii != self._band_radii:
            self._band, self._band_radii = inside_ellipse(self._wave_numbers, radii), radii
        return self._band

    def _reinsert(self) -> None:
        self._expanded[self._crop][self._known] = self._raw


def squared_wave_numbers(grid: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """k_y^2 as a column and k_x^2 as a row, in the layout of `scipy.fft.rfft2` over a grid (H, W)."""
    height, width = grid
    k_y = np.minimum(np.arange(height), height - np.arange(height)).astype(np.float64)
    k_x = np.arange(width // 2 + 1, dtype=np.float64)
    return (k_y**2)[:, None], (k_x**2)[None, :]
