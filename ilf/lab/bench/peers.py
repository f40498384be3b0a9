"""Classical methods of depth completion that the presets are compared with."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from scipy.sparse import csc_array, csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from ...completion.interpolation import nearest
from ...data.blocks import find_blocks
from ...data.frame import RGBDFrame
from ...errors import InputError

# Morphology on inverted depth.

_DIAMOND = np.array([[0, 0, 1, 0, 0], [0, 1, 1, 1, 0], [1, 1, 1, 1, 1], [0, 1, 1, 1, 0], [0, 0, 1, 0, 0]], np.uint8)
_CLOSING, _SMALL_HOLES, _LARGE_HOLES = (np.ones((side, side), np.uint8) for side in (5, 7, 31))
_BLUR = (5, 5)
_TINY = np.finfo(np.float32).tiny


def morphology(frame: RGBDFrame) -> NDArray[np.float32]:
    """The steps of Ku, Harakeh and Waslander, "In defense of classical image processing", 2018 (IP-Basic).

    Depth is inverted, so that dilation favours near depth; then follow a dilation by a diamond, a closing, filling of
    small and large holes, a median and a Gaussian blur. Holes wider than the largest element stay missing.
    """
    # any value beyond the farthest depth works, as long as no known pixel becomes 0, which means empty
    beyond = np.float32(np.nanmax(frame.depth) + 1.0)
    inverted = np.where(frame.known, beyond - frame.depth, np.float32(0.0))
    inverted = cv2.dilate(inverted, _DIAMOND)
    inverted = cv2.morphologyEx(inverted, cv2.MORPH_CLOSE, _CLOSING)
    for element in (_SMALL_HOLES, _LARGE_HOLES):
        inverted = np.where(inverted > 0, inverted, cv2.dilate(inverted, element))
    inverted = np.where(inverted > 0, cv2.medianBlur(inverted, 5), inverted)
    # empty pixels are excluded from the blur
    filled = (inverted > 0).astype(np.float32)
    blurred = cv2.GaussianBlur(inverted, _BLUR, 0) / np.maximum(cv2.GaussianBlur(filled, _BLUR, 0), _TINY)
    return np.where(filled > 0, beyond - blurred, np.float32(np.nan))


# OpenCV's inpainting, on depth in whole millimetres, because it needs 16-bit images.

_RADIUS = 3.0
_UNITS = 1000.0
_DEEPEST = 65_535


def navier_stokes(frame: RGBDFrame) -> NDArray[np.float32]:
    """Bertalmio, Bertozzi and Sapiro, "Navier-Stokes, fluid dynamics, and image and video inpainting", 2001."""
    return _inpainted(frame, cv2.INPAINT_NS)


def telea(frame: RGBDFrame) -> NDArray[np.float32]:
    """Telea, "An image inpainting technique based on the fast marching method", 2004."""
    return _inpainted(frame, cv2.INPAINT_TELEA)


def _inpainted(frame: RGBDFrame, method: int) -> NDArray[np.float32]:
    millimetres = np.nan_to_num(frame.depth.astype(np.float64)) * _UNITS
    image = np.clip(np.rint(millimetres), 0, _DEEPEST).astype(np.uint16)
    filled = cv2.inpaint(image, (~frame.known).astype(np.uint8), _RADIUS, method)
    return np.where(filled > 0, filled / np.float32(_UNITS), np.float32(np.nan))


# A second-order polynomial in every block.


def polynomial(frame: RGBDFrame, labels: NDArray[np.int32]) -> NDArray[np.float64]:
    """Least-squares polynomial of order 2 in row and column through the known pixels of each block.

    Pixels outside all blocks, pixels that the polynomial puts behind the camera, and blocks whose known pixels do not
    determine its six coefficients stay missing.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
        Label map, 0 = no block.
    """
    depth = frame.depth.astype(np.float64)
    for block in find_blocks(labels).values():
        raw = depth[block.box]
        known, missing = block.mask & np.isfinite(raw), block.mask & np.isnan(raw)
        # positions in [-1, 1] keep the six terms about equally large
        y, x = (2 * (index + 0.5) / size - 1 for index, size in zip(np.indices(raw.shape), raw.shape, strict=True))
        terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
        coefficients, _, rank, _ = np.linalg.lstsq(terms[known], raw[known])
        if rank == terms.shape[-1]:
            surface = terms[missing] @ coefficients
            raw[missing] = np.where(surface > 0, surface, np.nan)
    return depth


# Penalised least squares by cosine transforms.

_STRENGTHS = np.logspace(3, -6, 100)
_OVER_RELAXATION = 2.0


def dct_smoothing(frame: RGBDFrame) -> NDArray[np.float64]:
    """Garcia, "Robust smoothing of gridded data in one and higher dimensions with missing values", 2010.

    In its form for gaps in reliable data (Wang, Garcia et al., "A three-dimensional gap filling method for large
    geophysical datasets", 2012), with the strengths, number of steps and relaxation of the authors' program: the
    smoothness weakens from step to step, and known depth is restored after each. Smoothing once with the strength
    from cross-validation gave larger errors, in gaps of both kinds.
    """
    known = frame.known
    surface = nearest(frame).astype(np.float64)
    data = surface[known]
    roughness = _roughness(frame.shape)
    for strength in _STRENGTHS:
        smooth = idctn(dctn(surface, norm="ortho") / (1 + strength * roughness), norm="ortho")
        surface += _OVER_RELAXATION * (smooth - surface)
        surface[known] = data
    return np.where(surface > 0, surface, np.nan)


def _roughness(shape: tuple[int, int]) -> NDArray[np.float64]:
    """Squared eigenvalues of the Laplacian, of the shape of the transform."""
    rows, columns = (2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in shape)
    return (rows[:, None] + columns[None, :]) ** 2


# Sparse linear systems of pixels.

MAX_UNKNOWNS = 3_000_000
"""Larger systems are refused: at this size the factors of a thin plate need about 12 GB."""


def stencil(shape: tuple[int, int], offsets: dict[tuple[int, int], float]) -> csr_array:
    """Matrix of a weighted sum of pixels around each place, for all places where these pixels lie in the image.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the image.
    offsets : dict
        (row, column) >= 0 from the place -> weight.

    Returns
    -------
    csr_array of float64, shape (places, H * W)
    """
    height = shape[0] - max(row for row, _ in offsets)
    width = shape[1] - max(column for _, column in offsets)
    if height <= 0 or width <= 0:
        return csr_array((0, shape[0] * shape[1]), dtype=np.float64)
    pixel = np.arange(shape[0] * shape[1]).reshape(shape)
    columns = [pixel[row : row + height, column : column + width].ravel() for row, column in offsets]
    count = height * width
    return csr_array(
        (np.repeat(list(offsets.values()), count), (np.tile(np.arange(count), len(offsets)), np.concatenate(columns))),
        shape=(count, pixel.size),
    )


def solve(matrix: csc_array, right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a system whose pattern is symmetric and whose diagonal dominates or is that of a positive matrix.

    Raises
    ------
    InputError
        If it is too large to be solved directly.
    """
    if right.size > MAX_UNKNOWNS:
        raise InputError(
            f"{right.size:,} unknown pixels are too many for a direct solver (maximum {MAX_UNKNOWNS:,}). Use another "
            "method, or smaller frames."
        )
    # without pivoting, the ordering for symmetric patterns keeps the factors ten times as sparse
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return factors.solve(right)


# With too few or collinear known pixels the bending energy does not determine the plate's tilt; this weight of the
# first differences' energy does, and has no visible effect elsewhere.
_LEVELLING = 1e-8

# of 0, 0.1, 1, 10 and 100 this had the smallest error in large areas of eight frames; for dense samples 0 is better
_STIFFNESS = 10.0


def laplace(frame: RGBDFrame) -> NDArray[np.float64]:
    """The harmonic surface: minimises squared first differences, keeps known pixels."""
    return _minimise_energy(frame.depth.astype(np.float64), _first_differences(frame.shape))


def thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate: minimises squared second differences, keeps known pixels."""
    depth = frame.depth.astype(np.float64)
    plane = _plane_through(depth)
    surface = plane + _minimise_energy(depth - plane, _bending(frame.shape))
    return np.where(surface > 0, surface, np.nan)


def soft_thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate as a Gaussian Markov random field: it smooths the known pixels instead of passing through them.

    Noise at the rims of large holes then tilts it less. It minimises the squared misfit of the known pixels plus
    `_STIFFNESS` times the squared second differences.
    """
    depth = frame.depth.astype(np.float64)
    plane = _plane_through(depth)
    bending = _bending(frame.shape)
    known = diags_array(frame.known.ravel().astype(np.float64))
    misfit = np.nan_to_num(depth - plane).ravel()
    surface = plane + solve((_STIFFNESS * (bending.T @ bending) + known).tocsc(), misfit).reshape(frame.shape)
    return np.where(surface > 0, surface, np.nan)


def _bending(shape: tuple[int, int]) -> csr_array:
    return vstack([
        stencil(shape, {(0, 0): 1.0, (0, 1): -2.0, (0, 2): 1.0}),
        stencil(shape, {(0, 0): 1.0, (1, 0): -2.0, (2, 0): 1.0}),
        math.sqrt(2) * stencil(shape, {(0, 0): 1.0, (1, 1): 1.0, (1, 0): -1.0, (0, 1): -1.0}),
        math.sqrt(_LEVELLING) * _first_differences(shape),
    ], format="csr")  # fmt: skip


def _first_differences(shape: tuple[int, int]) -> csr_array:
    across = stencil(shape, {(0, 0): -1.0, (0, 1): 1.0})
    return vstack([across, stencil(shape, {(0, 0): -1.0, (1, 0): 1.0})], format="csr")


def _minimise_energy(depth: NDArray[np.float64], differences: csr_array) -> NDArray[np.float64]:
    """Replace NaN in `depth` so that the sum of squares of `differences @ depth` is minimal."""
    missing = np.isnan(depth).ravel()
    if not missing.any():
        return depth
    by_pixel = differences.tocsc()
    free, fixed = by_pixel[:, missing], by_pixel[:, ~missing]
    values = depth.ravel().copy()
    values[missing] = solve((free.T @ free).tocsc(), -(free.T @ (fixed @ values[~missing])))
    return values.reshape(depth.shape)


def _plane_through(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least-squares plane of the known pixels, level where they do not determine its tilt."""
    places = np.argwhere(np.isfinite(depth)).astype(np.float64)
    centre = places.mean(axis=0)
    values = depth[np.isfinite(depth)]
    slope = np.linalg.lstsq(places - centre, values - values.mean())[0]
    rows, columns = np.indices(depth.shape)
    return values.mean() + slope[0] * (rows - centre[0]) + slope[1] * (columns - centre[1])


# Colourisation: pixels of similar colour have similar depth.

_NEIGHBOURS = tuple((row, column) for row in (0, 1, 2) for column in (0, 1, 2) if (row, column) != (1, 1))
_VARIANCE_SHARE = 0.6
_MIN_WEIGHT = 0.01
_MIN_VARIANCE = 2e-6


def colourisation(frame: RGBDFrame) -> NDArray[np.float64]:
    """Levin, Lischinski and Weiss, "Colorization using optimization", 2004, as the NYU Depth toolbox uses it on depth.

    Each pixel is the mean of its 3x3 neighbours, weighted by similarity of grey level relative to the window's
    variance; known depth is a soft constraint of weight 1 (alpha).
    """
    weights = _affinities(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float64) / 255.0)
    known = frame.known.ravel()
    pixel = np.arange(known.size).reshape(frame.shape)
    around = _shifted(np.pad(pixel, 1, mode="edge"), frame.shape)
    present = weights > 0
    entries = np.concatenate([-weights[present], 1.0 + known])
    rows = np.concatenate([np.broadcast_to(pixel, weights.shape)[present], pixel.ravel()])
    columns = np.concatenate([around[present], pixel.ravel()])
    matrix = csc_array((entries, (rows, columns)), shape=(known.size, known.size))
    return solve(matrix, np.nan_to_num(frame.depth.ravel().astype(np.float64))).reshape(frame.shape)


def _affinities(grey: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the eight neighbours, (8, H, W), of sum 1 per pixel; 0 beyond the image."""
    inside = _shifted(np.pad(np.ones(grey.shape, bool), 1), grey.shape)
    around = _shifted(np.pad(grey, 1), grey.shape)
    count = inside.sum(axis=0) + 1
    mean = (around.sum(axis=0) + grey) / count
    deviation = np.where(inside, around - mean, 0.0)
    variance = ((deviation**2).sum(axis=0) + (grey - mean) ** 2) / count
    difference = (around - grey) ** 2
    # the most similar neighbour keeps some weight whatever the variance
    nearest = np.where(inside, difference, np.inf).min(axis=0)
    spread = np.maximum.reduce(
        [_VARIANCE_SHARE * variance, nearest / -math.log(_MIN_WEIGHT), np.full(grey.shape, _MIN_VARIANCE)]
    )
    weights = np.where(inside, np.exp(-difference / spread), 0.0)
    return weights / weights.sum(axis=0)


def _shifted(padded: NDArray, shape: tuple[int, int]) -> NDArray:
    return np.stack([padded[row : row + shape[0], column : column + shape[1]] for row, column in _NEIGHBOURS])
