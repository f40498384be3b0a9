"""The methods of the bench: all presets, and the peers, classical methods of depth completion to compare with."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from scipy.sparse import diags_array

from ...completion import plain_surfaces
from ...completion.interpolation import linear, nearest
from ...completion.plain_surfaces import bending, first_differences, minimise_energy, plane_through, solve
from ...data.blocks import find_blocks
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS, Parameters
from ...run.run import complete

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


_RADIUS = 3.0
_UNITS, _DEEPEST = 1000.0, 65_535


def navier_stokes(frame: RGBDFrame) -> NDArray[np.float32]:
    """Bertalmio, Bertozzi and Sapiro, "Navier-Stokes, fluid dynamics, and image and video inpainting", 2001."""
    return _inpainted(frame, cv2.INPAINT_NS)


def telea(frame: RGBDFrame) -> NDArray[np.float32]:
    """Telea, "An image inpainting technique based on the fast marching method", 2004."""
    return _inpainted(frame, cv2.INPAINT_TELEA)


def _inpainted(frame: RGBDFrame, method: int) -> NDArray[np.float32]:
    """Depth inpainted in whole millimetres, because OpenCV needs 16-bit images."""
    millimetres = np.nan_to_num(frame.depth.astype(np.float64)) * _UNITS
    image = np.clip(np.rint(millimetres), 0, _DEEPEST).astype(np.uint16)
    filled = cv2.inpaint(image, (~frame.known).astype(np.uint8), _RADIUS, method)
    return np.where(filled > 0, filled / np.float32(_UNITS), np.float32(np.nan))


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
    stiffness = roughness(frame.shape)
    for strength in _STRENGTHS:
        smooth = idctn(dctn(surface, norm="ortho") / (1 + strength * stiffness), norm="ortho")
        surface += _OVER_RELAXATION * (smooth - surface)
        surface[known] = data
    return np.where(surface > 0, surface, np.nan)


def roughness(shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Squared eigenvalues of the Laplacian, of the shape of the cosine transform."""
    rows, columns = (2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in shape)
    return (rows[:, None] + columns[None, :]) ** 2


# of 0, 0.1, 1, 10 and 100 this had the smallest error in large areas of eight frames; for dense samples 0 is better
_STIFFNESS = 10.0


def laplace(frame: RGBDFrame) -> NDArray[np.float64]:
    """The harmonic surface: minimises squared first differences, keeps known pixels."""
    return minimise_energy(frame.depth.astype(np.float64), first_differences(frame.shape))


def thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate: minimises squared second differences, keeps known pixels."""
    surface = plain_surfaces.thin_plate(frame.depth.astype(np.float64))
    return np.where(surface > 0, surface, np.nan)


def soft_thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate as a Gaussian Markov random field: it smooths the known pixels instead of passing through them.

    Noise at the rims of large holes then tilts it less. It minimises the squared misfit of the known pixels plus
    `_STIFFNESS` times the squared second differences.
    """
    depth = frame.depth.astype(np.float64)
    plane = plane_through(depth)
    stiffness = bending(frame.shape)
    known = diags_array(frame.known.ravel().astype(np.float64))
    misfit = np.nan_to_num(depth - plane).ravel()
    surface = plane + solve((_STIFFNESS * (stiffness.T @ stiffness) + known).tocsc(), misfit).reshape(frame.shape)
    return np.where(surface > 0, surface, np.nan)


def colourisation(frame: RGBDFrame) -> NDArray[np.float64]:
    """Pixels of similar colour have similar depth: `plain_surfaces.colourisation`."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float64) / 255.0
    return plain_surfaces.colourisation(grey, frame.depth.astype(np.float64))


# All methods by name.

Depth = NDArray[np.floating]

Method = Callable[[RGBDFrame, NDArray[np.int32]], Depth]
"""Takes a frame and its label map, returns depth [m] of shape (H, W), NaN where it does not fill."""


def _preset(parameters: Parameters) -> Method:
    return lambda frame, labels: complete(frame, labels, parameters).depth


def _peer(run: Callable[[RGBDFrame], Depth]) -> Method:
    return lambda frame, _: run(frame)


_PEERS: dict[str, Method] = {
    "nearest": _peer(nearest),
    "linear": _peer(linear),
    "navier-stokes": _peer(navier_stokes),
    "telea": _peer(telea),
    "laplace": _peer(laplace),
    "colourisation": _peer(colourisation),
    "thin-plate": _peer(thin_plate),
    "soft-thin-plate": _peer(soft_thin_plate),
    "dct-smoothing": _peer(dct_smoothing),
    "polynomial": polynomial,
    "morphology": _peer(morphology),
}

METHODS = {name: _preset(values) for name, values in PRESETS.items()} | _PEERS
"""Name -> method, presets first."""

BY_BLOCKS = (*PRESETS, "polynomial")
"""Methods that use the label map."""

GROUPS = {"presets": tuple(PRESETS), "peers": tuple(_PEERS)}
"""Names of groups of methods."""
