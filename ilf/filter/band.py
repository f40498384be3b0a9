"""The pass band as a space of its own: transforms between its coefficients and a small grid.

A field P on the padded grid (H, W) whose spectrum lies inside |k_y| <= r_y, |k_x| <= r_x is known exactly from its
samples on a grid of (4 r_y + 1) x (4 r_x + 1) points, and so is the part inside the band of any product m * P, if m
is first cut down to |k| <= 2 r. All that the iteration does happens on this small grid.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

Grid = tuple[int, int]
Real = NDArray[np.floating]
Complex = NDArray[np.complexfloating]


class Band:
    """Coefficients of real fields with |k_y| <= r_y, |k_x| <= r_x, and the small grid that carries them.

    Coefficients are those of the unnormalised transform over the padded grid, as an array of shape
    (rows of the small grid, r_x + 1): k_y in the order of an FFT, k_x >= 0 alone, since fields are real.

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
        self.shape = _carrier(self.reach[0], grid[0]), _carrier(self.reach[1], grid[1])
        self._dtype = dtype
        self._columns = self.reach[1] + 1
        self.weight = grid[0] * grid[1] / (self.shape[0] * self.shape[1])
        """Pixels of the padded grid per sample of the small one."""

    def holds(self, reach: tuple[int, int]) -> bool:
        """Whether wave numbers up to these, or all that there are, lie in the band."""
        return all(
            wanted <= own or own == size // 2 for wanted, own, size in zip(reach, self.reach, self.grid, strict=True)
        )

    @property
    def coefficient_shape(self) -> tuple[int, int]:
        """Shape of an array of coefficients."""
        return self.shape[0], self._columns

    def samples(self, coefficients: Complex) -> Real:
        """The field at the small grid's points, times `weight`: the scale cancels in `coefficients_of`."""
        columns = scipy.fft.ifft(coefficients, axis=0)
        return scipy.fft.irfft(columns, n=self.shape[1], axis=1, overwrite_x=True)

    def coefficients_of(self, samples: Real) -> Complex:
        """Inverse of `samples`; what lies outside |k_x| <= r_x is dropped, what lies outside r_y is not."""
        rows = scipy.fft.rfft(samples, axis=1, overwrite_x=True)
        return scipy.fft.fft(rows[:, : self._columns], axis=0)

    def cut(self, spectrum: NDArray[Any]) -> NDArray[Any]:
        """The band's part of a half spectrum of the padded grid, or of a weight of its shape (H, W // 2 + 1)."""
        found = np.zeros(self.coefficient_shape, spectrum.dtype)
        _copy_rows(spectrum[:, : self._columns], found, self.reach[0])
        return found

    def low_passed(self, spectrum: Complex) -> Real:
        """A field of the padded grid, cut down to twice the band, at the small grid's points.

        Parameters
        ----------
        spectrum : ndarray of complex, shape (H, W // 2 + 1)
            Its half spectrum.
        """
        reach_y, reach_x = 2 * self.reach[0], 2 * self.reach[1]
        columns = spectrum.shape[1] if self.shape[1] == self.grid[1] else reach_x + 1
        cut = np.zeros((self.shape[0], self.shape[1] // 2 + 1), spectrum.dtype)
        _copy_rows(spectrum[:, :columns], cut[:, :columns], reach_y)
        field = scipy.fft.irfft2(cut, s=self.shape) / self.weight
        return field.astype(self._dtype, copy=False)

    def moved_from(self, other: Band, coefficients: Complex) -> Complex:
        """Coefficients of a smaller band, in this one."""
        moved = np.zeros(self.coefficient_shape, coefficients.dtype)
        _copy_rows(coefficients, moved[:, : coefficients.shape[1]], other.reach[0])
        return moved

    def synthesise(self, coefficients: Complex, height: int, width: int) -> Real:
        """The field on the first rows and columns of the padded grid, float (height, width)."""
        tall = np.zeros((self.grid[0], self._columns), coefficients.dtype)
        _copy_rows(coefficients, tall, self.reach[0])
        columns = scipy.fft.ifft(tall, axis=0, overwrite_x=True)[:height]
        return scipy.fft.irfft(columns, n=self.grid[1], axis=1)[:, :width]

    def squared_wave_numbers(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """k_y^2 as a column and k_x^2 as a row, in the layout of the coefficients."""
        rows = np.arange(self.shape[0])
        k_y = np.minimum(rows, self.shape[0] - rows).astype(np.float64)
        k_x = np.arange(self._columns, dtype=np.float64)
        return (k_y**2)[:, None], (k_x**2)[None, :]


def _carrier(reach: int, full: int) -> int:
    """Points per axis that carry a band of this reach: the next fast length, or the whole grid."""
    fast = int(scipy.fft.next_fast_len(4 * reach + 1, real=True))
    return min(fast, full)


def _copy_rows(source: NDArray[Any], target: NDArray[Any], reach: int) -> None:
    """Copy the rows of |k_y| <= reach between arrays in the order of an FFT; all of them if they are as high."""
    if source.shape[0] == target.shape[0]:
        target[:] = source
        return
    target[: reach + 1] = source[: reach + 1]
    if reach:
        target[-reach:] = source[-reach:]
