"""Expected error of filled depth, pixel by pixel, and the mask of filled depth unsupported by measurements."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.long_work import acquired, check_cancelled, run_beside
from ..._runtime.memory import release_memory
from ...data.arrays import plain_array
from ...data.blocks import SPARSE
from ...data.frame import RGBDFrame
from ...data.frame_cache import FrameCache, once_per_frame
from ...data.results import Completion
from ...errors import ParameterError, check_kind
from ...segmentation.edges.frame_edges import find_edges
from ..block import required_known_pixels
from ..completion import guide_hold_out
from ..edge_aware.view import beyond_sensor_range
from ..suspects import suspect_islands, without_suspects
from .fitted import MODELS
from .model import (
    FLOOR,
    WITHIN,
    ErrorModel,
    Walks,
    default_edges,
    error_features,
    feature_cell,
    features_at,
    filled_pixels,
    in_cells,
    walk,
    walks_with_edges,
)

Array = NDArray[np.float32]

# Difficulty of a frame: part of its known depth is hidden, and estimated from there by random walks.
#
# This is not a completion, but both vary alike with the difficulty of the frame.

_MAX_SIDE = 640
"""Longest side of the frame in the test [px]: larger frames are subsampled in rows and columns."""

_RADIUS, _APART = 0.06, 0.22
"""Radius of the hidden discs and distance of their centres, in widths of the frame."""

_MAX_SAMPLES = 10_000
"""Maximum number of hidden pixels that are evaluated."""

_MIN_SAMPLES = 2000
"""Minimum number of hidden pixels for a result."""


def frame_difficulty(frame: RGBDFrame, model: ErrorModel) -> float | None:
    """Offset of the logarithms of errors from those that a model expects in a frame of usual difficulty, such that 68 %
    of the hidden pixels lie within the expected error; None if too little depth is known."""
    test = difficulty_samples(frame)
    return None if test is None else difficulty_of(*test, model)


def difficulty_of(features: NDArray[np.floating], logarithms: NDArray[np.floating], model: ErrorModel) -> float:
    """`frame_difficulty` from the result of `difficulty_samples`."""
    return float(np.quantile(logarithms - model.logarithms(features), WITHIN))


@once_per_frame
def difficulty_samples(frame: RGBDFrame) -> tuple[NDArray[np.float32], NDArray[np.float64]] | None:
    """Features (N, 13) and logarithms (N,) of |error| / completed depth at the hidden pixels, computed once.

    None if too little depth is known. Independent of the frame's blocks.
    """
    stride = -(-max(frame.shape) // _MAX_SIDE)
    depth = np.ascontiguousarray(frame.depth[stride // 2 :: stride, stride // 2 :: stride])
    if depth.size < 2 * _MIN_SAMPLES:  # a thin frame's copy may have no column
        return None
    hidden = _discs(depth.shape) & np.isfinite(depth)
    if min(np.count_nonzero(hidden), np.count_nonzero(np.isfinite(depth) & ~hidden)) < _MIN_SAMPLES:
        return None
    left = np.where(hidden, np.float32(np.nan), depth)
    contours = cv2.resize(default_edges(frame).detected, depth.shape[::-1], interpolation=cv2.INTER_AREA)
    edges = np.asarray(contours, np.float32)
    walks = walk(left, edges)
    completed = np.exp(walks.depth)
    places = np.flatnonzero(hidden)
    places = places[:: -(-len(places) // _MAX_SAMPLES)]
    found = completed.ravel()[places].astype(np.float64)
    shares = np.abs(found - depth.ravel()[places]) / found
    return features_at(places, left, completed, edges, walks), np.log(np.maximum(shares, FLOOR))


def _discs(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Discs on a triangular lattice, about a quarter of all pixels."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    apart, height = _APART * shape[1], _APART * shape[1] * np.sqrt(0.75)
    row = np.round(rows / height)
    shifted = (columns - apart * (row % 2) / 2).astype(np.float32)
    beside = shifted - np.float32(apart) * np.round(shifted / np.float32(apart))
    return np.asarray(beside**2 + ((rows - row * height) ** 2).astype(np.float32) <= (_RADIUS * shape[1]) ** 2)


# Expected error of filled pixels, and which of them are unsupported by measurements.

DEFAULT_MODEL = "edge-aware"
"""Model for depth filled in by other methods."""

_SPARSE_MODEL = "sparse"
"""Model in its place for sparse frames."""

_NUMBERS = {name: np.uint8(number) for number, name in enumerate(MODELS)}

_CLOSED_OFF, _MIN_STEPS = 12.0, 20.0
"""Depth is closed off where walks need so many times the steps that they would need without edges, and more steps than
the second number."""

_FARTHEST, _NEAREST = 0.999, 0.001
"""Quantiles of the known depth that define its range."""

_OUTSIDE = 0.02
"""Share of depth by which depth must lie outside that range to be unsupported."""

_MIN_ERROR_BEYOND_RANGE = 0.2
"""Minimum expected error, as a share of depth, beyond the sensor range."""

_GUIDE_EXPONENT = 0.75
"""Exponent of the ratio of the hold-out's mean error with the guide to that without, by which errors become smaller."""

_feature_locks = FrameCache[RGBDFrame, None]()
"""Its locks prevent two threads from computing the features of one frame at the same time, which need much memory."""


def depth_error(frame: RGBDFrame, depth: NDArray[np.floating], model: str = DEFAULT_MODEL) -> Array:
    """Compute the expected error of every filled pixel.

    Parameters
    ----------
    frame : RGBDFrame
        The frame before completion.
    depth : ndarray of float, shape (H, W)
        Completed depth [m]; values that are not finite and positive are missing.
    model : str
        One of `MODELS`: the low-pass filter that produced the depth. In sparse frames, "sparse" replaces "edge-aware".

    Returns
    -------
    ndarray of float32, shape (H, W)
        Expected error [m], between 0.01 % of the depth and the depth itself. NaN where the frame has measured depth and
        where none was filled in.

    Raises
    ------
    InputError
        If the shapes differ.
    ParameterError
        For an unknown model.
    """
    if model not in MODELS:
        raise ParameterError(f"There is no error model {model!r}. Known: {', '.join(MODELS)}.")
    return _error(frame, plain_array(depth), np.full(frame.shape, _NUMBERS[model]), default_edges(frame).strength)


_COMPLETION = "The errors of depth are those of a completion", "give what ilf.complete returns."


def expected_error(completion: Completion) -> Array:
    """Compute the expected error of a completion, each block with the model of its filter.

    Extrapolated pixels have the model of their filter, which is that of "best". A guide that is followed makes the
    expected error smaller, by what the hold-out for it says. Where neighbours have measured, it is estimated by how
    their depth differs from the frame's own. It is computed once for a completion.

    Parameters
    ----------
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
    >>> error = ilf.expected_error(ilf.complete(frame))
    >>> int(np.isfinite(error).sum()), bool(error[10, 15] < 0.01)
    (40, True)
    """
    check_kind(completion, Completion, *_COMPLETION)
    return _expected_error(completion).copy()


@once_per_frame
def _expected_error(completion: Completion) -> Array:
    frame = completion.frame
    if filled_pixels(frame, completion.depth).any():
        error = _modelled_error(completion)
    else:  # no edges needed
        error = np.full(frame.shape, np.nan, np.float32)
    if frame.neighbours is not None:
        measured = completion.from_neighbours
        share = frame.neighbours.relative_error(frame.own_depth)
        error[measured] = np.float32(share) * completion.depth[measured]
    return error


def _modelled_error(completion: Completion) -> Array:
    """The expected error where no depth was known, NaN elsewhere."""
    frame, depth = _trusted(completion)
    model = np.full(frame.shape, _NUMBERS[DEFAULT_MODEL])
    for result in completion.results.values():
        model[result.block.box][result.block.mask] = _NUMBERS[result.parameters.filter]
    model[completion.extrapolated] = _NUMBERS[DEFAULT_MODEL]
    with run_beside(partial(_beyond_range, completion)) as found:
        error = _error(frame, depth, model, _edges_of(completion))
    measured = (model == _NUMBERS[DEFAULT_MODEL]) & ~_without_measurements(completion)
    if frame.guide is not None:
        error[measured] *= _guide_factor(frame, completion.depth[measured])
    beyond = found.result()
    error[beyond] = np.maximum(error[beyond], np.float32(_MIN_ERROR_BEYOND_RANGE) * completion.depth[beyond])
    return error


def _trusted(completion: Completion) -> tuple[RGBDFrame, Array]:
    """Frame and completed depth without the suspect islands, if any were left out of the fill."""
    frame = completion.frame
    if not any(result.outcome.suspect for result in completion.results.values()):
        return frame, completion.depth
    return without_suspects(frame), np.where(suspect_islands(frame), np.float32(np.nan), completion.depth)


def unsupported(completion: Completion) -> NDArray[np.bool_]:
    """Find the filled pixels that are unsupported by measurements, so that their expected error is not reliable.

    They are extrapolated; closed off by edges on all sides from known depth; beyond the sensor range; farther or nearer
    than all measured depth; stated by hand; or in a block with too little measured depth, which is completed from a
    guide or depth by hand alone. They are found once for a completion.

    Parameters
    ----------
    completion : Completion

    Returns
    -------
    ndarray of bool, shape (H, W)

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
    >>> bool(ilf.unsupported(ilf.complete(frame)).any())
    False
    """
    check_kind(completion, Completion, *_COMPLETION)
    return _unsupported(completion).copy()


@once_per_frame
def _unsupported(completion: Completion) -> NDArray[np.bool_]:
    frame, depth = _trusted(completion)
    filled = filled_pixels(frame, depth)
    if not filled.any():
        return filled
    nearest, farthest = np.nanquantile(frame.depth, (_NEAREST, _FARTHEST))
    outside = (depth > (1 + _OUTSIDE) * farthest) | (depth < (1 - _OUTSIDE) * nearest)
    steps, freely = walks_with_edges(frame, _edges_of(completion)).steps, _walks_without_edges(frame).steps
    closed_off = (steps > _CLOSED_OFF * freely) & (steps > _MIN_STEPS)
    beyond, without = _beyond_range(completion), _without_measurements(completion)
    return filled & (completion.extrapolated | outside | closed_off | beyond | without | completion.by_hand)


@once_per_frame
def _walks_without_edges(frame: RGBDFrame) -> Walks:
    """Walks without edges."""
    return walk(frame.depth, np.zeros(frame.shape, np.float32))


def _error(frame: RGBDFrame, depth: NDArray[np.floating], model: NDArray[np.uint8], edges: Array) -> Array:
    """Expected error of every filled pixel by the model with its number, NaN elsewhere."""
    error = np.full(frame.shape, np.nan, np.float32)
    with acquired(_feature_locks.lock_of(frame)):
        filled = filled_pixels(frame, depth)
        cell = feature_cell(frame.shape)
        with run_beside(partial(difficulty_samples, frame)):  # which all models need
            features = error_features(frame, depth, edges, cell)
        check_cancelled()
        there = in_cells(filled, filled, cell)
        model_there, values = in_cells(model, filled, cell)[there], np.empty(len(features), np.float32)
        for name, number in _NUMBERS.items():
            own = model_there == number
            if own.any():
                law = MODELS[_SPARSE_MODEL if name == DEFAULT_MODEL and frame.known.mean() < SPARSE else name]
                values[own] = law.shares(features[own], frame_difficulty(frame, law))
        shares = np.zeros(there.shape, np.float32)
        shares[there] = values
        shares = shares.repeat(cell, axis=0).repeat(cell, axis=1)[: error.shape[0], : error.shape[1]]
        np.multiply(shares, depth, out=error, where=filled)
        del features, shares
        release_memory(error.size)
    return error


def _guide_factor(frame: RGBDFrame, depth: Array) -> Array:
    """Factor on the expected error of pixels of this depth [m] by a guide that is followed there, at most 1."""
    test = guide_hold_out(frame)
    if not (test.compared and test.followed):
        return np.ones_like(depth)
    factor = float((test.with_guide / test.without) ** _GUIDE_EXPONENT)
    return np.float32(1) - test.ranges.share(depth) * np.float32(1 - factor)


def _beyond_range(completion: Completion) -> NDArray[np.bool_]:
    """Filled pixels, bool (H, W), beyond the sensor range in blocks that were run with `out_of_range`."""
    beyond = np.zeros(completion.frame.shape, bool)
    for result in completion.results.values():
        if result.parameters.filter == "edge-aware" and result.parameters.out_of_range and result.history:
            found = beyond_sensor_range(completion.frame, result.block)
            if found is not None:
                beyond |= found.pixels
    return beyond & completion.filled


def _without_measurements(completion: Completion) -> NDArray[np.bool_]:
    """Pixels, bool (H, W), of blocks that were completed with less known depth than their parameters require."""
    alone = np.zeros(completion.frame.shape, bool)
    density = completion.frame.known.mean()
    for result in completion.results.values():
        outcome = result.outcome
        if result.history and outcome.known < required_known_pixels(outcome.pixels, result.parameters, density):
            alone[result.block.box][result.block.mask] = True
    return alone


def _edges_of(completion: Completion) -> Array:
    """The edges that the blocks' filter used, including the blocks' drawn borders."""
    frame, _ = _trusted(completion)
    results = completion.results.values()
    asked_for = next((result.edges for result in results if result.edges is not None), None)
    edges = (default_edges(frame) if asked_for is None else find_edges(frame, asked_for)).strength
    if all(result.drawn is None for result in results):
        return edges
    edges = edges.copy()
    for result in results:
        if result.drawn is not None:
            pixels = edges[result.block.box]
            pixels[result.block.mask] = np.maximum(pixels[result.block.mask], result.drawn)
    return edges


# Summary statistics of expected errors, and their names and descriptions wherever they are shown.

RMS_NAME, MEDIAN_NAME = "Expected error, RMS", "Expected error, median"
RMS_MEANING = "Root mean square of the expected error over the pixels filled by blocks; dominated by large errors"


class ErrorSummary(NamedTuple):
    """Statistics of expected errors [m]; NaN without any.

    Attributes
    ----------
    rms, median : float
        Root mean square and median.
    p90 : float
        90th percentile.
    """

    rms: float
    median: float
    p90: float


def summarised(error: NDArray[np.floating]) -> ErrorSummary:
    """Compute the statistics of some pixels' expected errors.

    Parameters
    ----------
    error : ndarray of float, any shape
        Expected errors [m]; NaN is ignored.

    Examples
    --------
    >>> summarised(np.array([0.25, 0.5, 2.0, np.nan])).median
    0.5
    """
    known = error[np.isfinite(error)]
    if not known.size:
        return ErrorSummary(math.nan, math.nan, math.nan)
    rms = math.sqrt(float(np.mean(np.square(known, dtype=np.float64))))
    return ErrorSummary(rms, float(np.median(known)), float(np.quantile(known, 0.9)))


def error_summary(completion: Completion) -> ErrorSummary:
    """Compute the statistics of a completion over the pixels filled by its blocks; the expected errors of extrapolated
    pixels are not calibrated."""
    return summarised(expected_error(completion)[completion.filled_by_blocks])
