"""The run history of frames: how runs are added, every run, and re-solves once the parameters have not changed for a
moment; limits of a history, and names of its runs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple
from weakref import ReferenceType, WeakKeyDictionary, WeakSet, ref

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QUndoCommand

from ilf.data.blocks import Colour
from ilf.data.parameters import Parameters, nearest_preset, to_text
from ilf.data.results import BlockResult, Completion
from ilf.project.run_history import Extrapolation, StoredRun
from ilf.run.run import Run

from ..state.document import RUN_COLOURS, Document
from ..state.parameters import EditParameters
from ..state.workspace import Workspace
from .frame_runs import RunController, RunState, Work

MAX_STORED = 200
"""Maximum number of runs in a frame's history; beyond it, the oldest run without a note is removed."""

MAX_MEMORY = 400 * 1024**2
"""Maximum memory [bytes] of a history: label maps of a frame that is edited often add up."""

_RECORD = 280
"""Approximate memory [bytes] of an iteration's record."""

_IN_NAMES = 2
"""Maximum number of parameters in a name."""

REST_MS = 400
"""Time [ms] without a re-solve after which its results are stored."""


_Step = ReferenceType[QUndoCommand] | None
"""An undo step, None for none. A weak reference, because steps reference their document."""


_Solved = tuple[Work, _Step, str]
"""A re-solve, the undo step before it, and the name of the edit that started it."""


class _LiveRow(NamedTuple):
    """The stored run of the latest undo step with a re-solve, and its default name."""

    step: _Step
    kept: StoredRun
    name: str


class RunRecorder(QObject):
    """Stores runs in the history as they end.

    Re-solves after the same undo step are one run, which is updated while the step continues; a state that undo
    restores is not stored again.

    Signals
    -------
    message(str)
        A message for the status bar.
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace, runs: RunController, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._runs = runs
        self._waiting: dict[Document, _Solved] = {}
        self._live: WeakKeyDictionary[Document, _LiveRow] = WeakKeyDictionary()
        self._warned: WeakSet[Document] = WeakSet()
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._keep_rested)
        runs.run_ended.connect(self._take)
        runs.finished.connect(self._take_extrapolation)

    @property
    def waits(self) -> bool:
        """Whether re-solved blocks wait to be stored."""
        return bool(self._waiting)

    def _take(self, ended: Work) -> None:
        document = ended.document
        if document not in self._workspace.open:
            self._waiting.pop(document, None)
            return
        if ended.done and ended.resolves:
            step = _last_step(document)
            self._waiting[document] = ended, None if step is None else ref(step), _edit(step)
        elif ended.done:
            self._waiting.pop(document, None)
            self._live.pop(document, None)
            run = replace(ended.run, only=None)
            self._keep(run, document.results_of(run), ended)
        if document in self._waiting:
            self._rest.start()

    def _keep_rested(self) -> None:
        for document, solved in list(self._waiting.items()):
            if document not in self._workspace.open:
                del self._waiting[document]
            elif self._runs.of(document).state is RunState.IDLE:  # else `run_ended` follows
                del self._waiting[document]
                self._keep_solved(document, solved)

    def _keep_solved(self, document: Document, solved: _Solved) -> None:
        results = document.valid_results()
        if not results:
            return
        same = next((kept for kept in reversed(document.state.runs) if kept.equals(results)), None)
        if same is not None:
            # the current objects, so that the equal ones can be freed
            document.change_run(same, results=dict(results))
            return
        ended, step, edit = solved
        run = document.run(document.state.common)
        live = self._live.get(document)
        if live is not None and live.step == step and live.kept in document.state.runs:
            kept, former = live.kept, live.name
            kept.take(with_shared_arrays(run, document.state.runs), dict(results))
            name = run_name(document, kept.number, run, edit, live=True)
            shown = name if kept.name == former else kept.name
            document.change_run(kept, seconds=ended.seconds, done=kept.done | ended.done, name=shown)
        else:
            kept = self._keep(run, dict(results), ended, edit, live=True)
            name = kept.name
        self._live[document] = _LiveRow(step, kept, name)

    def _keep(
        self, run: Run, results: dict[int, BlockResult], ended: Work, edit: str = "", live: bool = False
    ) -> StoredRun:
        document = ended.document
        number = document.state.next_number
        kept = StoredRun(
            number,
            run_name(document, number, run, edit, live),
            with_shared_arrays(run, document.state.runs),
            results,
            ended.seconds,
            next_colour(document.state.runs),
            done=frozenset(ended.done),
            how=ended.how,
        )
        document.keep_run(kept)
        self._drop_oldest(document)
        return kept

    def _drop_oldest(self, document: Document) -> None:
        """Remove the oldest runs without a note that are not compared, beyond a number or a size."""
        left, dropped = list(document.state.runs), []
        for kept in document.state.runs[:-1]:
            if len(left) <= MAX_STORED and memory_of(left) <= MAX_MEMORY:
                break
            if not kept.note and kept not in document.compared:
                left.remove(kept)
                dropped.append(kept)
        if dropped:
            document.drop_runs(dropped)
        if dropped and document not in self._warned:
            self._warned.add(document)
            self.message.emit(
                f"{document.name}: the run history is full ({len(left)} runs). New runs replace the "
                "oldest ones; runs with a note are kept."
            )

    def _take_extrapolation(self, document: Document) -> None:
        completion = document.completion()
        if completion is None or not document.extrapolated:
            return
        results = document.valid_results()
        kept = next((kept for kept in reversed(document.state.runs) if kept.is_of(results)), None)
        if kept is not None:
            kept.take_extrapolation(completion)
            document.change_run(kept)


def _last_step(document: Document) -> QUndoCommand | None:
    stack = document.undo_stack
    return stack.command(stack.index() - 1) if stack.index() > 0 else None


def _edit(step: QUndoCommand | None) -> str:
    """Return the name of an edit; "" for a change of parameters, which the run's name lists anyway."""
    return "" if step is None or isinstance(step, EditParameters) else step.text()


def with_shared_arrays(run: Run, kept: Sequence[StoredRun]) -> Run:
    """Return the run, sharing label map and drawn borders with a stored run where they are equal."""
    for other in reversed(kept):
        ours, theirs = run.blocks, other.run.blocks
        if np.array_equal(theirs.labels, ours.labels):
            same = ours.drawn is not None and theirs.drawn is not None and np.array_equal(ours.drawn, theirs.drawn)
            drawn = theirs.drawn if same else ours.drawn
            return replace(run, blocks=replace(ours, labels=theirs.labels, drawn=drawn))
    return run


def memory_of(kept: Iterable[StoredRun]) -> int:
    """Return the memory [bytes] of all runs together, without their frames."""
    sizes: dict[int, int] = {}
    for one in kept:
        added = () if one.extrapolation is None else one.extrapolation[:2]
        blocks = one.run.blocks
        by_hand = None if blocks.by_hand is None else blocks.by_hand.depth
        arrays = [blocks.labels, blocks.drawn, blocks.extracted, by_hand, *added]
        sizes |= {id(array): array.nbytes for array in arrays if array is not None}
        sizes |= {
            id(result): result.depth.nbytes + result.block.mask.nbytes + _RECORD * len(result.history)
            for result in one.results.values()
        }
    return sum(sizes.values())


def next_colour(kept: Collection[StoredRun]) -> Colour:
    """Return a colour that none of the latest runs has."""
    latest = [one.colour for one in kept][-len(RUN_COLOURS) + 1 :]
    return next(colour for colour in RUN_COLOURS if colour not in latest)


def parameters_text(document: Document, run: Run, max_values: int | None = None) -> str:
    """Return the nearest preset, the parameters that differ from it and own parameters of blocks; `max_values` of
    each."""
    texts = [_likeness_text(run.parameters, max_values)]
    own = {label: _own_words(run.parameters_of(label), run.parameters, max_values) for label in run.blocks.own}
    own = {label: words for label, words in own.items() if words}
    if max_values is not None and len(own) > 1:
        return f"{texts[0]}; {len(own)} blocks with own parameters"
    texts += [f"{document.info(label).name}: {words}" for label, words in own.items()]
    return "; ".join(texts)


def run_name(document: Document, number: int, run: Run, edit: str = "", live: bool = False) -> str:
    """Return the default name of a run: its number, the edit that started it if any, and its parameters."""
    what = "; ".join(([edit] if edit else []) + [parameters_text(document, run, _IN_NAMES)])
    return f"{'Live' if live else 'Run'} {number}: {what}"


def first_run(document: Document, completion: Completion) -> StoredRun:
    """Return the run of a record as the first of a frame's history."""
    run, results = replace(completion.run, only=None), completion.results
    extrapolation = Extrapolation.of(completion) if completion.run.extrapolate else None
    name, done = run_name(document, 1, run), frozenset(results)
    return StoredRun(1, name, run, results, 0.0, RUN_COLOURS[0], done=done, extrapolation=extrapolation)


def title_of(name: str, document: Document, run: Run) -> str:
    """Return a name without the parameters of its default name; unchanged if they are not in it."""
    return name.removesuffix(parameters_text(document, run, _IN_NAMES)).rstrip(":; ") or name


# cached: every row needs these whenever the list changes


@lru_cache(maxsize=512)
def _likeness_text(parameters: Parameters, max_values: int | None) -> str:
    return nearest_preset(parameters).text(max_values)


@lru_cache(maxsize=2048)
def _own_words(parameters: Parameters, common: Parameters, max_values: int | None) -> str:
    return ", ".join(to_text(parameters.differences_from(common), max_values))
