"""Hold-out tests: candidates, their results, and whether these are still valid."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Self

import numpy as np

from ilf.evaluation.evaluation import Judgement, Step
from ilf.evaluation.hold_out import HiddenResult, HiddenTest, comparison_steps
from ilf.project.run_history import KeptRun
from ilf.run.run import Run

from ...state.results import same_guide, same_mask
from ...state.session import Session
from ...work.jobs import spare_cores

PRESENT = "Current values"


@dataclass(frozen=True, eq=False)
class Candidate:
    """Candidate of a hold-out test.

    Attributes
    ----------
    name : str
    run : Run
    kept : KeptRun or None
        Stored run whose row shows the error.
    kept_as : Run or None
        Its run when it was selected: the row of a slider drag changes to other values.
    """

    name: str
    run: Run
    kept: KeptRun | None = None
    kept_as: Run | None = None

    @classmethod
    def of(cls, kept: KeptRun) -> Self:
        """Candidate of a stored run, with all its blocks."""
        return cls(kept.name, replace(kept.run, only=None, dense=False), kept, kept.run)


@dataclass(frozen=True, eq=False)
class Tested:
    """Result of a candidate: over all blocks, and label of the current map -> Judgement."""

    candidate: Candidate
    whole: Judgement
    blocks: dict[int, Judgement]
    coverage: float


@dataclass(frozen=True, eq=False)
class HiddenOutcome:
    """Outcome of a hold-out test.

    Attributes
    ----------
    test : HiddenTest
    present : Run
        Frame, blocks and values at the time of the test.
    tested : tuple
    when : datetime
    """

    test: HiddenTest
    present: Run
    tested: tuple[Tested, ...]
    when: datetime

    def holds_for(self, session: Session) -> bool:
        """Whether blocks and depth are unchanged since the test."""
        run = self.present
        return (
            np.array_equal(session.labels, run.blocks)
            and same_mask(session.frame.distrusted, run.frame.distrusted)
            and same_guide(session.frame.guide, run.frame.guide)
            and same_mask(session.notes.drawn, run.drawn)
        )

    @property
    def of_present(self) -> Tested | None:
        """Result of the values at the time of the test; None if they were not tested."""
        return next((one for one in self.tested if one.candidate.run is self.present), None)

    def has_values_of(self, session: Session) -> bool:
        """Whether the values have the same effect as at the time of the test."""
        return all(self._has_values_of(session, label) for label in session.counts())

    def _has_values_of(self, session: Session, label: int) -> bool:
        return self.present.parameters_of(label).same_effect(session.parameters_of(label, session.common))

    def errors_of(self, session: Session) -> dict[int, float]:
        """Label -> RMSE [m] of the blocks whose values are unchanged since the test."""
        found = self.of_present
        if found is None or not self.holds_for(session):
            return {}
        return {
            label: judgement.rmse
            for label, judgement in found.blocks.items()
            if judgement.pixels and self._has_values_of(session, label)
        }


def outcome_steps(
    candidates: Sequence[Candidate], present: Run, test: HiddenTest
) -> Generator[Step, None, HiddenOutcome]:
    """Test all candidates on the same hold-out, step by step; called in a worker thread."""
    results = yield from comparison_steps([candidate.run for candidate in candidates], test, threads=spare_cores())
    tested = tuple(_tested(candidate, found, present) for candidate, found in zip(candidates, results, strict=True))
    return HiddenOutcome(test, present, tested, datetime.now())


def _tested(candidate: Candidate, found: HiddenResult, present: Run) -> Tested:
    # evaluate by the current blocks, also for a run with other blocks
    judged = replace(found.judged, labels=present.blocks)
    return Tested(candidate, found.whole, judged.blocks, found.coverage)
