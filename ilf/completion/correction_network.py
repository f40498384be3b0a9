"""The correction network: from what the surface network has found and completed depth to changes of log depth."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from .._runtime.networks.models import CORRECTION, model_path
from .._runtime.networks.network import OnnxNetwork, RefusedInputError, reflected
from ..errors import FormatError
from ..segmentation.edges.surfaces import AROUND, CELL, MULTIPLE, Surfaces, filled_log_depth, nearest_depth

Array = NDArray[np.float32]
Floats = NDArray[np.floating]

# Changes of depth spread from cell to cell, according to the conductance of the links.

_LEAK = 1e-8
"""Minimum weight with which every cell is pulled to 0, so that there is always a solution."""


def factors_of(right: Floats, below: Floats, held: Floats) -> Floats:
    """Banded Cholesky factors of a grid, with cells numbered down the columns.

    Parameters
    ----------
    right, below : ndarray, shapes (H, W - 1) and (H - 1, W)
        Conductances of the links to the right and to the lower neighbour.
    held : ndarray, shape (H, W)
        Weight with which each cell is pulled to 0.
    """
    height, width = held.shape
    diagonal = held + _LEAK
    diagonal[:, 1:] += right
    diagonal[:, :-1] += right
    diagonal[1:] += below
    diagonal[:-1] += below
    bands = np.zeros((height + 1, width, height), diagonal.dtype)
    bands[0] = diagonal.T
    bands[1, :, :-1] = -below.T
    bands[height, :-1] = -right.T
    return np.asarray(cholesky_banded(bands.reshape(height + 1, -1), overwrite_ab=True, lower=True, check_finite=False))


def load_of(right: Floats, below: Floats, rise_right: Floats, rise_below: Floats, pull: Floats) -> Floats:
    """The right-hand side for rises along the links, and for the cells' target values times their weights."""
    load = pull.copy()
    load[:, 1:] += right * rise_right
    load[:, :-1] -= right * rise_right
    load[1:] += below * rise_below
    load[:-1] -= below * rise_below
    return load


def solve(factors: Floats, load: Floats) -> Floats:
    """Solve for the values of the cells, shape (H, W)."""
    height, width = load.shape
    values = cho_solve_banded((factors, True), load.T.reshape(-1), check_finite=False)
    return np.asarray(values.reshape(width, height).T)


def spread(links: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the changes of the cells.

    Parameters
    ----------
    links : ndarray of float32, shape (6, H, W)
        Conductances of the links to the right (unused in the last column) and below (unused in the last row), the
        wanted rises of the change along them, the weight of each cell's target, and that weight times the target.

    Returns
    -------
    ndarray of float32, shape (H, W)
        The minimum of sum held u^2 - 2 pull u + sum conductance (u_next - u - rise)^2.
    """
    height, width = links.shape[1:]
    if height > width:
        # the cost grows with the square of the side that cells are numbered along
        return np.ascontiguousarray(spread(links[[1, 0, 3, 2, 4, 5]].transpose(0, 2, 1)).T)
    # in double precision, because the factors fade below the smallest normal numbers of single, which take ten times as long
    right, below, rise_right, rise_below, held, pull = links.astype(np.float64)
    right, rise_right, below, rise_below = right[:, :-1], rise_right[:, :-1], below[:-1], rise_below[:-1]
    load = load_of(right, below, rise_right, rise_below, pull)
    return solve(factors_of(right, below, held), load).astype(np.float32)


# The state of completion: what a step of the network sees of depth, the same in training and in use.

_DEPARTURE_GAIN, _FINE_GAIN, _WIDE_GAIN, _GUIDE_GAIN, _LIMIT = 4, 20, 4, 4, 4
_FINE, _WIDE = 3, 13
"""Weights that scale differences of some per cent to about 1, the value at which they are clipped, and the sides of the
squares [cells] whose mean is subtracted for the relief."""


def state_of(cells: Array, known: Array, filled: Array, coarse: Array, guide: Array, guided: Array) -> Array:
    """The state of completion.

    Parameters
    ----------
    cells, known, filled, coarse, guide, guided : ndarray of float32, shape (h, w)
        Of the cells: completed log depth and filled one, both minus the median of the known one; share of known
        pixels; coarse log depth minus the filled one; the guide's log depth minus the median; the confidence in it.

    Returns
    -------
    ndarray of float32, shape (7, h, w)
    """
    departure = cells - filled
    channels = [
        known,
        _DEPARTURE_GAIN * departure,
        _DEPARTURE_GAIN * (departure - coarse),
        _FINE_GAIN * (cells - _mean(cells, _FINE)),
        _WIDE_GAIN * (cells - _mean(cells, _WIDE)),
        _GUIDE_GAIN * (guide - cells) * guided,
        guided,
    ]
    return np.clip(np.stack(channels), -_LIMIT, _LIMIT).astype(np.float32, copy=False)


def _mean(values: Array, side: int) -> Array:
    return np.asarray(cv2.blur(values, (side, side), borderType=cv2.BORDER_REPLICATE), np.float32)


# The correction network in use: changes of completed depth, in a few steps.

STEPS = 2
"""Number of steps: as many as in training."""

LARGEST = 1.0
"""Maximum change of log depth."""

_LINKS, _HIDDEN, _CONTEXT, _STATE, _PAIR = 6, 16, 36, 7, 2

_NOISE_LEVEL = 0.008
"""Change of log depth above which most of it is applied: smaller changes are no better than noise."""

_MEDIAN = 5
"""Side [px] of the median filter that removes single cells."""

_WINDOW, _ALIKE_COLOUR, _NEAR = 13, 0.03, 4.0
"""The bilateral filter that removes the cells' grid: its side [px] and its standard deviations, in change of log depth
and in position [px]."""

_TRIAL_SHAPES = ((16, 16), (16, 24))


class CorrectionNetwork(OnnxNetwork):
    """A correction network, ready to run. `load` creates one; it may be used from any thread.

    The file is an ONNX network for one step, with the inputs `context`, (1, 36, h, w), of `Surfaces`; `state`,
    (1, 7, h, w), see `state_of`; `passed`, (1, 16, h, w), from the step before, 0 in the first; and `cells`,
    (1, 1, h, w), the completed log depth of the cells. Its outputs are `links`, (1, 6, h, w), as `spread` takes them,
    and `next`, (1, 16, h, w), for the next step.
    """

    KIND = "correction network"

    def change(
        self, surfaces: Surfaces, depth: Array, completed: Array, guide: tuple[Array, Array] | None = None
    ) -> Array:
        """Compute the change of the logarithm of completed depth.

        Parameters
        ----------
        surfaces : Surfaces
            Of the frame with this known depth.
        depth : ndarray of float32, shape (H, W)
            Known depth [m], NaN = missing; at least one known pixel.
        completed : ndarray of float32, shape (H, W)
            Completed depth [m], NaN where it is missing.
        guide : pair of ndarray of float32, shape (H, W), optional
            Depth of a guide [m], and the confidence in it, 0 to 1, 0 where it has no value.

        Returns
        -------
        ndarray of float32, shape (H, W)
        """
        size = surfaces.size
        small = nearest_depth(depth, size)
        known = np.isfinite(small)
        if not known.any():
            return np.zeros(depth.shape, np.float32)
        filled, median = filled_log_depth(small)
        filled -= np.float32(median)
        log_depth = _log_or(nearest_depth(completed, size), median, filled)
        shares = np.zeros(size, np.float32)
        of_guide = log_depth
        if guide is not None:
            of_guide = _log_or(nearest_depth(guide[0], size), median, log_depth)
            shares = nearest_depth(guide[1], size)
        pictures = [reflected(one, MULTIPLE) for one in (known, filled, of_guide, shares, log_depth)]
        window = pictures[0][1]
        *constant, now = (one for one, _ in pictures)
        known_cells, filled_cells, guide_cells, guided = (_cells(one) for one in constant)
        coarse, before = surfaces.coarse[0], now
        passed = np.zeros((_HIDDEN, *coarse.shape), np.float32)
        for _ in range(STEPS):
            cells = _cells(now)
            state = state_of(cells, known_cells, filled_cells, coarse, guide_cells, guided)
            links, passed = self._step(surfaces.context, state, passed, cells)
            now = now + _weighted(spread(links), surfaces.weights)
        found = smoothed((now - before)[window])
        if size == depth.shape:
            return found
        return np.asarray(cv2.resize(found, depth.shape[::-1], interpolation=cv2.INTER_LINEAR), np.float32)

    def _step(self, context: Array, state: Array, passed: Array, cells: Array) -> tuple[Array, Array]:
        inputs = {"context": context, "state": state, "passed": passed, "cells": cells[None]}
        try:
            outputs = self._forward({name: one[None] for name, one in inputs.items()})
        except RefusedInputError as error:
            raise FormatError(f"{self.path.name} is not a {self.KIND}: it does not accept its inputs.") from error
        shapes, size = [one.shape for one in outputs], cells.shape
        if shapes != [(1, _LINKS, *size), (1, _HIDDEN, *size)]:
            raise FormatError(f"{self.path.name} is not a {self.KIND}: its outputs are {shapes} for {size} cells.")
        if not all(np.isfinite(one).all() for one in outputs):
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return outputs[0][0], outputs[1][0]

    def _try(self) -> None:
        for size in _TRIAL_SHAPES:
            flat = np.zeros(size, np.float32)
            channels = (np.zeros((count, *size), np.float32) for count in (_CONTEXT, _STATE, _HIDDEN))
            self._step(*channels, flat)


def _log_or(depth: Array, median: float, otherwise: Array) -> Array:
    """The logarithm of depth minus a median, and other values where it is missing."""
    there = np.isfinite(depth)
    return np.where(there, np.log(np.where(there, depth, 1), dtype=np.float32) - np.float32(median), otherwise)


def _cells(values: NDArray) -> Array:
    """The means of cells."""
    size = values.shape[1] // CELL, values.shape[0] // CELL
    return np.asarray(cv2.resize(values.astype(np.float32), size, interpolation=cv2.INTER_AREA), np.float32)


def smoothed(change: Array) -> Array:
    """Remove small changes, specks and the grid of the cells; edges stay."""
    change = np.clip(change, -LARGEST, LARGEST)
    found = np.asarray(change * -np.expm1(-np.square(change / np.float32(_NOISE_LEVEL))), np.float32)
    for _ in range(2):
        found = np.asarray(cv2.medianBlur(found, _MEDIAN), np.float32)
    return np.asarray(cv2.bilateralFilter(found, _WINDOW, _ALIKE_COLOUR, _NEAR), np.float32)


def _weighted(cells: Array, logits: Array) -> Array:
    """For every pixel, the weighted mean over its cell and those around it."""
    height, width = logits.shape[1:]
    # a cell's value is repeated at each of its pairs of pixels, like the logits
    around = np.pad(cells, 1, mode="edge").repeat(CELL // _PAIR, axis=0).repeat(CELL // _PAIR, axis=1)
    of_cells = logits.reshape(AROUND, _PAIR**2, height, width)
    largest = of_cells.max(axis=0)
    total, weights = np.zeros_like(largest), np.zeros_like(largest)
    for k, of_cell in enumerate(of_cells):
        row, column = (place * (CELL // _PAIR) for place in divmod(k, 3))
        weight = np.exp(of_cell - largest)
        weights += weight
        total += weight * around[row : row + height, column : column + width]
    mean = (total / weights).reshape(_PAIR, _PAIR, height, width)
    return np.ascontiguousarray(mean.transpose(2, 0, 3, 1)).reshape(_PAIR * height, _PAIR * width)


def load_correction_network() -> CorrectionNetwork:
    """Load the correction network that comes with the program.

    Raises
    ------
    InputError
        If its file is missing.
    FormatError
        If it is not a correction network.
    """
    return CorrectionNetwork.load(model_path(CORRECTION))
