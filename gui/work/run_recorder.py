"""Adds runs to the run history: every run, and re-solves once the parameters have not changed for a moment."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple
from weakref import ReferenceType, WeakKeyDictionary, WeakSet, ref

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QUndoCommand

from ilf.data.results import BlockResult
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ..state.document import Document
from ..state.parameters import EditParameters
from ..state.run_history import MAX_MEMORY, MAX_STORED, memory_of, next_colour, run_name, with_shared_arrays
from ..state.workspace import Workspace
from .frame_runs import RunController, RunState, Work

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
