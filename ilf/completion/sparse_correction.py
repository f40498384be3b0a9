"""The correction of sparse depth: after the first network, a second one on cells of the frame.

Where few pixels are known, a frame has little depth to learn from, and what surfaces without blocks make of it is worth
knowing: the thin plate continues slopes, colourisation follows colour, and the nearest known depth is at least
measured. A small network is given their differences from the corrected depth, and changes it once more.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.networks.models import SPARSE_CORRECTION
from .._runtime.networks.network import OnnxNetwork
from ..data.pixel_grids import cells_of, nearest_values, padded
from ..errors import FormatError
from .plain_surfaces import colourisation, thin_plate

Array = NDArray[np.float32]

CELLS = 160
"""Number of cells along a frame's longer side."""

CHANNELS = (
    *("nearest", "farthest in 17", "farthest in 41", "closest in 17", "closest in 41", "thin plate", "colourisation"),
    *("thin plate, mean", "colourisation, mean", "deviation", "median"),
    *("relief in 9", "relief in 41", "slope right", "slope down", "slope", "first change", "first change, mean"),
    *("contours", "contours in 9", "contours, mean", "known in 15", "known in 41", "distance"),
)
"""The channels of `sparse_features`, in this order; numbers are sides of windows, in cells."""

_LIMIT = 1.5
"""Largest difference of log depth."""

_NARROW, _WIDE, _MEAN, _RELIEF, _DENSITY = 17, 41, 7, 9, 15
_GAIN = 4
"""Factor on differences of log depth, which brings them to about 1."""

_ALIKE = 0.03
"""Squared difference of log depth at which a cell's change counts 37 % for a pixel."""


def cell_side(shape: tuple[int, ...]) -> int:
    """Side of the cells of a frame [px]."""
    return max(1, round(max(shape[:2]) / CELLS))


def middles_of_cells(values: NDArray[np.floating]) -> Array:
    """Values of the pixels in the middle of the cells, float32 (h, w)."""
    side = cell_side(values.shape)
    return np.ascontiguousarray(padded(values, side, "edge")[side // 2 :: side, side // 2 :: side], np.float32)


def sparse_features(
    rgb: NDArray[np.uint8], depth: Array, corrected: Array, change: Array, contours: Array
) -> tuple[Array, Array]:
    """Compute the network's input, independent of scale.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing; at least one known pixel.
    corrected : ndarray of float32, shape (H, W)
        Completed depth after the first change [m]; NaN where it has not been completed.
    change : ndarray of float32, shape (H, W)
        The first change of log depth.
    contours : ndarray of float32, shape (H, W)
        Strength of the filter's edges, in [0, 1].

    Returns
    -------
    features : ndarray of float32, shape (24, h, w)
        In the order of `CHANNELS`, for cells of `cell_side` pixels: differences of log depth from `corrected`, its
        relief and slope, the first change, contours, and the density of known depth.
    log_depth : ndarray of float32, shape (h, w)
        Log of `corrected` at the middle of each cell, minus the median of the known log depth.
    """
    side = cell_side(depth.shape)
    known = np.isfinite(depth)
    log_known = np.log(np.where(known, depth, 1), dtype=np.float32)
    median = np.median(log_known[known])
    share = _means(known.astype(np.float32), side)
    sums = _means(np.where(known, log_known - median, 0).astype(np.float32), side)
    values = np.asarray(sums / np.maximum(share, np.float32(1e-6)), np.float32)
    sampled = share > 0
    distance, nearest = nearest_values(values, sampled)
    with np.errstate(invalid="ignore"):
        log_depth = middles_of_cells(np.log(corrected) - median)
    log_depth = np.where(np.isfinite(log_depth), log_depth, nearest).astype(np.float32)
    given = np.where(sampled, values, np.nan).astype(np.float64)
    grey = _means(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32) / np.float32(255), side)
    narrow, wide, around = (
        cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)) for size in (_NARROW, _WIDE, _RELIEF)
    )
    surfaces = (
        nearest,
        *(cv2.dilate(nearest, narrow), cv2.dilate(nearest, wide), cv2.erode(nearest, narrow), cv2.erode(nearest, wide)),
        thin_plate(given),
        colourisation(grey.astype(np.float64), given),
    )
    offsets = [np.clip(surface - log_depth, -_LIMIT, _LIMIT).astype(np.float32) for surface in surfaces]
    plate, coloured = offsets[-2:]
    candidates = np.stack([np.zeros_like(plate), offsets[0], plate, coloured])
    right, down = (cv2.Sobel(log_depth, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    first, edges = middles_of_cells(change), _greatest(contours, side)
    of_depth = (
        *offsets,
        *(_blur(plate, _MEAN), _blur(coloured, _MEAN), candidates.std(axis=0), np.median(candidates, axis=0)),
        *(np.clip(log_depth - _blur(log_depth, size), -_LIMIT, _LIMIT) for size in (_RELIEF, _WIDE)),
        *(right, down, _blur(np.hypot(right, down), 5), first, _blur(first, _MEAN)),
    )
    others = (
        *(edges, cv2.dilate(edges, around), _blur(edges, _RELIEF)),
        *(_DENSITY * _blur(share, size) for size in (_DENSITY, _WIDE)),
        np.log1p(distance) / 4,
    )
    return np.stack([*(_GAIN * one for one in of_depth), *others]).astype(np.float32), log_depth


def mirrored(features: Array) -> Array:
    """The features of the frame's mirror image, of the same shape; the last axis is the one that is turned round."""
    turned = np.ascontiguousarray(features[..., ::-1])
    turned[CHANNELS.index("slope right")] *= -1
    return turned


def spread_to_pixels(cells: Array, log_depth: Array, pixels: Array) -> Array:
    """For every pixel, the mean of the changes of the 9 cells around it, weighted by nearness and by alike depth.

    Parameters
    ----------
    cells, log_depth : ndarray of float32, shape (h, w)
        Changes of cells, and the log depth at their middles.
    pixels : ndarray of float32, shape (H, W)
        Log depth of the pixels; NaN where it is missing: there, only nearness counts.
    """
    height, width = pixels.shape
    side = cell_side(pixels.shape)
    rows, columns = ((np.arange(size, dtype=np.float32) - side // 2) / side for size in (height, width))
    row, column = (
        np.clip(np.rint(at), 0, size - 1).astype(int) for at, size in zip((rows, columns), cells.shape, strict=True)
    )
    off_rows, off_columns = (np.asarray(at - cell + 1, np.float32) for at, cell in ((rows, row), (columns, column)))
    changes, depths = (np.pad(one, 1, mode="edge") for one in (cells, log_depth))
    total, weights = np.zeros_like(pixels), np.zeros_like(pixels)
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            there = np.ix_(row + down, column + right)
            near = np.exp(-np.square(off_rows - down))[:, None] * np.exp(-np.square(off_columns - right))
            alike = np.exp(-np.square(depths[there] - pixels) / np.float32(_ALIKE))
            weight = near * (np.nan_to_num(alike, nan=1) + np.float32(1e-6))
            total += weight * changes[there]
            weights += weight
    return np.asarray(total / weights, np.float32)


class SparseCorrectionNetwork(OnnxNetwork):
    """A network that changes the corrected depth of a sparse frame. `bundled` creates one; use it from any thread.

    The file is an ONNX network of one input, the `sparse_features`, as float32 (1, 24, h, w), and one output, the
    change of log depth of each cell, (1, 1, h, w).
    """

    KIND, NAME = "correction network for sparse depth", SPARSE_CORRECTION

    def change(self, rgb: NDArray[np.uint8], depth: Array, corrected: Array, change: Array, contours: Array) -> Array:
        """Compute the further change of the logarithm of corrected depth, float32 (H, W).

        Parameters
        ----------
        rgb, depth, corrected, change, contours
            As of `sparse_features`.
        """
        features, log_depth = sparse_features(rgb, depth, corrected, change, contours)
        cells = (self._cells(features) + self._cells(mirrored(features))[:, ::-1]) / np.float32(2)
        median = np.median(np.log(depth[np.isfinite(depth)]))
        with np.errstate(invalid="ignore"):
            return spread_to_pixels(cells, log_depth, np.asarray(np.log(corrected) - median, np.float32))

    def _cells(self, features: Array) -> Array:
        outputs = self._forward({"": features[None]})
        if [one.shape for one in outputs] != [(1, 1, *features.shape[1:])]:
            raise FormatError(self._unlike(f"its output shapes are {[one.shape for one in outputs]}."))
        if not np.isfinite(outputs[0]).all():
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return np.clip(outputs[0][0, 0], -_LIMIT, _LIMIT)

    def _try(self) -> None:
        self._cells(np.zeros((len(CHANNELS), 12, 16), np.float32))


def _means(values: Array, side: int) -> Array:
    return np.asarray(cells_of(values, side, "edge").mean(axis=(1, 3)), np.float32)


def _greatest(values: Array, side: int) -> Array:
    return np.asarray(cells_of(values, side, "edge").max(axis=(1, 3)), np.float32)


def _blur(values: Array, size: int) -> Array:
    return np.asarray(cv2.blur(values, (size, size)), np.float32)
