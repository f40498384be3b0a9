"""The expected error of the completed depth, computed in a worker thread while a view shows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.completion.confidence.expected_error import expected_error, unsupported
from ilf.data.results import Completion

from ..state.results import ErrorEstimate
from ..state.session import Session
from ..state.workspace import Workspace
from ..work.frame_runs import RunState
from ..work.latest_request import LatestRequest
from ..work.runs import RunController
from .linked_views import LinkedViews


class _Question(NamedTuple):
    session: Session
    completion: Completion


class ErrorPresenter(QObject):
    """Presenter of the expected error. A completion for which it failed is not tried again.

    Signals
    -------
    failed(object)
        The exception that stopped the computation of an expected error.
    """

    failed = Signal(object)

    def __init__(self, workspace: Workspace, runs: RunController, views: LinkedViews) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._runs = runs
        self._views = views
        self._session: Session | None = None
        self._shown: NDArray[np.float32] | None = None
        self._failed_completion: Completion | None = None
        self._watchers: list[Callable[[], bool]] = []
        self._questions = LatestRequest[_Question, ErrorEstimate](_find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether an expected error is being computed."""
        return self._questions.busy

    def watch(self, is_seen: Callable[[], bool]) -> None:
        """Compute it also while `is_seen()` is true."""
        self._watchers.append(is_seen)

    def show(self) -> None:
        """Show the expected error of the current results; compute it if it is visible and no run is changing them."""
        if not self._workspace.has_session:
            self._session = self._shown = None
            return
        session = self._workspace.session
        if session is not self._session:
            self._session, self._shown = session, None
        completion, error = session.completion(), session.expected_error()
        # the last error stays until a newer one is available, as the depth does
        hopeless = completion is not None and completion is self._failed_completion
        outdated = error is None and session.current_depth() is not None and not hopeless
        if error is not self._shown and not outdated:
            self._shown = error
            self._views.set_expected_error(error, session.unsupported())
        self._views.mark_error_outdated(outdated)
        if (
            completion is not None
            and error is None
            and completion is not self._failed_completion
            and (self._views.shows_expected_error or any(is_seen() for is_seen in self._watchers))
            and self._runs.state in (RunState.IDLE, RunState.PAUSED)
        ):
            self._questions.ask(_Question(session, completion))

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, question: _Question, error_estimate: ErrorEstimate) -> None:
        self._workspace.runs.store_error_estimate(question.session, question.completion, error_estimate)

    def _fail(self, question: _Question, error: Exception) -> None:
        self._failed_completion = question.completion
        self.failed.emit(error)


def _find(question: _Question) -> ErrorEstimate:
    """Compute the estimate; runs in a worker thread."""
    return ErrorEstimate(expected_error(question.completion), unsupported(question.completion))
