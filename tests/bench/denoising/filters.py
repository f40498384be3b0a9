"""Filters that denoise dense depth, with which the presets are compared; each gets the noise's standard deviation.

Of several settings, those with the lowest errors over the bench's scenes under another seed were taken.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from ilf.evaluation.bench.methods import roughness

Depth = NDArray[np.float64]

_SIDE = 5
"""Side of the median filter's window [px]."""

_RANGE, _SPACE = 3.0, 3.0
"""Deviations of the bilateral filter: in depth, in deviations of the noise, and in the image [px]."""

_EPSILON, _RADIUS = 16.0, 3
"""The guided filter's regularisation, in variances of the noise, and the radius of its window [px]."""

_TV_WEIGHT = 4.0
"""Weight of total variation for noise of deviation 1."""

_PATCH, _SEARCH, _LIKENESS = 7, 11, 1.2
"""Patch size and search distance of non-local means [px], and its filter strength in deviations of the noise."""


def median(depth: Depth, noise: float) -> Depth:
    """Median filter; ignores the noise."""
    return cv2.medianBlur(depth.astype(np.float32), _SIDE).astype(np.float64)


def bilateral(depth: Depth, noise: float) -> Depth:
    """Tomasi and Manduchi, "Bilateral filtering for gray and color images", 1998."""
    return cv2.bilateralFilter(depth.astype(np.float32), -1, _RANGE * noise, _SPACE).astype(np.float64)


def guided(depth: Depth, noise: float) -> Depth:
    """He, Sun and Tang, "Guided image filtering", 2013, with the depth as its own guide."""

    def mean(values: Depth) -> Depth:
        return np.asarray(cv2.blur(values, (2 * _RADIUS + 1,) * 2), np.float64)

    level = mean(depth)
    variance = mean(depth * depth) - level * level
    gain = variance / (variance + _EPSILON * noise**2)
    return mean(gain) * depth + mean(level - gain * level)


def total_variation(depth: Depth, noise: float) -> Depth:
    """Chambolle, "An algorithm for total variation minimization and applications", 2004."""
    from skimage.restoration import denoise_tv_chambolle

    return np.asarray(denoise_tv_chambolle(depth / noise, weight=_TV_WEIGHT, max_num_iter=300, eps=2e-5) * noise)


def nonlocal_means(depth: Depth, noise: float) -> Depth:
    """Buades, Coll and Morel, "A non-local algorithm for image denoising", 2005."""
    from skimage.restoration import denoise_nl_means

    scaled = denoise_nl_means(
        depth / noise, patch_size=_PATCH, patch_distance=_SEARCH, h=_LIKENESS, sigma=1.0, fast_mode=True
    )
    return np.asarray(scaled * noise)


def dct_pls(depth: Depth, noise: float) -> Depth:
    """Garcia's penalised least squares by cosine transforms, 2010; the residual is made to match the noise."""
    bending, spectrum = roughness(depth.shape), dctn(depth, norm="ortho")
    low, high = -6.0, 9.0
    while high - low > 0.01:
        middle = (low + high) / 2
        left = 1 - 1 / (1 + 10**middle * bending)
        too_stiff = np.mean((spectrum * left) ** 2) > noise**2 * left.mean()
        low, high = (low, middle) if too_stiff else (middle, high)
    return np.asarray(idctn(spectrum / (1 + 10**low * bending), norm="ortho"))


DENOISERS: dict[str, Callable[[Depth, float], Depth]] = {
    "median": median,
    "bilateral": bilateral,
    "guided": guided,
    "total-variation": total_variation,
    "nonlocal-means": nonlocal_means,
    "dct-pls": dct_pls,
}
"""Name -> filter of dense depth [m], shape (H, W), given the true standard deviation of its noise [m]."""
