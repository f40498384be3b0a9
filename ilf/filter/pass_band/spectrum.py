"""Spectra of a block: of its values, and the colour's, which weights the first iterations (section 3)."""

from __future__ import annotations

import cv2
import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ...stopping import check_stopped

_TOGETHER = 256
"""So many columns are transformed at a time, so that the work can be stopped in between."""


def half_spectrum(values: NDArray[np.float64], grid: tuple[int, int]) -> NDArray[np.complex128]:
    """Half spectrum (H, W // 2 + 1) of values in the first rows and columns of the padded grid, 0 elsewhere; the bits
    of `scipy.fft.rfft2`."""
    rows = scipy.fft.rfft(values, n=grid[1], axis=1)
    spectrum = np.empty((grid[0], rows.shape[1]), np.complex128)
    for first in range(0, rows.shape[1], _TOGETHER):
        check_stopped()
        columns = slice(first, first + _TOGETHER)
        spectrum[:, columns] = scipy.fft.fft(rows[:, columns], n=grid[0], axis=0)
    return spectrum


def colour_weight(
    rgb: NDArray[np.uint8], mask: NDArray[np.bool_], grid: tuple[int, int], dilation: int
) -> NDArray[np.float64]:
    """Normalised, dilated log spectrum of the grey-level block.

    As in the released code: grey levels 0-255 inside the block, zero elsewhere -> |DFT| -> log(1 + .) ->
    scaled to [0, 1] -> grey dilation with a disk. The spectrum is periodic, so the disk wraps around its rim.

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
        Weight in [0, 1], in the layout of `scipy.fft.rfft2`. All ones for a block without any light.
    """
    grey = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2GRAY).astype(np.float64)
    spectrum = np.log1p(np.abs(half_spectrum(np.where(mask, grey, 0.0), grid)))
    check_stopped()
    low, high = float(spectrum.min()), float(spectrum.max())
    if high <= low:
        return np.ones_like(spectrum)
    normalised = (spectrum - low) / (high - low)
    if dilation == 0:
        return normalised
    check_stopped()
    half = normalised.shape[1]
    offsets = np.arange(-dilation, dilation + 1)
    disk = (offsets[:, None] ** 2 + offsets[None, :] ** 2 <= dilation**2).astype(np.uint8)
    # as far as the disk reaches beyond its rim, the half's mirror image
    columns = np.arange(-dilation, half + dilation) % grid[1]
    wide = normalised[:, np.minimum(columns, grid[1] - columns)]
    beyond = columns >= half
    wide[:, beyond] = np.roll(wide[::-1, beyond], 1, axis=0)
    wrapped = np.pad(wide, ((dilation, dilation), (0, 0)), mode="wrap")
    grown = cv2.dilate(wrapped, disk)[dilation : dilation + grid[0], dilation : dilation + half]
    return np.ascontiguousarray(grown)
