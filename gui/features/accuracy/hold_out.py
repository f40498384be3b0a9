"""Hold-out tests of the current values, of runs and of presets: the dialog, the results, and whether these are still
valid."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QListWidget, QListWidgetItem, QWidget

from ilf._runtime.formatting import UNKNOWN, counted
from ilf._runtime.long_work import mapped_steps
from ilf.data.parameters import PRESETS
from ilf.data.presets import list_presets
from ilf.evaluation.evaluation import Evaluation
from ilf.evaluation.hold_out import HoldOutTest, compared_steps, hold_out_steps, untrusted_note
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ...state.document import Document
from ...widgets.basics import Message, PlainLabel, answers, form, label_of, stack
from ...widgets.hold_out_choice import HoldOutChoice
from ...widgets.row_table import NumberRow
from ...work.jobs import spare_cores
from .evaluation import COLUMNS, AreaErrors, area_errors

HOLD_OUT_COLUMNS = (*COLUMNS, ("Pixels", "Number of evaluated pixels"))

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
    """

    name: str
    run: Run
    kept: StoredRun | None = None


@dataclass(frozen=True, eq=False)
class HoldOutOutcome:
    """Outcome of a hold-out test.

    Attributes
    ----------
    test : HoldOutTest
    present : Run
        Frame, blocks and values at the time of the test.
    candidates : sequence of Candidate
    coverage : sequence of float
        Share of the held-out depth that each of them has filled.
    errors : mapping of int to AreaErrors
        Label of the current map, 0 for all blocks -> errors of the candidates.
    when : datetime
    """

    test: HoldOutTest
    present: Run
    candidates: Sequence[Candidate]
    coverage: Sequence[float]
    errors: Mapping[int, AreaErrors]
    when: datetime

    @property
    def _current(self) -> int | None:
        """Number of the candidate with the values at the time of the test; None if they were not tested."""
        numbers = (number for number, one in enumerate(self.candidates) if one.run is self.present)
        return next(numbers, None)

    def rows(self, label: int) -> list[NumberRow]:
        """Return the rows of the table: the candidates, over all blocks (0) or over one."""
        rows = []
        area = self.errors.get(label) or AreaErrors((Evaluation(),) * len(self.candidates), None)
        for number, (candidate, one) in enumerate(zip(self.candidates, area.evaluated, strict=True)):
            filled = f"{self.coverage[number]:.1%} of the held-out depth was filled."
            hint = f"{candidate.name}: {one.pixels:,} pixels. {filled}"
            if one.within is not None:
                hint += f" {one.within:.0%} of the errors are within the expected error."
            colour = None if candidate.kept is None else candidate.kept.colour
            rows.append(area.row(number, candidate.name, hint, _count(one.pixels), colour))
        return rows

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
        if self._current is not None and not all(self._has_values_of(document, label) for label in document.counts()):
            return f"{text} {_OTHER_VALUES}", "warning"
        return text, "muted"

    def errors_of(self, document: Document) -> dict[int, float]:
        """Label -> RMSE [m] of the blocks whose values are unchanged since the test."""
        number = self._current
        if number is None or not document.has_inputs_of(self.present):
            return {}
        found = {label: area.evaluated[number] for label, area in self.errors.items() if label}
        return {
            label: evaluation.rmse
            for label, evaluation in found.items()
            if evaluation.pixels and self._has_values_of(document, label)
        }


def _count(pixels: int) -> str:
    """Short text of a number of pixels, as "122k"."""
    return f"{pixels / 1000:.0f}k" if pixels >= 10_000 else str(pixels) if pixels else UNKNOWN


def candidates(document: Document, present: Run, tested: Collection[str]) -> list[tuple[Candidate, bool]]:
    """Candidates, and whether they are initially ticked, as the current values, the compared runs and those that were
    `tested` last are."""
    found = [(Candidate(CURRENT, present), True)]
    for kept in document.state.runs:
        found.append((Candidate(kept.name, kept.run, kept), kept in document.compared or kept.name in tested))
    presets = PRESETS | {name: preset.parameters for name, preset in list_presets()[0].items()}
    plain = replace(present, blocks=replace(present.blocks, own={}))
    for name, parameters in presets.items():
        title = f"Preset {name}"
        found.append((Candidate(title, replace(plain, parameters=parameters)), title in tested))
    return found


def outcome_steps(
    chosen: Sequence[Candidate], present: Run, test: HoldOutTest
) -> Generator[float, None, HoldOutOutcome]:
    """Test candidates on the same hold-out; yields shares done. Called in a worker thread.

    `present` is the frame with its current blocks and values.
    """
    runs = [replace(one.run, only=None, extrapolate=False) for one in chosen]
    steps = compared_steps([hold_out_steps(run, test, threads=spare_cores()) for run in runs])
    results = yield from mapped_steps(steps, lambda step: step.share)
    # by the current blocks, also for a run with other blocks
    evaluated = [replace(found, labels=present.blocks.labels) for found in results]
    errors = {0: area_errors(evaluated)}
    for label in evaluated[0].blocks:
        errors[label] = area_errors([one.of_block(label) for one in evaluated])
    return HoldOutOutcome(test, present, chosen, [found.coverage for found in results], errors, datetime.now())


class HoldOutDialog(QDialog):
    """Dialog of the hold-out test: the hold-out, and candidates with a tick each.

    Parameters
    ----------
    frame_name : str
    candidates : sequence of (Candidate, bool)
        What can be tested, and whether it is initially ticked.
    """

    def __init__(self, frame_name: str, candidates: Sequence[tuple[Candidate, bool]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Hold-out test of {frame_name}")
        about = Message(lines=2)
        about.show_message(
            "Hides some known depth, completes the blocks without it, and compares the result with it. All ticked "
            "candidates are evaluated on the same pixels."
        )
        self.hold_out = HoldOutChoice()
        self.candidates = QListWidget()
        self.candidates.setToolTip("Candidates; tick those to test and compare")
        for candidate, ticked in candidates:
            item = QListWidgetItem(candidate.name, self.candidates)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            item.setData(Qt.ItemDataRole.UserRole, candidate)
            item.setCheckState(Qt.CheckState.Checked if ticked else Qt.CheckState.Unchecked)
        self.amount = PlainLabel()
        hint = "Test the ticked candidates in the background; the panel Accuracy shows the errors"
        buttons, self.test_button = answers(self, QDialogButtonBox.StandardButton.Ok, "&Test", hint)
        self.candidates.itemChanged.connect(lambda _: self._describe())
        self.hold_out.changed.connect(self._describe)

        choices = form(("&Hide", self.hold_out))
        label = label_of("&Candidates", self.candidates)
        stack(self, about, choices, label, self.candidates, self.amount, buttons, stretched=self.candidates)
        self.resize(430, 440)
        self._describe()

    def chosen(self) -> list[Candidate]:
        """The ticked candidates."""
        items = (self.candidates.item(number) for number in range(self.candidates.count()))
        return [item.data(Qt.ItemDataRole.UserRole) for item in items if item.checkState() == Qt.CheckState.Checked]

    def _describe(self) -> None:
        runs = len(self.chosen()) * len(self.hold_out.test().seeds)
        self.test_button.setEnabled(runs > 0)
        self.amount.setText(counted(runs, "run") if runs else "Tick at least one candidate.")
