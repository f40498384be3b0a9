"""The weighted spectrum: the colour block's spectrum, which weights the first iterations (section 3)."""

from __future__ import annotations

import cv2
import numpy as np
import scipy.fft
from numpy.typing import NDArray


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
    spectrum = np.log1p(np.abs(scipy.fft.fft2(np.where(mask, grey, 0.0), s=grid)))
    low, high = float(spectrum.min()), float(spectrum.max())
    half = grid[1] // 2 + 1
    if high <= low:
        return np.ones((grid[0], half))
    normalised = (spectrum - low) / (high - low)
    if dilation == 0:
        return normalised[:, :half]
    offsets = np.arange(-dilation, dilation + 1)
    disk = (offsets[:, None] ** 2 + offsets[None, :] ** 2 <= dilation**2).astype(np.uint8)
    wrapped = np.pad(normalised, dilation, mode="wrap")
    grown = cv2.dilate(wrapped, disk)[dilation : dilation + grid[0], dilation : dilation + half]
    return np.ascontiguousarray(grown)
