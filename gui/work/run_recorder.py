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

from ..state.parameters import EditParameters
from ..state.run_history import MAX_MEMORY, MAX_STORED, memory_of, next_colour, run_name, with_shared_arrays
from ..state.session import Session
from ..state.workspace import Workspace
from .frame_runs import RunOutcome, RunState
from .runs import RunController

REST_MS = 400
"""Time [ms] without a re-solve after which its results are stored."""


_Step = ReferenceType[QUndoCommand] | None
"""An undo step, None for none. A weak reference, because steps reference their session."""


class _Solved(NamedTuple):
    """A re-solve, the undo step before it, and the name of the edit that started it."""

    ended: RunOutcome
    step: _Step
    edit: str


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
        self._waiting: dict[Session, _Solved] = {}
        self._live: WeakKeyDictionary[Session, _LiveRow] = WeakKeyDictionary()
        self._warned: WeakSet[Session] = WeakSet()
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._keep_rested)
        runs.run_ended.connect(self._take)
        runs.finished.connect(self._take_extrapolation)

    @property
    def waits(self) -> bool:
        """Whether re-solved blocks wait to be stored."""
        return bool(self._waiting)

    def shutdown(self) -> bool:
        """Stop storing runs. Always True: there is no thread."""
        self._rest.stop()
        return True

    def _take(self, ended: RunOutcome) -> None:
        session = ended.session
        if session not in self._workspace.frames.sessions:
            self._waiting.pop(session, None)
            return
        if ended.done and ended.resolved:
            step = _last_step(session)
            self._waiting[session] = _Solved(ended, None if step is None else ref(step), _edit(step))
        elif ended.done:
            self._waiting.pop(session, None)
            self._live.pop(session, None)
            run = replace(ended.run, only=None)
            self._keep(run, session.results_of(run), ended)
        if session in self._waiting:
            self._rest.start()

    def _keep_rested(self) -> None:
        for session, solved in list(self._waiting.items()):
            if session not in self._workspace.frames.sessions:
                del self._waiting[session]
            elif self._runs.of(session).state is RunState.IDLE:  # else `run_ended` follows
                del self._waiting[session]
                self._keep_solved(session, solved)

    def _keep_solved(self, session: Session, solved: _Solved) -> None:
        results = session.valid_results()
        if not results:
            return
        same = next((kept for kept in reversed(session.state.runs) if kept.equals(results)), None)
        if same is not None:
            same.results = dict(results)  # the current objects, so that the equal ones can be freed
            self._workspace.runs.note_changed(session, same)
            return
        ended, step, edit = solved
        run = session.run(session.state.common)
        live = self._live.get(session)
        if live is not None and live.step == step and live.kept in session.state.runs:
            kept, former = live.kept, live.name
            kept.take(with_shared_arrays(run, session.state.runs), dict(results))
            kept.seconds, kept.done = ended.seconds, kept.done | ended.done
            name = run_name(session, kept.number, run, edit, live=True)
            kept.name = name if kept.name == former else kept.name
            self._workspace.runs.note_changed(session, kept)
        else:
            kept = self._keep(run, dict(results), ended, edit, live=True)
            name = kept.name
        self._live[session] = _LiveRow(step, kept, name)

    def _keep(
        self, run: Run, results: dict[int, BlockResult], ended: RunOutcome, edit: str = "", live: bool = False
    ) -> StoredRun:
        session = ended.session
        number = session.state.next_number
        kept = StoredRun(
            number,
            run_name(session, number, run, edit, live),
            with_shared_arrays(run, session.state.runs),
            results,
            ended.seconds,
            next_colour(session.state.runs),
            done=ended.done,
            how=ended.how,
        )
        self._workspace.runs.keep(session, kept)
        self._drop_oldest(session)
        return kept

    def _drop_oldest(self, session: Session) -> None:
        """Remove the oldest runs without a note that are not compared, beyond a number or a size."""
        dropped = 0
        for kept in session.state.runs[:-1]:
            if len(session.state.runs) <= MAX_STORED and memory_of(session.state.runs) <= MAX_MEMORY:
                break
            if not kept.note and kept not in session.compared:
                self._workspace.runs.drop(session, kept)
                dropped += 1
        if dropped and session not in self._warned:
            self._warned.add(session)
            self.message.emit(
                f"{session.name}: the run history is full ({len(session.state.runs)} runs). New runs replace the "
                "oldest ones; runs with a note are kept."
            )

    def _take_extrapolation(self, session: Session) -> None:
        completion = session.completion()
        if completion is None or not session.extrapolated:
            return
        results = session.valid_results()
        kept = next((kept for kept in reversed(session.state.runs) if kept.is_of(results)), None)
        if kept is not None:
            kept.take_extrapolation(completion)
            self._workspace.runs.note_changed(session, kept)


def _last_step(session: Session) -> QUndoCommand | None:
    stack = session.undo_stack
    return stack.command(stack.index() - 1) if stack.index() > 0 else None


def _edit(step: QUndoCommand | None) -> str:
    """Return the name of an edit; "" for a change of parameters, which the run's name lists anyway."""
    return "" if step is None or isinstance(step, EditParameters) else step.text()
