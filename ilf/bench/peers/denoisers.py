"""Filters that take noise off dense depth, each told how strong the noise is."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

Depth = NDArray[np.float64]

_SIDE = 5
"""Of the median's squares [px]."""

_RANGE, _SPACE = 3.0, 3.0
"""The bilateral filter's deviations: of depth, in those of the noise, and in the image [px]."""

_EPSILON, _RADIUS = 16.0, 3
"""The guided filter's variance that counts as flat, in that of the noise, and the radius of its squares [px]."""

_TV_WEIGHT = 4.0
"""Of total variation, where the noise's deviation is 1."""

_PATCH, _SEARCH, _LIKENESS = 7, 11, 1.2
"""Side of the patches of non-local means, how far off they are searched [px], and how alike they must be, in
deviations of noise."""


def median(depth: Depth, noise: float) -> Depth:
    """Median over squares; the noise plays no part."""
    return cv2.medianBlur(depth.astype(np.float32), _SIDE).astype(np.float64)


def bilateral(depth: Depth, noise: float) -> Depth:
    """Tomasi and Manduchi, "Bilateral filtering for gray and color images", 1998."""
    return cv2.bilateralFilter(depth.astype(np.float32), -1, _RANGE * noise, _SPACE).astype(np.float64)


def guided(depth: Depth, noise: float) -> Depth:
    """He, Sun and Tang, "Guided image filtering", 2013, the depth its own guide."""

    def mean(values: Depth) -> Depth:
        return np.asarray(cv2.blur(values, (2 * _RADIUS + 1,) * 2), np.float64)

    level = mean(depth)
    variance = mean(depth * depth) - level * level
    gain = variance / (variance + _EPSILON * noise**2)
    return mean(gain) * depth + mean(level - gain * level)


def total_variation(depth: Depth, noise: float) -> Depth:
    """Chambolle, "An algorithm for total variation minimization and applications", 2004."""
    from skimage.restoration import denoise_tv_chambolle  # takes long to load

    return np.asarray(denoise_tv_chambolle(depth / noise, weight=_TV_WEIGHT, max_num_iter=300, eps=2e-5) * noise)


def nonlocal_means(depth: Depth, noise: float) -> Depth:
    """Buades, Coll and Morel, "A non-local algorithm for image denoising", 2005."""
    from skimage.restoration import denoise_nl_means

    scaled = denoise_nl_means(
        depth / noise, patch_size=_PATCH, patch_distance=_SEARCH, h=_LIKENESS, sigma=1.0, fast_mode=True
    )
    return np.asarray(scaled * noise)


def dct_pls(depth: Depth, noise: float) -> Depth:
    """Garcia's penalised least squares by cosine transforms, 2010, as stiff as leaves residuals of the noise's size."""
    along = [2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in depth.shape]
    roughness = (along[0][:, None] + along[1][None, :]) ** 2
    spectrum = dctn(depth, norm="ortho")
    low, high = -6.0, 9.0
    while high - low > 0.01:
        middle = (low + high) / 2
        left = 1 - 1 / (1 + 10**middle * roughness)
        too_stiff = np.mean((spectrum * left) ** 2) > noise**2 * left.mean()
        low, high = (low, middle) if too_stiff else (middle, high)
    return np.asarray(idctn(spectrum / (1 + 10**low * roughness), norm="ortho"))


DENOISERS: dict[str, Callable[[Depth, float], Depth]] = {
    "median": median,
    "bilateral": bilateral,
    "guided": guided,
    "total-variation": total_variation,
    "nonlocal-means": nonlocal_means,
    "dct-pls": dct_pls,
}
"""Name -> filter of dense depth [m], shape (H, W), told its noise's true standard deviation [m]. Of several settings
those are taken that had the lowest errors over the bench's scenes, under another seed."""
