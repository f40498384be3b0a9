"""Evaluation of completed depth against ground truth: over any pixels, over blocks, over a frame."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from .._runtime.long_work import mapped_steps
from ..data.arrays import check_shape, plain_array
from ..data.blocks import Box, checked_labels
from ..data.frame import RGBDFrame, checked_frame, checked_mask
from ..data.results import Completion, NanEqual
from ..errors import InputError, check_kind

Depth = NDArray[np.floating]

DELTA_BASE = 1.25
"""Base of the threshold accuracies delta < 1.25^k."""


@dataclass(frozen=True, eq=False)
class Evaluation(NanEqual):
    """Errors of depth against ground truth over a set of pixels (section 7). NaN equals NaN in comparisons.

    Attributes
    ----------
    pixels : int
        Number of pixels where both are known; if it is 0, the errors are NaN.
    rmse, mae, median : float
        Root mean square error, Eq. (5), mean absolute error, Eq. (6), and median absolute error [m].
    bias : float
        Mean error [m], positive if the depth is too large: the accuracy ACC, Eq. (3).
    within : float or None
        Share of the pixels with an expected error whose error is at most that, 0-1; None without such pixels.
    rel : float
        Mean absolute error relative to the ground truth, Eq. (7).
    delta : tuple of float
        Shares of pixels with max(depth / ground truth, ground truth / depth) < 1.25^k, for k = 1, 2, 3.
    deviation : float
        Standard deviation of the error [m], over N and not N - 1 pixels: the precision PRS, Eq. (4). As printed, it
        squares the sum of the deviations, which is always 0; here, the deviations are squared.
    """

    pixels: int = 0
    rmse: float = math.nan
    mae: float = math.nan
    median: float = math.nan
    bias: float = math.nan
    within: float | None = None
    rel: float = math.nan
    delta: tuple[float, ...] = (math.nan,) * 3
    deviation: float = math.nan


def evaluate(
    depth: Depth, ground_truth: Depth, mask: NDArray[np.bool_] | None = None, expected: Depth | None = None
) -> Evaluation:
    """Compare depth with ground truth over the pixels where both are known.

    Parameters
    ----------
    depth, ground_truth : ndarray of float
        Depth [m] of the same shape, NaN = unknown.
    mask : ndarray of bool, optional
        Only these pixels.
    expected : ndarray of float, optional
        Expected error [m], NaN = none.

    Returns
    -------
    Evaluation

    Raises
    ------
    InputError
        If shapes differ.

    Examples
    --------
    >>> ground_truth = np.full((1, 4), 2.0)
    >>> evaluation = evaluate(ground_truth + [[0.0, 0.2, -0.1, np.nan]], ground_truth, expected=np.full((1, 4), 0.15))
    >>> evaluation.pixels, round(evaluation.mae, 3), round(evaluation.bias, 3), round(evaluation.within, 2)
    (3, 0.1, 0.033, 0.67)
    """
    given = {"depth": depth, "ground truth": ground_truth, "mask": mask, "expected error": expected}
    if len({values.shape for values in given.values() if values is not None}) > 1:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in given.items() if values is not None)
        raise InputError(f"Only arrays of the same shape can be compared: {shapes}.")
    depth, ground_truth = plain_array(depth), plain_array(ground_truth)
    evaluated = _is_known(depth) & _is_known(ground_truth)
    if mask is not None:
        evaluated &= plain_array(mask)
    if not evaluated.any():
        return Evaluation()
    measured, true = depth[evaluated].astype(np.float64), ground_truth[evaluated].astype(np.float64)
    error = measured - true
    size = np.abs(error)
    ratio = np.maximum(measured / true, true / measured)
    return Evaluation(
        pixels=error.size,
        rmse=float(np.sqrt(np.mean(error**2))),
        mae=float(np.mean(size)),
        median=float(np.median(size)),
        bias=float(np.mean(error)),
        within=None if expected is None else _within(depth[evaluated], ground_truth[evaluated], expected[evaluated]),
        rel=float(np.mean(size / true)),
        delta=tuple(float(np.mean(ratio < DELTA_BASE**power)) for power in (1, 2, 3)),
        deviation=float(np.std(error)),
    )


def evaluate_completion(
    frame: RGBDFrame,
    completion: Completion,
    area: NDArray[np.bool_] | Box | None = None,
    *,
    every: bool = False,
    expected: Depth | None = None,
) -> Evaluation:
    """Compare the depth filled in the depth camera's view with the frame's ground truth.

    Parameters
    ----------
    frame : RGBDFrame
        The completed frame, with ground truth.
    completion : Completion
    area : ndarray of bool, shape (H, W), or Box, optional
        Only these pixels.
    every : bool
        Evaluate previously known depth as well.
    expected : ndarray of float, shape (H, W), optional
        `ilf.expected_error` of the completion, for `Evaluation.within`.

    Raises
    ------
    InputError
        If the frame has no ground truth, or shapes differ.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, ground_truth=np.full((20, 30), 2.01))
    >>> evaluation = evaluate_completion(frame, ilf.complete(frame, np.ones((20, 30), np.int32)))
    >>> evaluation.pixels, round(evaluation.rmse, 3), round(evaluation.bias, 3)
    (40, 0.01, -0.01)
    """
    if isinstance(frame, Completion) and isinstance(completion, RGBDFrame):
        frame, completion = completion, frame
    check_kind(completion, Completion, "The second argument must be a completion", "give what ilf.complete returns.")
    checked_frame(frame)
    evaluated = _evaluated(frame, completion, every)
    if isinstance(area, tuple):
        inside = np.zeros(frame.shape, bool)
        inside[area] = True
        evaluated &= inside
    elif area is not None:
        evaluated &= checked_mask(area, frame.shape, "the area to evaluate")
    return evaluate(completion.depth, _ground_truth(frame), evaluated, expected)


def evaluate_blocks(frame: RGBDFrame, completion: Completion, labels: NDArray[np.integer]) -> dict[int, Evaluation]:
    """`evaluate_completion` for every block that has pixels to evaluate.

    Parameters
    ----------
    frame, completion
        As for `evaluate_completion`.
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.

    Returns
    -------
    dict
        Label -> Evaluation, in increasing order of labels.

    Raises
    ------
    InputError
        If the frame has no ground truth, or shapes differ.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, ground_truth=np.full((20, 30), 2.01))
    >>> blocks = np.repeat([[1, 2]], 20, axis=0).repeat(15, axis=1)
    >>> found = evaluate_blocks(frame, ilf.complete(frame, blocks), blocks)
    >>> {label: evaluation.pixels for label, evaluation in found.items()}
    {1: 20, 2: 20}
    """
    ground_truth, owners = _ground_truth(frame), checked_labels(labels, frame.shape)
    evaluated = _evaluated(frame, completion) & np.isfinite(completion.depth) & np.isfinite(ground_truth)
    errors = PixelErrors.at(evaluated & (owners > 0), completion.depth, ground_truth)
    return Evaluated(owners, (errors,)).blocks


def _ground_truth(frame: RGBDFrame) -> NDArray[np.float32]:
    if frame.ground_truth is None:
        raise InputError(f"{frame.name} has no ground truth. Load one, or run a hold-out test.")
    return frame.ground_truth


def _evaluated(frame: RGBDFrame, completion: Completion, every: bool = False) -> NDArray[np.bool_]:
    check_shape("The completion", completion.depth.shape, frame.shape)
    return np.ones(frame.shape, bool) if every else completion.filled & frame.missing


def _is_known(depth: Depth) -> NDArray[np.bool_]:
    return np.isfinite(depth) & (depth > 0)


def _within(depth: Depth, ground_truth: Depth, expected: Depth) -> float | None:
    expected = plain_array(expected)
    has_expected = np.isfinite(expected)
    if not has_expected.any():
        return None
    error = depth[has_expected] - ground_truth[has_expected]  # in the depth's own precision
    return share_within(error, expected[has_expected])


def share_within(error: Depth, expected: Depth, times: float = 1.0) -> float:
    """Compute the share of the errors, 0-1, that are at most `times` the expected ones.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True errors (signed) and expected errors (positive) [m]; at least one.
    times : float

    Examples
    --------
    >>> share_within(np.array([0.1, -0.3, 0.5]), np.array([0.2, 0.2, 0.2]))
    0.3333333333333333
    """
    return float(np.mean(np.abs(error) <= times * expected))


# Errors pixel by pixel, and their evaluation: in total, part by part, block by block.

MIN_RELATIVE_COVERAGE = 0.9
"""Minimum share of the best one's filled pixels for a comparison: otherwise the others would be evaluated only on the
remaining easy pixels."""

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class PixelErrors:
    """Pixels that should have been filled, with their completed depth and ground truth.

    Attributes
    ----------
    places : ndarray of int, shape (N,)
        Flat indices in the frame, in increasing order.
    depth, ground_truth, expected : ndarray of float32, shape (N,)
        Completed depth, ground truth and expected error [m]; NaN where the pixel was not filled.
    """

    places: NDArray[np.intp]
    depth: Values
    ground_truth: Values
    expected: Values

    @classmethod
    def at(cls, pixels: NDArray[np.bool_], depth: Depth, ground_truth: Depth, expected: Depth | None = None) -> Self:
        """Those of some pixels of images (H, W); the expected error is NaN if it is not given."""
        of_error = np.full_like(depth, np.nan) if expected is None else plain_array(expected)
        return cls(np.flatnonzero(pixels), depth[pixels], ground_truth[pixels], of_error[pixels])

    @property
    def error(self) -> Values:
        """Completed depth - ground truth [m], NaN where the pixel was not filled."""
        return self.depth - self.ground_truth

    @property
    def filled(self) -> NDArray[np.bool_]:
        """Which of the pixels were filled."""
        return np.isfinite(self.depth)

    def among(self, places: NDArray[np.intp]) -> PixelErrors:
        """The same, as if only the pixels at these flat indices had been filled."""
        there = np.isin(self.places, places, assume_unique=True)
        return replace(self, depth=np.where(there, self.depth, np.float32(np.nan)))

    def only(self, chosen: NDArray[np.intp]) -> PixelErrors:
        """Some of the pixels, by their positions in `places`."""
        return PixelErrors(self.places[chosen], self.depth[chosen], self.ground_truth[chosen], self.expected[chosen])


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The evaluated pixels of a completion, or of several of the same blocks with different hidden depth.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The blocks.
    parts : tuple of PixelErrors
        One per completion.
    shared : tuple of PixelErrors or None
        The pixels that others have filled as well; only these are evaluated. None for all.
    """

    labels: NDArray[np.int32]
    parts: tuple[PixelErrors, ...]
    shared: tuple[PixelErrors, ...] | None = field(default=None, kw_only=True)

    @property
    def pixels(self) -> int:
        """Number of pixels that should be filled."""
        return sum(part.places.size for part in self.parts)

    @property
    def coverage(self) -> float:
        """Share of them that was filled, 0-1; 0 if there are none."""
        return sum(int(np.count_nonzero(part.filled)) for part in self.parts) / max(self.pixels, 1)

    def of_block(self, label: int) -> Self:
        """The same for one block."""
        inside = self.labels.ravel() == label

        def chosen(parts: tuple[PixelErrors, ...]) -> tuple[PixelErrors, ...]:
            return tuple(part.only(np.flatnonzero(inside[part.places])) for part in parts)

        return replace(self, parts=chosen(self.parts), shared=None if self.shared is None else chosen(self.shared))

    @cached_property
    def whole(self) -> Evaluation:
        """The evaluation of all completions together."""
        return _evaluation(self.evaluated)

    @cached_property
    def blocks(self) -> dict[int, Evaluation]:
        """Label -> evaluation of each block with pixels to be filled, all completions together; in increasing order."""
        found: dict[int, list[PixelErrors]] = {}
        for part in self.evaluated:
            owners = self.labels.ravel()[part.places]
            order = np.argsort(owners, kind="stable")
            labels, starts = np.unique(owners[order], return_index=True)
            for label, chosen in zip(labels.tolist(), np.split(order, starts[1:]), strict=False):
                found.setdefault(label, []).append(part.only(chosen))
        return {label: _evaluation(found[label]) for label in sorted(found)}

    @property
    def evaluated(self) -> tuple[PixelErrors, ...]:
        """The evaluated pixels of every completion."""
        return self.parts if self.shared is None else self.shared


E = TypeVar("E", bound=Evaluated)


def restrict_to_shared(several: Sequence[E]) -> list[E]:
    """Restrict evaluations to the pixels that all of them have filled.

    Those that fill less than nine tenths of what the best one fills do not restrict these pixels.

    Parameters
    ----------
    several : sequence of Evaluated
        With equal numbers of corresponding parts.
    """
    leading = [evaluated for evaluated in several if fills_enough(evaluated, several)]
    if not leading:
        return list(several)
    shared = [
        reduce(np.intersect1d, (part.places[part.filled] for part in parts))
        for parts in zip(*(evaluated.parts for evaluated in leading), strict=True)
    ]
    return [replace(evaluated, shared=tuple(map(PixelErrors.among, evaluated.parts, shared))) for evaluated in several]


def fills_enough(evaluated: Evaluated, several: Sequence[Evaluated]) -> bool:
    """Whether it fills enough pixels for a comparison of its errors with the others'."""
    return evaluated.coverage > 0 and evaluated.coverage >= MIN_RELATIVE_COVERAGE * max(
        other.coverage for other in several
    )


def _evaluation(parts: Sequence[PixelErrors]) -> Evaluation:
    if not parts:
        return Evaluation()
    depth, ground_truth, expected = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("depth", "ground_truth", "expected")
    )
    return evaluate(depth, ground_truth, expected=expected)


# Progress of a long evaluation.

T = TypeVar("T")


@dataclass(frozen=True)
class Progress:
    """A progress report of an evaluation.

    Attributes
    ----------
    share : float
        Finished fraction, 0-1.
    text : str
        The current work.
    """

    share: float
    text: str


def scaled_progress(
    steps: Generator[Progress, None, T], start: float, width: float, before: str = ""
) -> Generator[Progress, None, T]:
    """Map the progress of some steps to the range from `start` to `start + width`; returns their result."""
    return mapped_steps(steps, lambda step: Progress(start + width * step.share, before + step.text))


# How well a mean error is known.

_CELL = 16
"""Side [px] of the squares whose errors count as one observation: errors of neighbouring pixels are alike."""

_PROBABILITY = 0.95
"""Probability that the true mean lies within the margin."""


def margin_of_mean(values: Sequence[NDArray[np.floating]], places: Sequence[NDArray[np.intp]], width: int) -> float:
    """Half the width of the 95 % confidence interval of the mean of values at pixels, over several frames.

    Parameters
    ----------
    values : sequence of ndarray of float, shape (N,)
        One array per frame.
    places : sequence of ndarray of int, shape (N,)
        The flat indices of their pixels.
    width : int
        Width of the frames [px].

    Returns
    -------
    float
        In the unit of the values; infinite if the pixels lie in fewer than two squares of 16 px.

    Examples
    --------
    >>> margin_of_mean([np.array([1.0, 1.0, 3.0, 3.0])], [np.array([0, 1, 20, 21])], 64) > 10
    True
    """
    sums, sizes = [], []
    mean = sum(float(part.sum(dtype=np.float64)) for part in values) / max(sum(part.size for part in values), 1)
    for part, at in zip(values, places, strict=True):
        rows, columns = np.divmod(at, width)
        cells = rows // _CELL * (width // _CELL + 1) + columns // _CELL
        sums.append(np.bincount(cells, part.astype(np.float64) - mean)[np.bincount(cells) > 0])
        sizes.append(part.size)
    count = sum(part.size for part in sums)
    if count < 2:
        return math.inf
    deviation = math.sqrt(sum(float(np.sum(part**2)) for part in sums) * count / (count - 1)) / sum(sizes)
    return float(stdtrit(count - 1, (1 + _PROBABILITY) / 2)) * deviation
