"""Evaluation of results against ground truth, in a worker thread: for the frame, blocks and a rectangle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ilf.completion.confidence.expected_error import expected_error
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.data.results import Completion
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors, evaluate_completion
from ilf.evaluation.ground_truth import shared_pixels
from ilf.evaluation.ties import Ties

from .hold_out import find_best

Area = tuple[int, ...] | Box | None
"""A part of a frame: labels of blocks, a rectangle, or None for all of it."""


@dataclass(frozen=True, eq=False)
class EvaluatedResult:
    """A result to evaluate: the current one, or that of a run.

    Attributes
    ----------
    name : str
    completion : Completion
    frame : RGBDFrame
        Frame of the result.
    colour : (int, int, int) or None
        Colour of the run.
    """

    name: str
    completion: Completion
    frame: RGBDFrame
    colour: tuple[int, int, int] | None = None


@dataclass(frozen=True, eq=False)
class EvaluationRequest:
    """Request for an evaluation.

    Attributes
    ----------
    frame : RGBDFrame
        The current frame, with ground truth.
    entries : tuple
        The first is the current result.
    labels : ndarray of int32, shape (H, W)
        The current label map.
    areas : mapping of str to Area
        Parts of the frame by name.
    every : bool
        Whether known pixels also count.
    with_expected : bool
        Whether to compute the share within the expected error, which takes longer.
    """

    frame: RGBDFrame
    entries: tuple[EvaluatedResult, ...]
    labels: NDArray[np.int32]
    areas: Mapping[str, Area]
    every: bool
    with_expected: bool


@dataclass(frozen=True, eq=False)
class AreaErrors:
    """Errors over a part of the frame: of each entry over the pixels that all of them have filled, and the entries with
    the smallest error."""

    evaluated: tuple[Evaluation, ...]
    best: Ties | None


class Evaluator:
    """Evaluates requests, one at a time; caches the expected error of each completion as long as that exists."""

    def __init__(self) -> None:
        self._expected: WeakKeyDictionary[Completion, NDArray[np.float32]] = WeakKeyDictionary()

    def __call__(self, request: EvaluationRequest) -> dict[str, AreaErrors]:
        """Return the errors by the name of the area; called in a worker thread."""
        shared = shared_pixels([entry.completion for entry in request.entries], every=request.every)
        found = {}
        for name, area in request.areas.items():
            where = shared & _inside(area, request.labels)
            evaluated = tuple(self._evaluated(request, entry, where) for entry in request.entries)
            found[name] = AreaErrors(
                evaluated, find_best([_pixel_errors(request, entry, where) for entry in request.entries])
            )
        return found

    def _evaluated(self, request: EvaluationRequest, entry: EvaluatedResult, where: NDArray[np.bool_]) -> Evaluation:
        expected, ground_truth = self._expected.get(entry.completion), request.frame.ground_truth
        if expected is None and request.with_expected:
            expected = self._expected[entry.completion] = expected_error(entry.completion)
        frame = entry.frame
        if frame.ground_truth is not ground_truth:
            frame = frame.with_ground_truth(ground_truth)
        return evaluate_completion(frame, entry.completion, where, every=request.every, expected=expected)


def _pixel_errors(request: EvaluationRequest, entry: EvaluatedResult, where: NDArray[np.bool_]) -> Evaluated:
    ground_truth = request.frame.ground_truth
    assert ground_truth is not None
    errors = PixelErrors.at(where & np.isfinite(ground_truth), entry.completion.depth, ground_truth)
    return Evaluated(request.labels, (errors,))


def _inside(area: Area, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    if area is None:
        return np.ones(labels.shape, bool)
    if not isinstance(area[0], slice):
        return np.isin(labels, area)
    inside = np.zeros(labels.shape, bool)
    inside[area] = True
    return inside
