"""The expected error of the completed depth, computed in a worker thread while a view shows it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ilf.completion.confidence.expected_error import expected_error, unsupported
from ilf.data.results import Completion

from ..state.parts import Part
from ..state.results import ErrorEstimate
from ..work.frame_runs import RunState
from .context import Context, Feature


class ErrorFeature(Feature):
    """The expected error. A completion for which it failed is not tried again."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._watchers: list[Callable[[], bool]] = []
        context.refresh.add(
            "error",
            self.ask,
            Part.FRAME | Part.LABELS | Part.RESULTS | Part.EXPECTED_ERROR | Part.RUNNING,
            also=(self.views.shownChanged, context.centre.turned),
        )

    def watch(self, is_seen: Callable[[], bool]) -> None:
        """Compute it also while `is_seen()` is true."""
        self._watchers.append(is_seen)

    def ask(self) -> None:
        """Compute the expected error of the current results if it is visible and no run is changing them."""
        if (document := self.workspace.shown) is None:
            return
        completion = document.completion()
        if (
            completion is not None
            and document.expected_error() is None
            and completion is not self.views.data.without_error
            and (self.views.shows("expected") or any(is_seen() for is_seen in self._watchers))
            and self.context.runs.state in (RunState.IDLE, RunState.PAUSED)
        ):
            self.requests.ask(
                lambda: ErrorEstimate(expected_error(completion), unsupported(completion)),
                partial(document.store_error_estimate, completion),
                partial(self._fail, completion),
                key=completion,
            )

    def _fail(self, completion: Completion, error: Exception) -> None:
        self.views.data.without_error = completion
        self.workspace.note(Part.EXPECTED_ERROR)
        self.notes.report("Expected error", error)
