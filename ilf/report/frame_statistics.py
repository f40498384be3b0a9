"""The statistics of a frame: expected and evaluated errors of its depth, for the frame and per block."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..completion.confidence.expected_error import ErrorSummary, error_summary, expected_error, summarised
from ..data.results import BlockResult, Completion
from ..evaluation.evaluation import Evaluation, evaluate_blocks, evaluate_completion
from ..evaluation.hold_out import HoldOutResult
from .content import Subject


@dataclass(frozen=True)
class ErrorStatistics:
    """One evaluation with further statistics.

    Attributes
    ----------
    name : str
        What was evaluated, and against what.
    evaluation : Evaluation
    p95 : float
        95th percentile of the absolute errors [m]; NaN if there are none.
    coverage : float
        Filled share of the pixels to fill, 0-1; NaN if there are none.
    """

    name: str
    evaluation: Evaluation
    p95: float
    coverage: float


@dataclass(frozen=True, eq=False)
class FrameStatistics:
    """The statistics of a subject.

    Parameters
    ----------
    subject : Subject
    hidden : HoldOutResult, optional
        The evaluation on hold-out, if there is one.
    """

    subject: Subject
    hidden: HoldOutResult | None = None
    expected: NDArray[np.float32] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "expected", expected_error(self.subject.completion))

    @cached_property
    def by_blocks(self) -> Completion:
        """The completion with only the pixels filled by blocks marked as filled."""
        completion = self.subject.completion
        return replace(completion, filled=completion.filled_by_blocks)

    @cached_property
    def against_ground_truth(self) -> ErrorStatistics | None:
        """Errors of the pixels filled by blocks against ground truth; None without it, or if no block was run."""
        return self._against_ground_truth(self.by_blocks, "Against ground truth")

    def _against_ground_truth(self, completion: Completion, name: str) -> ErrorStatistics | None:
        frame = self.subject.run.frame
        if frame.ground_truth is None or not completion.results:
            return None
        evaluation = evaluate_completion(frame, completion, expected=self.expected)
        wanted = frame.missing & np.isfinite(frame.ground_truth)
        filled = completion.filled & wanted
        coverage = int(np.count_nonzero(filled)) / max(int(np.count_nonzero(wanted)), 1)
        return ErrorStatistics(name, evaluation, _p95(completion.depth[filled] - frame.ground_truth[filled]), coverage)

    @cached_property
    def on_hold_out(self) -> ErrorStatistics | None:
        """Errors on hold-out over all seeds; None if there was no hold-out."""
        hidden = self.hidden
        if hidden is None:
            return None
        seeds = ", ".join(map(str, hidden.test.seeds))
        name = f"On hold-out ({hidden.test.pattern}; seed{'s' * (len(hidden.test.seeds) > 1)} {seeds})"
        return ErrorStatistics(
            name, hidden.whole, _p95(np.concatenate([part.error for part in hidden.errors])), hidden.coverage
        )

    @property
    def errors(self) -> tuple[ErrorStatistics, ...]:
        """All evaluations of the frame: against ground truth, on hold-out over all seeds, and for each seed."""
        all_filled = self.subject.completion
        extrapolations = self._against_ground_truth(all_filled, "Against ground truth, including extrapolated pixels")
        found = self.against_ground_truth, extrapolations if all_filled.extrapolated.any() else None, self.on_hold_out
        return tuple(one for one in (*found, *self._by_seed()) if one is not None)

    def _by_seed(self) -> Iterator[ErrorStatistics]:
        if self.hidden is not None and len(self.hidden.errors) > 1:
            test, parts, evaluations = self.hidden.test, self.hidden.errors, self.hidden.by_seed
            for seed, part, evaluation in zip(test.seeds, parts, evaluations, strict=True):
                coverage = float(np.mean(part.filled)) if part.filled.size else math.nan
                yield ErrorStatistics(f"seed {seed} alone", evaluation, _p95(part.error), coverage)

    @property
    def evaluated_by(self) -> str:
        """What blocks are evaluated against: "ground truth", "hold-out", or "" if nothing."""
        if self.against_ground_truth is not None:
            return "ground truth"
        return "hold-out" if self.hidden is not None else ""

    @cached_property
    def by_block(self) -> Mapping[int, Evaluation]:
        """Block label -> its evaluation against `evaluated_by`."""
        subject = self.subject
        if self.evaluated_by == "ground truth":
            return evaluate_blocks(subject.run.frame, self.by_blocks, subject.run.blocks, expected=self.expected)
        return {} if self.hidden is None else self.hidden.blocks

    def expected_of(self, result: BlockResult) -> float:
        """Return the RMS of the expected error [m] over the pixels that a block has filled; NaN if there are none."""
        box, mask = result.block.box, result.block.mask
        return summarised(self.expected[box][mask & self.by_blocks.filled[box]]).rms

    @cached_property
    def whole_expected(self) -> ErrorSummary:
        """Summary of the expected error over all pixels filled by blocks."""
        return error_summary(self.expected, self.subject.completion)


def _p95(error: NDArray[np.floating]) -> float:
    known = np.abs(error[np.isfinite(error)])
    return float(np.percentile(known, 95)) if known.size else math.nan
