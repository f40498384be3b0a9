"""The pass band: transforms between its coefficients and a small grid.

A field P on the padded grid (H, W) whose spectrum lies inside |k_y| <= r_y, |k_x| <= r_x is determined exactly by its
samples on a grid of (4 r_y + 1) x (4 r_x + 1) points, and so is the part inside the band of any product m * P, if m
is first limited to |k| <= 2 r. The iteration is computed on this small grid.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..._runtime.long_work import check_cancelled
from ...data.pixel_grids import strips

Grid = tuple[int, int]
Real = NDArray[np.floating]
Complex = NDArray[np.complexfloating]

_STRIP = 32
"""Number of rows synthesised at a time: few enough to fit into the processor's cache at padded width."""


class Band:
    """Coefficients of real fields with |k_y| <= r_y, |k_x| <= r_x, and the small grid of their samples.

    Coefficients are those of the unnormalised transform over the padded grid, as an array of shape
    (r_x + 1, rows of the small grid): only k_x >= 0, since fields are real, and k_y in the order of an FFT, so that a
    transform along y needs neither copying nor padding. A field's are 0 beyond |k_y| = r_y. Not thread-safe: internal
    buffers are used.

    Parameters
    ----------
    grid : tuple of int
        Padded grid (H, W).
    reach : tuple of int
        Largest wave numbers (r_y, r_x).
    dtype : numpy dtype
        float64 or float32: precision of the fields.
    """

    def __init__(self, grid: Grid, reach: tuple[int, int], dtype: np.dtype) -> None:
        self.grid = grid
        self.reach = min(reach[0], grid[0] // 2), min(reach[1], grid[1] // 2)
        self.shape = _propagator(self.reach[0], grid[0]), _propagator(self.reach[1], grid[1])
        self.coefficient_shape = self.reach[1] + 1, self.shape[0]
        """Shape of an array of coefficients."""
        self.weight = grid[0] * grid[1] / (self.shape[0] * self.shape[1])
        """Pixels of the padded grid per sample of the small one."""
        self._dtype = dtype
        self._times = np.full(self.reach[1] + 1, 2.0)  # also for -k_x
        self._times[0] = 1
        if 2 * self.reach[1] == grid[1]:
            self._times[-1] = 1
        # always 0 beyond the band
        along_x = np.zeros((self.shape[0], self.shape[1] // 2 + 1), np.result_type(dtype, np.complex64))
        self._in_band = along_x[:, : self.reach[1] + 1]
        # as OpenCV packs transforms of real rows: without the imaginary part of k_x = 0, and the real one in its place
        self._packed = along_x.view(dtype)[:, 1 : self.shape[1] + 1]

    def holds(self, reach: tuple[int, int]) -> bool:
        """Whether wave numbers up to these, limited to those of the grid, lie in the band."""
        return all(
            wanted <= own or own == size // 2 for wanted, own, size in zip(reach, self.reach, self.grid, strict=True)
        )

    def samples(self, coefficients: Complex) -> Real:
        """The field at the small grid's points, times `weight`; the scale cancels in `coefficients_of`."""
        self._in_band[:] = _transformed(coefficients, inverse=True).T
        self._packed[:, 0] = self._in_band[:, 0].real
        way = cv2.DFT_ROWS | cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
        found: Real = cv2.dft(self._packed, flags=way)  # type: ignore[assignment]
        return found

    def coefficients_of(self, samples: Real) -> Complex:
        """Inverse of `samples`; not 0 beyond |k_y| = r_y, where the samples do not determine a field's."""
        used = 2 * self.reach[1] + 1
        self._in_band[:, -1] = 0  # the grid's last wave number is real
        self._packed[:, :used] = cv2.dft(samples, flags=cv2.DFT_ROWS)[:, :used]
        columns = np.ascontiguousarray(self._in_band.T)
        columns[0] = self._packed[:, 0]
        return _transformed(columns, inverse=False)

    def cut(self, spectrum: NDArray[Any]) -> NDArray[Any]:
        """The band's part of a half spectrum of the padded grid, or of a weight of its shape (H, W // 2 + 1)."""
        found = np.zeros(self.coefficient_shape, spectrum.dtype)
        _copy_rows(spectrum[:, : self.reach[1] + 1], found.T, self.reach[0])
        return found

    def sum_of_product(self, a: Complex, b: Complex) -> float:
        """Sum of a * b over the padded grid, for two fields given by their coefficients."""
        by_wave_number = np.vecdot(a.view(self._dtype), b.view(self._dtype))
        return float(self._times @ by_wave_number) / (self.grid[0] * self.grid[1])

    def low_passed(self, spectrum: Complex) -> Real:
        """A field of the padded grid, limited to twice the band, at the small grid's points.

        Parameters
        ----------
        spectrum : ndarray of complex, shape (H, W // 2 + 1)
            Half spectrum of the field.
        """
        reach_y, reach_x = 2 * self.reach[0], 2 * self.reach[1]
        columns = spectrum.shape[1] if self.shape[1] == self.grid[1] else reach_x + 1
        cut = np.zeros((self.shape[0], self.shape[1] // 2 + 1), spectrum.dtype)
        _copy_rows(spectrum[:, :columns], cut[:, :columns], reach_y)
        field = scipy.fft.irfft2(cut, s=self.shape, overwrite_x=True)
        field /= self.weight
        return field.astype(self._dtype, copy=False)

    def moved_from(self, other: Band, coefficients: Complex) -> Complex:
        """Convert coefficients of a smaller band to this one."""
        moved = np.zeros(self.coefficient_shape, coefficients.dtype)
        _copy_rows(coefficients.T, moved[: len(coefficients)].T, other.reach[0])
        return moved

    def squared_wave_numbers(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """k_y^2 as a row and k_x^2 as a column, in the layout of the coefficients."""
        columns, height = self.coefficient_shape
        rows = np.arange(height)
        k_y = np.minimum(rows, height - rows).astype(np.float64)
        k_x = np.arange(columns, dtype=np.float64)
        return (k_y**2)[None, :], (k_x**2)[:, None]


def synthesise(grid: Grid, coefficients: Complex, height: int, width: int) -> Real:
    """The field with these coefficients on the first rows and columns of the padded grid, float (height, width)."""
    columns_held, rows_held = coefficients.shape
    tall = np.zeros((grid[0], columns_held), coefficients.dtype)
    _copy_rows(coefficients.T, tall, (rows_held - 1) // 2)
    columns = scipy.fft.ifft(tall, axis=0, overwrite_x=True)
    field = np.empty((height, width), coefficients.real.dtype)
    for rows, *_ in strips(height, rows=_STRIP):
        field[rows] = scipy.fft.irfft(columns[rows], n=grid[1], axis=1)[:, :width]
    return field


def fast_reach(least: int) -> int:
    """The largest reach with the same fast transform length as `least`."""
    return int(scipy.fft.next_fast_len(least + 1, real=True)) - 1


def _propagator(reach: int, full: int) -> int:
    """Number of points per axis for a band of this reach: at least 4 r + 1, or the whole grid.

    Four times a fast length: factors of 4 are faster than 3 and 5.
    """
    return min(4 * (fast_reach(reach) + 1), full)


def _transformed(rows: Complex, inverse: bool) -> Complex:
    """Transform of every row. OpenCV's takes half as long as SciPy's in float64, but twice as long in float32."""
    if rows.dtype == np.complex64:
        return scipy.fft.ifft(rows) if inverse else scipy.fft.fft(rows)
    flags = cv2.DFT_ROWS | (cv2.DFT_INVERSE | cv2.DFT_SCALE if inverse else 0)
    pairs = rows.view(rows.real.dtype).reshape(*rows.shape, 2)
    return cv2.dft(pairs, flags=flags).view(rows.dtype)[..., 0]


def _copy_rows(source: NDArray[Any], target: NDArray[Any], reach: int) -> None:
    """Copy the rows of |k_y| <= reach into an array with more rows, or all if the numbers are equal."""
    if source.shape[0] == target.shape[0]:
        target[:] = source
        return
    target[: reach + 1] = source[: reach + 1]
    if reach:
        target[-reach:] = source[-reach:]


# G_i: the ideal elliptical low-pass filter on the half spectrum of a real transform.

_ROUNDING = 1e-9


def inside_ellipse(
    squared: tuple[NDArray[np.float64], NDArray[np.float64]], radii: tuple[float, float]
) -> NDArray[np.bool_]:
    """Pass band (k_y / r_y)^2 + (k_x / r_x)^2 <= 1, bool (H, W // 2 + 1).

    Wave numbers on the rim are inside, whatever the rounding of the radii. A radius of 0 passes only k = 0 in that
    direction.
    """
    rows, columns = (
        k2 / radius**2 if radius > 0 else np.where(k2 > 0, np.inf, 0.0)
        for k2, radius in zip(squared, radii, strict=True)
    )
    return rows + columns <= 1.0 + _ROUNDING


# Spectra of a block: of its values, and of its colour as the weight of the first iterations (section 3).

_TOGETHER = 256
"""Number of columns transformed at a time; cancellation is checked in between."""


def half_spectrum(values: NDArray[np.float64], grid: tuple[int, int]) -> NDArray[np.complex128]:
    """Half spectrum (H, W // 2 + 1) of values in the first rows and columns of the padded grid, 0 elsewhere; equal bit
    by bit to `scipy.fft.rfft2`."""
    rows = scipy.fft.rfft(values, n=grid[1], axis=1)
    spectrum = np.empty((grid[0], rows.shape[1]), np.complex128)
    for first in range(0, rows.shape[1], _TOGETHER):
        check_cancelled()
        columns = slice(first, first + _TOGETHER)
        spectrum[:, columns] = scipy.fft.fft(rows[:, columns], n=grid[0], axis=0)
    return spectrum


def colour_weight(
    rgb: NDArray[np.uint8], mask: NDArray[np.bool_], grid: tuple[int, int], dilation: int
) -> NDArray[np.float64]:
    """Compute the normalised, dilated log spectrum of the grey-level block.

    As in the released code: grey levels 0-255 inside the block, zero elsewhere -> |DFT| -> log(1 + .) ->
    scaled to [0, 1] -> grey dilation with a disk. The spectrum is periodic, so the disk wraps around.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (h, w, 3)
        Colour of the block's bounding box.
    mask : ndarray of bool, shape (h, w)
        The block's pixels.
    grid : tuple of int
        Padded grid (H, W).
    dilation : int
        Radius of the disk in samples of the spectrum.

    Returns
    -------
    ndarray of float64, shape (H, W // 2 + 1)
        Weight in [0, 1], in the layout of `scipy.fft.rfft2`. All ones for a uniformly black block.
    """
    grey = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2GRAY).astype(np.float64)
    spectrum = np.log1p(np.abs(half_spectrum(np.where(mask, grey, 0.0), grid)))
    check_cancelled()
    low, high = float(spectrum.min()), float(spectrum.max())
    if high <= low:
        return np.ones_like(spectrum)
    normalised = (spectrum - low) / (high - low)
    if dilation == 0:
        return normalised
    check_cancelled()
    half = normalised.shape[1]
    offsets = np.arange(-dilation, dilation + 1)
    disk = (offsets[:, None] ** 2 + offsets[None, :] ** 2 <= dilation**2).astype(np.uint8)
    # beyond the rim of the half spectrum, its mirror image, as far as the disk reaches
    columns = np.arange(-dilation, half + dilation) % grid[1]
    wide = normalised[:, np.minimum(columns, grid[1] - columns)]
    beyond = columns >= half
    wide[:, beyond] = np.roll(wide[::-1, beyond], 1, axis=0)
    wrapped = np.pad(wide, ((dilation, dilation), (0, 0)), mode="wrap")
    grown = cv2.dilate(wrapped, disk)[dilation : dilation + grid[0], dilation : dilation + half]
    return np.ascontiguousarray(grown)
