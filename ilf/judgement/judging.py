"""How far completed depth is from a truth: over any pixels, over blocks, over a frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..blocks import Box, checked_labels
from ..equality import NanEqual
from ..errors import InputError
from ..frame import RGBDFrame
from ..masks import checked_mask
from ..metrics import measure_errors
from ..outcomes import Completion
from .expectation import share_within

Depth = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class Judgement(NanEqual):
    """How far depth is from the truth, over a set of pixels. NaN equals NaN when judgements are compared.

    Attributes
    ----------
    pixels : int
        Pixels where both are known; with 0 of them the errors are NaN.
    rmse, mae, median : float
        Root mean square, mean absolute and median absolute error [m].
    bias : float
        Mean error [m], positive where the depth is too large.
    within : float or None
        Share of the pixels with an expected error whose error is at most that, 0-1; None where there are none.
    """

    pixels: int = 0
    rmse: float = math.nan
    mae: float = math.nan
    median: float = math.nan
    bias: float = math.nan
    within: float | None = None


def judge(
    depth: Depth, truth: Depth, mask: NDArray[np.bool_] | None = None, expected: Depth | None = None
) -> Judgement:
    """Compare depth with the truth, over the pixels where both are known.

    Parameters
    ----------
    depth, truth : ndarray of float
        Depth [m] of the same shape, NaN = not known.
    mask : ndarray of bool, optional
        Only these pixels.
    expected : ndarray of float, optional
        Expected error [m], NaN where there is none.

    Returns
    -------
    Judgement

    Raises
    ------
    InputError
        If shapes differ.

    Examples
    --------
    >>> truth = np.full((1, 4), 2.0)
    >>> judgement = judge(truth + [[0.0, 0.2, -0.1, np.nan]], truth, expected=np.full((1, 4), 0.15))
    >>> judgement.pixels, round(judgement.mae, 3), round(judgement.bias, 3), round(judgement.within, 2)
    (3, 0.1, 0.033, 0.67)
    """
    given = {"depth": depth, "truth": truth, "mask": mask, "expected error": expected}
    if len({values.shape for values in given.values() if values is not None}) > 1:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in given.items() if values is not None)
        raise InputError(f"What is compared must show the same pixels: {shapes}.")
    judged = np.isfinite(depth) & np.isfinite(truth)
    if mask is not None:
        judged &= mask
    if not judged.any():
        return Judgement()
    errors = measure_errors(depth, truth, judged)
    return Judgement(
        pixels=errors.pixels,
        rmse=errors.rmse,
        mae=errors.mae,
        median=errors.median,
        bias=errors.acc,
        within=None if expected is None else _within(depth[judged], truth[judged], expected[judged]),
    )


def judge_completion(
    frame: RGBDFrame,
    completion: Completion,
    area: NDArray[np.bool_] | Box | None = None,
    *,
    every: bool = False,
    expected: Depth | None = None,
) -> Judgement:
    """Compare what was filled in the depth camera's view with the frame's truth.

    Parameters
    ----------
    frame : RGBDFrame
        That was completed; it has a truth.
    completion : Completion
    area : ndarray of bool, shape (H, W), or Box, optional
        Only there.
    every : bool
        Judge the depth that was known before, too.
    expected : ndarray of float, shape (H, W), optional
        `ilf.expected_error` of the completion, for `Judgement.within`.

    Raises
    ------
    InputError
        If the frame has no truth, or shapes differ.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, truth=np.full((20, 30), 2.01))
    >>> judgement = judge_completion(frame, ilf.complete(frame, np.ones((20, 30), np.int32)))
    >>> judgement.pixels, round(judgement.rmse, 3), round(judgement.bias, 3)
    (40, 0.01, -0.01)
    """
    judged = _judged(frame, completion, every)
    if isinstance(area, tuple):
        inside = np.zeros(frame.shape, bool)
        inside[area] = True
        judged &= inside
    elif area is not None:
        judged &= checked_mask(area, frame.shape, "the area to judge")
    return judge(completion.depth, _truth(frame), judged, expected)


def judge_blocks(
    frame: RGBDFrame,
    completion: Completion,
    labels: NDArray[np.integer],
    *,
    every: bool = False,
    expected: Depth | None = None,
) -> dict[int, Judgement]:
    """`judge_completion` of every block that has pixels to judge.

    Parameters
    ----------
    frame, completion, every, expected
        As there.
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.

    Returns
    -------
    dict
        Label -> Judgement, in rising order of labels.

    Raises
    ------
    InputError
        If the frame has no truth, or shapes differ.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, truth=np.full((20, 30), 2.01))
    >>> blocks = np.repeat([[1, 2]], 20, axis=0).repeat(15, axis=1)
    >>> found = judge_blocks(frame, ilf.complete(frame, blocks), blocks)
    >>> {label: judgement.pixels for label, judgement in found.items()}
    {1: 20, 2: 20}
    """
    truth, owners = _truth(frame), checked_labels(labels, frame.shape)
    judged = _judged(frame, completion, every) & np.isfinite(completion.depth) & np.isfinite(truth) & (owners > 0)
    everywhere = np.flatnonzero(judged)
    return {
        label: judge(
            completion.depth.ravel()[places],
            truth.ravel()[places],
            expected=None if expected is None else expected.ravel()[places],
        )
        for label, chosen in by_label(owners, everywhere)
        for places in [everywhere[chosen]]
    }


def by_label(labels: NDArray[np.int32], places: NDArray[np.intp]) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """Which of some flat places of a label map belong to each label, by their numbers, in rising order of labels."""
    owners = labels.ravel()[places]
    order = np.argsort(owners, kind="stable")
    found, starts = np.unique(owners[order], return_index=True)
    yield from zip(found.tolist(), np.split(order, starts[1:]), strict=False)


def _truth(frame: RGBDFrame) -> NDArray[np.float32]:
    if frame.truth is None:
        raise InputError(f"{frame.name} has no truth to be judged by. Load one, or test on hidden depth.")
    return frame.truth


def _judged(frame: RGBDFrame, completion: Completion, every: bool) -> NDArray[np.bool_]:
    if completion.depth.shape != frame.shape:
        raise InputError(f"The completion has shape {completion.depth.shape}, but the frame has {frame.shape}.")
    return np.ones(frame.shape, bool) if every else completion.filled & frame.missing


def _within(depth: Depth, truth: Depth, expected: Depth) -> float | None:
    said = np.isfinite(expected)
    if not said.any():
        return None
    # as the bench has it, in the depth's own precision
    return share_within(depth[said] - truth[said], expected[said])
