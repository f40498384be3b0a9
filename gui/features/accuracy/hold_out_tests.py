"""Hold-out tests: candidates, their results, and whether these are still valid."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Self

import numpy as np

from ilf.evaluation.evaluation import Evaluated, Evaluation, Progress
from ilf.evaluation.hold_out import HoldOutTest, comparison_steps
from ilf.evaluation.ties import Ties, find_ties
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ...state.document import Document
from ...state.results import same_depth, same_mask
from ...work.jobs import spare_cores

CURRENT = "Current values"


@dataclass(frozen=True, eq=False)
class Candidate:
    """Candidate of a hold-out test.

    Attributes
    ----------
    name : str
    run : Run
    kept : StoredRun or None
        Stored run whose row shows the error.
    run_when_selected : Run or None
        Its run when it was selected: the row of a slider drag changes to other values.
    """

    name: str
    run: Run
    kept: StoredRun | None = None
    run_when_selected: Run | None = None

    @classmethod
    def of(cls, kept: StoredRun) -> Self:
        """Candidate of a stored run, with all its blocks."""
        return cls(kept.name, replace(kept.run, only=None, extrapolate=False), kept, kept.run)


@dataclass(frozen=True, eq=False)
class CandidateResult:
    """Result of a candidate: over all blocks, and label of the current map -> Evaluation."""

    candidate: Candidate
    whole: Evaluation
    blocks: dict[int, Evaluation]
    coverage: float


@dataclass(frozen=True, eq=False)
class HoldOutOutcome:
    """Outcome of a hold-out test.

    Attributes
    ----------
    test : HoldOutTest
    present : Run
        Frame, blocks and values at the time of the test.
    tested : tuple
    best : mapping of int to (Ties or None)
        Label of the current map, 0 for all blocks -> those with the smallest error.
    when : datetime
    """

    test: HoldOutTest
    present: Run
    tested: tuple[CandidateResult, ...]
    best: Mapping[int, Ties | None]
    when: datetime

    def is_valid_for(self, document: Document) -> bool:
        """Whether blocks and depth are unchanged since the test."""
        run = self.present
        return (
            np.array_equal(document.labels, run.blocks.labels)
            and same_mask(document.frame.invalid_mask, run.frame.invalid_mask)
            and same_depth(document.frame.guide, run.frame.guide)
            and same_depth(document.frame.neighbours, run.frame.neighbours)
            and same_mask(document.blocks.drawn, run.blocks.drawn)
            and same_depth(document.blocks.by_hand, run.blocks.by_hand)
        )

    @property
    def current_result(self) -> CandidateResult | None:
        """Result of the values at the time of the test; None if they were not tested."""
        return next((one for one in self.tested if one.candidate.run is self.present), None)

    def has_values_of(self, document: Document) -> bool:
        """Whether the values have the same effect as at the time of the test."""
        return all(self._has_values_of(document, label) for label in document.counts())

    def _has_values_of(self, document: Document, label: int) -> bool:
        return self.present.parameters_of(label).same_effect(document.parameters_of(label))

    def errors_of(self, document: Document) -> dict[int, float]:
        """Label -> RMSE [m] of the blocks whose values are unchanged since the test."""
        found = self.current_result
        if found is None or not self.is_valid_for(document):
            return {}
        return {
            label: evaluation.rmse
            for label, evaluation in found.blocks.items()
            if evaluation.pixels and self._has_values_of(document, label)
        }


def outcome_steps(
    candidates: Sequence[Candidate], present: Run, test: HoldOutTest
) -> Generator[Progress, None, HoldOutOutcome]:
    """Test all candidates on the same hold-out, step by step; called in a worker thread."""
    results = yield from comparison_steps([candidate.run for candidate in candidates], test, threads=spare_cores())
    # by the current blocks, also for a run with other blocks
    evaluated = [replace(found.evaluated, labels=present.blocks.labels) for found in results]
    tested = tuple(
        CandidateResult(candidate, found.whole, one.blocks, found.coverage)
        for candidate, found, one in zip(candidates, results, evaluated, strict=True)
    )
    best = {0: find_best(evaluated)}
    if len(evaluated) > 1:
        best |= {label: find_best([one.of_block(label) for one in evaluated]) for label in evaluated[0].blocks}
    return HoldOutOutcome(test, present, tested, best, datetime.now())


def find_best(several: Sequence[Evaluated]) -> Ties | None:
    """The results with the smallest RMSE; those with fewer evaluated pixels are excluded."""
    most = max((one.whole.pixels for one in several), default=0)
    return find_ties(several, [number for number, one in enumerate(several) if one.whole.pixels == most])
