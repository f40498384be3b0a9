"""How good kept runs are: worked out one after the other, off the GUI's thread, while the frame does not run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.latest_question import LatestQuestion
from gui.work.runs import RunController, RunState
from ilf.confidence import error_summary, expected_error
from ilf.frame import RGBDFrame
from ilf.judgement import judge
from ilf.outcomes import BlockResult, compose
from ilf.project.kept_run import KeptRun

Truth = NDArray[np.float32] | None


@dataclass(frozen=True, eq=False)
class _Question:
    """A kept run with its results as they are, and what they are to be compared with."""

    session: Session
    kept: KeptRun
    frame: RGBDFrame
    results: Mapping[int, BlockResult]
    truth: Truth


@dataclass(frozen=True)
class Measures:
    """Root mean squares [m] over the pixels that a run's blocks have filled; NaN where there is none."""

    truth_error: float = math.nan
    expected_error: float = math.nan


class RunMeasurer(QObject):
    """Works out what the list of kept runs lacks of the present frame's runs, the latest first.

    Signals
    -------
    failed(object)
        The exception that kept a run from being measured.
    """

    failed = Signal(object)

    def __init__(self, workspace: Workspace, runs: RunController, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._runs = runs
        self._questions = LatestQuestion[_Question, Measures](_answer, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether measures are to come."""
        return self._questions.busy

    def go_on(self) -> None:
        """Measure the next run, if there is one."""
        if not self._workspace.has_session or self._questions.busy:
            return
        session = self._workspace.session
        if self._runs.state not in (RunState.IDLE, RunState.PAUSED):
            return
        lacking = (kept for kept in reversed(session.kept_runs) if None in (kept.truth_error, kept.expected_error))
        kept = next(lacking, None)
        if kept is not None:
            self._questions.ask(_Question(session, kept, kept.run.frame, kept.results, session.frame.truth))

    def shutdown(self) -> bool:
        """Stop for good. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, question: _Question, measures: Measures) -> None:
        kept, session = question.kept, question.session
        if kept.results is question.results and session.frame.truth is question.truth:
            kept.truth_error, kept.expected_error = measures.truth_error, measures.expected_error
            self._workspace.note_measured(session)
        self.go_on()

    def _fail(self, question: _Question, error: Exception) -> None:
        self._take(question, Measures())
        self.failed.emit(error)


def measure(frame: RGBDFrame, results: Mapping[int, BlockResult], truth: Truth) -> Measures:
    """How good results of a frame's blocks are, by a truth [m] if there is one."""
    completion = compose(frame, results)
    if not completion.filled.any():
        return Measures()
    return Measures(
        truth_error=math.nan if truth is None else judge(completion.depth, truth, completion.filled).rmse,
        expected_error=error_summary(expected_error(frame, completion), completion).rms,
    )


def _answer(question: _Question) -> Measures:
    """Off the GUI's thread."""
    return measure(question.frame, question.results, question.truth)
