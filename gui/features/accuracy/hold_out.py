"""Hold-out tests of the current values, of runs and of presets: their results, and whether these are still valid."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from ilf._runtime.formatting import counted
from ilf._runtime.stepping import mapped_steps
from ilf.data.parameters import PRESETS
from ilf.data.presets import list_presets
from ilf.evaluation.evaluation import Evaluated, Evaluation
from ilf.evaluation.hold_out import HoldOutTest, compared_steps, hold_out_steps, untrusted_note
from ilf.evaluation.ties import Ties, find_ties
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ...state.document import Document
from ...work.jobs import spare_cores

CURRENT = "Current values"
_OUTDATED = "Outdated: blocks or depth have changed. Test again."
_OTHER_VALUES = "The current values differ from those tested. Test again."


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

    @property
    def current_result(self) -> CandidateResult | None:
        """Result of the values at the time of the test; None if they were not tested."""
        return next((one for one in self.tested if one.candidate.run is self.present), None)

    def _has_values_of(self, document: Document, label: int) -> bool:
        """Whether the values of a block have the same effect as at the time of the test."""
        return self.present.parameters_of(label).same_effect(document.parameters_of(label))

    def described(self, document: Document) -> tuple[str, str]:
        """Return a text on the test, when it was made and whether it is still valid; and the tone of the message."""
        pattern = "random pixels" if self.test.pattern == "random" else self.test.pattern
        left_out = untrusted_note(self.present.frame)
        seeds = counted(len(self.test.seeds), "seed")
        text = f"Held out: {pattern}, {seeds}, at {self.when:%H:%M}. {left_out}".rstrip()
        if not document.has_inputs_of(self.present):
            return f"{text} {_OUTDATED}", "warning"
        if self.current_result and not all(self._has_values_of(document, label) for label in document.counts()):
            return f"{text} {_OTHER_VALUES}", "warning"
        return text, "muted"

    def errors_of(self, document: Document) -> dict[int, float]:
        """Label -> RMSE [m] of the blocks whose values are unchanged since the test."""
        found = self.current_result
        if found is None or not document.has_inputs_of(self.present):
            return {}
        return {
            label: evaluation.rmse
            for label, evaluation in found.blocks.items()
            if evaluation.pixels and self._has_values_of(document, label)
        }


@dataclass(frozen=True, eq=False)
class HoldOutRequest:
    """A test to make: of which frame and candidates; `present` is the frame with its current blocks and values."""

    document: Document
    candidates: Sequence[Candidate]
    present: Run
    test: HoldOutTest


def candidates(document: Document, present: Run) -> list[tuple[Candidate, bool]]:
    """Candidates, and whether they are initially ticked, as the current values and the compared runs are."""
    found = [(Candidate(CURRENT, present), True)]
    for kept in document.state.runs:
        run = replace(kept.run, only=None, extrapolate=False)
        found.append((Candidate(kept.name, run, kept, kept.run), kept in document.compared))
    presets = PRESETS | {name: preset.parameters for name, preset in list_presets()[0].items()}
    plain = replace(present, blocks=replace(present.blocks, own={}))
    for name, parameters in presets.items():
        found.append((Candidate(f"Preset {name}", replace(plain, parameters=parameters)), False))
    return found


def outcome_steps(request: HoldOutRequest) -> Generator[float, None, HoldOutOutcome]:
    """Test all candidates on the same hold-out; yields shares done. Called in a worker thread."""
    steps = compared_steps([hold_out_steps(one.run, request.test, threads=spare_cores()) for one in request.candidates])
    results = yield from mapped_steps(steps, lambda step: step.share)
    # by the current blocks, also for a run with other blocks
    evaluated = [replace(found, labels=request.present.blocks.labels) for found in results]
    tested = tuple(
        CandidateResult(candidate, found.whole, one.blocks, found.coverage)
        for candidate, found, one in zip(request.candidates, results, evaluated, strict=True)
    )
    best = {0: find_best(evaluated)}
    if len(evaluated) > 1:
        best |= {label: find_best([one.of_block(label) for one in evaluated]) for label in evaluated[0].blocks}
    return HoldOutOutcome(request.test, request.present, tested, best, datetime.now())


def find_best(several: Sequence[Evaluated]) -> Ties | None:
    """The results with the smallest RMSE; those with fewer evaluated pixels are excluded."""
    most = max((one.whole.pixels for one in several), default=0)
    return find_ties(several, [number for number, one in enumerate(several) if one.whole.pixels == most])
