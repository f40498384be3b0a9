"""What was tested on hidden depth: candidates, what came of each, and whether it still holds."""

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

PRESENT = "Present values"


@dataclass(frozen=True, eq=False)
class Candidate:
    """What is tested.

    Attributes
    ----------
    name : str
    run : Run
    kept : KeptRun or None
        Whose row gets the error.
    kept_as : Run or None
        What that was made of when it was chosen: the row of a drag goes on to other values.
    """

    name: str
    run: Run
    kept: KeptRun | None = None
    kept_as: Run | None = None

    @classmethod
    def of(cls, kept: KeptRun) -> Self:
        """A kept run, of all its blocks."""
        return cls(kept.name, replace(kept.run, only=None, dense=False), kept, kept.run)


@dataclass(frozen=True, eq=False)
class Tested:
    """What came of a candidate: over all blocks, and label of the present map -> Judgement."""

    candidate: Candidate
    whole: Judgement
    blocks: dict[int, Judgement]
    coverage: float


@dataclass(frozen=True, eq=False)
class HiddenOutcome:
    """A test that has been made.

    Attributes
    ----------
    test : HiddenTest
    present : Run
        The frame, blocks and values as they were.
    tested : tuple of Tested
    when : datetime
    """

    test: HiddenTest
    present: Run
    tested: tuple[Tested, ...]
    when: datetime

    def holds_for(self, session: Session) -> bool:
        """Whether blocks and depth are still what was tested."""
        run = self.present
        return (
            np.array_equal(session.labels, run.blocks)
            and same_mask(session.frame.distrusted, run.frame.distrusted)
            and same_guide(session.frame.guide, run.frame.guide)
            and same_mask(session.notes.drawn, run.drawn)
        )

    @property
    def of_present(self) -> Tested | None:
        """What came of the values as they were; None if they were not tested."""
        return next((one for one in self.tested if one.candidate.run is self.present), None)

    def has_values_of(self, session: Session) -> bool:
        """Whether the values are still those that were tested, as far as they have any effect."""
        return all(self._has_values_of(session, label) for label in session.counts())

    def _has_values_of(self, session: Session, label: int) -> bool:
        return self.present.parameters_of(label).same_effect(session.parameters_of(label, session.common))

    def errors_of(self, session: Session) -> dict[int, float]:
        """Label -> RMSE [m] of the blocks whose values are still those that were tested."""
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
    """Test all candidates on the same hidden depth, a step at a time; called off the GUI's thread."""
    results = yield from comparison_steps([candidate.run for candidate in candidates], test, threads=spare_cores())
    tested = tuple(_tested(candidate, found, present) for candidate, found in zip(candidates, results, strict=True))
    return HiddenOutcome(test, present, tested, datetime.now())


def _tested(candidate: Candidate, found: HiddenResult, present: Run) -> Tested:
    # blocks are those of now, also for a run that had others
    judged = replace(found.judged, labels=present.blocks)
    return Tested(candidate, found.whole, judged.blocks, found.coverage)
