"""The figures of a frame: how far off its depth is, expected and judged, as a whole and block by block."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..completion.confidence.expected_error import ErrorSummary, error_summary, expected_error, summarised
from ..data.results import BlockResult, Completion
from ..evaluation.evaluation import Judgement, judge_blocks, judge_completion
from ..evaluation.hold_out import HiddenResult
from .content import Subject


@dataclass(frozen=True)
class ErrorFigures:
    """One judgement, and what else is told of it.

    Attributes
    ----------
    name : str
        Of what, and by what.
    judgement : Judgement
    p95 : float
        What 95 % of the absolute errors are no larger than [m]; NaN where there are none.
    coverage : float
        Share of the pixels to be filled that were, 0-1; NaN where there are none.
    """

    name: str
    judgement: Judgement
    p95: float
    coverage: float


@dataclass(frozen=True, eq=False)
class Figures:
    """What there is to say in numbers about a subject.

    Parameters
    ----------
    subject : Subject
    hidden : HiddenResult, optional
        The test on hidden depth, if it has been made.
    """

    subject: Subject
    hidden: HiddenResult | None = None
    expected: NDArray[np.float32] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "expected", expected_error(self.subject.completion))

    @cached_property
    def by_blocks(self) -> Completion:
        """The completion as if nothing but what blocks vouch for had been filled."""
        completion = self.subject.completion
        return replace(completion, filled=completion.filled_by_blocks)

    @cached_property
    def against_truth(self) -> ErrorFigures | None:
        """Of what blocks have filled, by the frame's truth; None if there is none, or no block was run."""
        return self._against_truth(self.by_blocks, "Against the truth")

    def _against_truth(self, completion: Completion, name: str) -> ErrorFigures | None:
        frame = self.subject.run.frame
        if frame.truth is None or not completion.results:
            return None
        judgement = judge_completion(frame, completion, expected=self.expected)
        wanted = frame.missing & np.isfinite(frame.truth)
        filled = completion.filled & wanted
        coverage = int(np.count_nonzero(filled)) / max(int(np.count_nonzero(wanted)), 1)
        return ErrorFigures(name, judgement, _p95(completion.depth[filled] - frame.truth[filled]), coverage)

    @cached_property
    def on_hidden_depth(self) -> ErrorFigures | None:
        """Of all seeds together; None if no test was made."""
        hidden = self.hidden
        if hidden is None:
            return None
        seeds = ", ".join(map(str, hidden.test.seeds))
        name = f"On hidden depth ({hidden.test.pattern}; seed{'s' * (len(hidden.test.seeds) > 1)} {seeds})"
        return ErrorFigures(
            name, hidden.whole, _p95(np.concatenate([part.error for part in hidden.errors])), hidden.coverage
        )

    @property
    def errors(self) -> tuple[ErrorFigures, ...]:
        """Every judgement of the frame: against its truth, on hidden depth all together, and for each seed."""
        all_filled = self.subject.completion
        guesses = self._against_truth(all_filled, "Against the truth, guesses included")
        found = self.against_truth, guesses if all_filled.guessed.any() else None, self.on_hidden_depth
        return tuple(one for one in (*found, *self._by_seed()) if one is not None)

    def _by_seed(self) -> Iterator[ErrorFigures]:
        if self.hidden is not None and len(self.hidden.errors) > 1:
            test, parts, judgements = self.hidden.test, self.hidden.errors, self.hidden.by_seed
            for seed, part, judgement in zip(test.seeds, parts, judgements, strict=True):
                coverage = float(np.mean(part.filled)) if part.filled.size else math.nan
                yield ErrorFigures(f"seed {seed} alone", judgement, _p95(part.error), coverage)

    @property
    def judged_by(self) -> str:
        """What blocks are judged by: "truth", "hidden depth", or "" if by nothing."""
        if self.against_truth is not None:
            return "truth"
        return "hidden depth" if self.hidden is not None else ""

    @cached_property
    def by_block(self) -> Mapping[int, Judgement]:
        """Block label -> its judgement, by what `judged_by` says."""
        subject = self.subject
        if self.judged_by == "truth":
            return judge_blocks(subject.run.frame, self.by_blocks, subject.run.blocks, expected=self.expected)
        return {} if self.hidden is None else self.hidden.blocks

    def expected_of(self, result: BlockResult) -> float:
        """Root mean square of the expected error [m] over what a block has filled; NaN if that is nothing."""
        box, mask = result.block.box, result.block.mask
        return summarised(self.expected[box][mask & self.by_blocks.filled[box]]).rms

    @cached_property
    def whole_expected(self) -> ErrorSummary:
        """Of all that blocks have filled."""
        return error_summary(self.expected, self.subject.completion)


def _p95(error: NDArray[np.floating]) -> float:
    known = np.abs(error[np.isfinite(error)])
    return float(np.percentile(known, 95)) if known.size else math.nan
