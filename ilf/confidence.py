"""How far filled depth may be off: an expected error for every filled pixel, from the depth alone.

About 68 % of the true errors lie within the expected error, as one standard deviation does for normal errors. It is a
log-linear model of what can be seen around a pixel: how wide its gap is, how far the known depth bends from a plane
over such a width, how far the filled depth departs from the nearest known one, and how steep it is. The constants are
fitted to hidden depth by `ilf.bench.calibration`.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .errors import InputError, ParameterError
from .filter.edge_aware.reach import beyond_reach
from .filter.pyramid import sums_of_four
from .frame import RGBDFrame
from .outcomes import Completion

Array = NDArray[np.float32]

WITHIN = 0.6827
"""Share of errors that is to lie within the expected error: that of one standard deviation."""

FLOOR = 1e-4
"""Smallest expected error, as a share of depth: also what keeps the logarithms of jumps and bends finite."""

_LARGE_JUMP = 0.05
"""Jump to the nearest known depth, as a share of depth, above which it counts in full at any distance."""

_FADING = 0.3
"""How a smaller jump counts for less with distance: by distance^-0.3. Far from known depth a small jump says little."""

_RIM = 9
"""Window [px] in which the widest part of a gap is looked for: at its rim depth is known on one side only."""

_LEVELS = 6
"""How often the grid is halved to see bends over 1, 2, 4, ... 64 px."""

_WINDOW = 9
"""Window, in pixels of the halved grid, over which bends are averaged."""

_BEYOND = 0.2
"""Least expected error, as a share of depth, beyond the sensor's reach, where nothing measured vouches for anything."""

_UNSEEN_BEND = 0.02
"""Bend, as a share of depth, where no three known pixels in a row show any."""


@dataclass(frozen=True)
class ErrorModel:
    """Exponents of the expected error, as a share of depth; none but `level` and `depth` is negative.

    Attributes
    ----------
    level : float
        Logarithm of the share where all else is 1.
    depth : float
        Of the depth [m] itself.
    gap : float
        Of the gap's width: the largest distance to known depth nearby [px].
    bend : float
        Of the known depth's departure from a plane over that distance, as a share of depth.
    small_jump, large_jump : float
        Of the difference to the nearest known depth, as a share of depth: below 5 %, fading with distance, and above.
    slope : float
        Of the filled depth's range over 3 x 3 pixels, as a share of depth.
    """

    level: float
    depth: float
    gap: float
    bend: float
    small_jump: float
    large_jump: float
    slope: float

    def shares(self, features: NDArray[np.floating]) -> NDArray[np.float64]:
        """Expected errors as shares of depth, of features (N, 6) from `error_features`."""
        weights = (self.depth, self.gap, self.bend, self.small_jump, self.large_jump, self.slope)
        logarithm = self.level + features.astype(np.float64) @ np.array(weights)
        return np.exp(np.clip(logarithm, np.log(FLOOR), 0.0))


# Fitted by `python -m ilf.bench.calibration --method best --fit FRAMES` (ideal: --method paper) to 14 real frames of 12
# data sets, 42.77 % of the known depth kept or a quarter of it hidden in ellipses: 68 % quantile of |error| / depth.
MODELS = {
    "edge-aware": ErrorModel(-1.731, 0.159, 0.069, 0.259, 0.553, 0.823, 0.263),
    "ideal": ErrorModel(-2.185, -0.002, 0.127, 0.065, 0.773, 0.784, 0.203),
}
"""Low-pass filter, as in `Parameters.filter`, -> how its errors grow."""

DEFAULT_MODEL = "edge-aware"
"""Model of depth that another method has filled in."""

_NUMBERS = {name: np.uint8(number) for number, name in enumerate(MODELS)}


def depth_error(frame: RGBDFrame, depth: NDArray[np.floating], model: str = DEFAULT_MODEL) -> Array:
    """Expected error of every filled pixel.

    Parameters
    ----------
    frame : RGBDFrame
        As it was before completion.
    depth : ndarray of float, shape (H, W)
        Completed depth [m]; what is not finite and positive is missing.
    model : str
        One of `MODELS`: the low-pass filter that gave the depth.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Expected error [m], at least 0.01 % of the depth and at most the depth itself. NaN where the frame has depth of
        its own and where none was filled in.

    Raises
    ------
    InputError
        If the shapes differ.
    ParameterError
        For an unknown model.
    """
    if model not in MODELS:
        raise ParameterError(f"There is no error model {model!r}. Known: {', '.join(MODELS)}.")
    return _error(frame, depth, np.full(frame.shape, _NUMBERS[model]))


def expected_error(frame: RGBDFrame, completion: Completion) -> Array:
    """`depth_error` of a completion, each block by the model of the filter that it was run with.

    Guesses have the model of the filter that they were made with, which is that of "best".

    Parameters
    ----------
    frame : RGBDFrame
        That was completed.
    completion : Completion

    Returns
    -------
    ndarray of float32, shape (H, W)
        Expected error [m], NaN where nothing was filled.

    Raises
    ------
    InputError
        If the shapes differ.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> error = ilf.expected_error(frame, ilf.complete(frame, np.ones((20, 30), np.int32)))
    >>> int(np.isfinite(error).sum()), bool(error[10, 15] < 0.01)
    (40, True)
    """
    model = np.full(frame.shape, _NUMBERS[DEFAULT_MODEL])
    for result in completion.results.values():
        model[result.block.box][result.block.mask] = _NUMBERS[result.parameters.filter]
    model[completion.guessed] = _NUMBERS[DEFAULT_MODEL]
    error = _error(frame, completion.depth, model)
    beyond = beyond_reach_of(frame, completion)
    error[beyond] = np.maximum(error[beyond], np.float32(_BEYOND) * completion.depth[beyond])
    return error


def beyond_reach_of(frame: RGBDFrame, completion: Completion) -> NDArray[np.bool_]:
    """Filled pixels, bool (H, W), that lie beyond the sensor's reach: nothing that was measured vouches for them.

    Parameters
    ----------
    frame : RGBDFrame
        That was completed.
    completion : Completion
    """
    beyond = np.zeros(frame.shape, bool)
    for result in completion.results.values():
        if result.parameters.filter == "edge-aware" and result.parameters.out_of_range and result.history:
            found = beyond_reach(frame, result.block)
            if found is not None:
                beyond |= found.pixels
    return beyond & completion.filled


def _error(frame: RGBDFrame, depth: NDArray[np.floating], model: NDArray[np.uint8]) -> Array:
    """Expected error of every filled pixel by the model whose number it has, NaN elsewhere."""
    filled = filled_pixels(frame, depth)
    features, depth_there, model_there = error_features(frame, depth), depth[filled], model[filled]
    values = np.empty(depth_there.shape, np.float32)
    for name, number in _NUMBERS.items():
        own = model_there == number
        values[own] = MODELS[name].shares(features[own]) * depth_there[own]
    error = np.full(frame.shape, np.nan, np.float32)
    error[filled] = values
    return error


def filled_pixels(frame: RGBDFrame, depth: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Pixels, bool (H, W), without depth in the frame and with depth now; raises InputError if the shapes differ."""
    if depth.shape != frame.shape:
        raise InputError(f"Depth of shape {depth.shape} does not belong to a frame of shape {frame.shape}.")
    return ~frame.known & np.isfinite(depth) & (depth > 0)


def error_features(frame: RGBDFrame, depth: NDArray[np.floating]) -> Array:
    """What the expected error follows from, for every filled pixel.

    Returns
    -------
    ndarray of float32, shape (N, 6)
        Row by row as `filled_pixels` has them: logarithms of depth, gap, bend, small and large jump and slope, as
        `ErrorModel` explains them.
    """
    filled = filled_pixels(frame, depth)
    if not filled.any():
        return np.empty((0, 6), np.float32)
    distance, nearest = _nearest_known(frame)
    dense = np.where(filled, depth, nearest).astype(np.float32)
    gap = cv2.dilate(distance, np.ones((_RIM, _RIM), np.uint8))[filled]
    square = np.ones((3, 3), np.uint8)
    slope = (cv2.dilate(dense, square) - cv2.erode(dense, square))[filled]
    z, distance_there = dense[filled], distance[filled]
    jump = np.log(np.abs(z - nearest[filled]) / z + FLOOR) - np.log(_LARGE_JUMP)
    return np.column_stack(
        [
            np.log(z),
            np.log(gap),
            np.log(_bend(frame.depth, distance, filled) / z + FLOOR),
            np.minimum(jump, 0) * distance_there**-_FADING,
            np.maximum(jump, 0),
            np.log(slope / z + FLOOR),
        ]
    ).astype(np.float32)


def _nearest_known(frame: RGBDFrame) -> tuple[Array, Array]:
    """Distance [px] to the nearest known pixel, 0 there, and its depth [m]."""
    known = frame.known
    distance, places = cv2.distanceTransformWithLabels(
        (~known).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    of_place = np.zeros(int(places.max()) + 1, np.float32)
    of_place[places[known]] = frame.depth[known]
    return np.asarray(distance, np.float32), of_place[places]


def _bend(depth: Array, distance: Array, wanted: NDArray[np.bool_]) -> Array:
    """Mean departure [m] of the known depth from straight lines, around the wanted pixels and over their distance.

    On level n of a pyramid of block means, half the second difference of neighbours is what a straight line over
    2^n px misses; a pixel takes it, averaged around, from the two levels next to its distance.
    """
    known = np.isfinite(depth)
    count, total = known.astype(np.float32), np.where(known, depth, np.float32(0))
    level_of_pixel = np.clip(np.log2(distance[wanted]), 0, _LEVELS)
    usual = _UNSEEN_BEND * float(np.median(depth[known])) / 2
    bend = np.zeros(level_of_pixel.shape, np.float32)
    for level in range(int(np.ceil(level_of_pixel.max())) + 1):
        bends, seen = _second_differences(count, total)
        # a level that shows nothing is taken to bend twice as far as the finer one
        usual = float(bends.sum() / seen.sum()) if seen.any() else 2 * usual
        local = _local_mean(bends, seen, usual)
        size = (local.shape[1] << level, local.shape[0] << level)
        full = cv2.resize(local, size, interpolation=cv2.INTER_LINEAR)[: depth.shape[0], : depth.shape[1]]
        bend += full[wanted] * np.maximum(1 - np.abs(level_of_pixel - level), 0)
        count, total = sums_of_four(count), sums_of_four(total)
    return bend


def _second_differences(count: Array, total: Array) -> tuple[Array, Array]:
    """Sum over both directions of half the second differences of means, and how many there are; where any is known."""
    known = count > 0
    mean = np.where(known, total / np.maximum(count, 1), np.float32(0))
    bends, seen = np.zeros_like(mean), np.zeros_like(mean)
    # the transposes give views: what is added along y lands in the same arrays
    for values, there, out, number in ((mean, known, bends, seen), (mean.T, known.T, bends.T, seen.T)):
        whole = there[:, 2:] & there[:, 1:-1] & there[:, :-2]
        out[:, 1:-1] += np.where(whole, np.abs(values[:, 2:] - 2 * values[:, 1:-1] + values[:, :-2]) / 2, 0)
        number[:, 1:-1] += whole
    return bends, seen


def _local_mean(sums: Array, counts: Array, usual: float) -> Array:
    """Mean around every place, in which `usual` counts once."""
    window = (_WINDOW, _WINDOW)
    area = _WINDOW * _WINDOW
    around, number = (
        cv2.blur(values, window, borderType=cv2.BORDER_CONSTANT) * np.float32(area) for values in (sums, counts)
    )
    return (around + np.float32(usual)) / (number + 1)
