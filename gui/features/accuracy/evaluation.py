"""Evaluation of results against ground truth, in a worker thread: for the frame, blocks and a rectangle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ilf.completion.confidence.expected_error import expected_error
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.data.results import Completion
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors
from ilf.evaluation.ground_truth import shared_pixels
from ilf.evaluation.ties import Ties

from .hold_out import find_best

Area = tuple[int, ...] | Box | None
"""A part of a frame: labels of blocks, a rectangle, or None for all of it."""


class EvaluatedResult(NamedTuple):
    """A result to evaluate: name and completion, and the colour of its run, None for the current one."""

    name: str
    completion: Completion
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
        ground_truth = request.frame.ground_truth
        assert ground_truth is not None
        shared = shared_pixels([entry.completion for entry in request.entries], every=request.every)
        found = {}
        for name, area in request.areas.items():
            places = np.flatnonzero(shared & np.isfinite(ground_truth) & _inside(area, request.labels))
            there = ground_truth.ravel()[places]
            parts = (self._errors(request, entry.completion, places, there) for entry in request.entries)
            evaluated = [Evaluated(request.labels, (part,)) for part in parts]
            found[name] = AreaErrors(tuple(one.whole for one in evaluated), find_best(evaluated))
        return found

    def _errors(
        self, request: EvaluationRequest, completion: Completion, places: NDArray[np.intp], there: NDArray[np.float32]
    ) -> PixelErrors:
        """Return the errors of a completion at flat indices with this ground truth."""
        expected = self._expected.get(completion)
        if expected is None and request.with_expected:
            expected = self._expected[completion] = expected_error(completion)
        depth = completion.depth.ravel()[places]
        if not request.every:
            depth[~(completion.filled & completion.run.frame.missing).ravel()[places]] = np.nan
        return PixelErrors(
            places, depth, there, np.full_like(depth, np.nan) if expected is None else expected.ravel()[places]
        )


def _inside(area: Area, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    if area is None:
        return np.ones(labels.shape, bool)
    if not isinstance(area[0], slice):
        return np.isin(labels, area)
    inside = np.zeros(labels.shape, bool)
    inside[area] = True
    return inside
