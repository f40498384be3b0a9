"""Brings what there is to compare the present result with to the views: runs, the one before, the truth."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.views.contents.material import ShownRun
from gui.views.contents.names import EARLIER, RUNS
from gui.views.linked_views import LinkedViews
from gui.views.presenter import ViewsPresenter, colour_table
from ilf.outcomes import Completion
from ilf.project.kept_run import KeptRun


class Comparison(QObject):
    """Runs that are ticked for comparison, and what stands in for the result while one looks at side A."""

    def __init__(self, workspace: Workspace, views: LinkedViews, presenter: ViewsPresenter) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._presenter = presenter
        self._session: Session | None = None
        self._runs: tuple[ShownRun | None, ...] = ()
        self._truth: object = None
        self._earlier: Completion | None = None
        self._has_other_blocks = False

    def show(self) -> None:
        """Truth and runs of the present frame, if they are not there yet."""
        session = self._workspace.session if self._workspace.has_session else None
        if session is not self._session:
            self._session, self._truth, self._runs = session, None, ()  # they have gone with the frame before
        if session is None:
            self._earlier = None
            return
        if session.frame.truth is not self._truth:
            self._truth = session.frame.truth
            self._views.set_truth(session.frame.truth)
        earlier = earlier_run(session)
        self._earlier = None if earlier is None else earlier.completion  # else it would be made anew every time
        runs = [_shown(kept, session) for kept in session.compared]
        before = None if earlier is None else _shown(earlier, session)
        if not _same((*runs, before), self._runs):
            self._runs = (*runs, before)
            self._views.set_runs(runs, before)

    def look_at_a(self, on: bool) -> None:
        """Show side A in place of the result, with the blocks that it was run with; or go back."""
        session, side = self._session, self._views.sides.names[0]
        kept = None if session is None else _kept(session, side)
        if on and session is not None and kept is not None and not np.array_equal(kept.run.blocks, session.labels):
            self._has_other_blocks = True
            self._presenter.show_other(kept.run.blocks, kept.completion.depth)
        self._views.sides.look_at_a(on)
        if not on and self._has_other_blocks:
            self._has_other_blocks = False
            self._presenter.show_present()


def earlier_run(session: Session) -> KeptRun | None:
    """The latest kept run that the present result is not of."""
    present = session.valid_results()
    return next(
        (
            kept
            for kept in reversed(session.kept_runs)
            if not all(kept.results.get(label) is result for label, result in present.items())
        ),
        None,
    )


def _kept(session: Session, side: str) -> KeptRun | None:
    """The run that a side of the comparison is of; None if it is of none."""
    if side == EARLIER:
        return earlier_run(session)
    number = RUNS.index(side) if side in RUNS else len(session.compared)
    return session.compared[number] if number < len(session.compared) else None


def _shown(kept: KeptRun, session: Session) -> ShownRun:
    completion, labels = kept.completion, kept.run.blocks
    guessed = completion.guessed if completion.guessed.any() else None
    others = None if np.array_equal(labels, session.labels) else (labels, colour_table(session, int(labels.max())))
    return ShownRun(kept.name, completion.depth, guessed, kept.colour, others)


def _same(some: tuple[ShownRun | None, ...], others: tuple[ShownRun | None, ...]) -> bool:
    """Whether these are the very same depths under the same names."""
    return len(some) == len(others) and all(
        one is other or (one is not None and other is not None and _is_same(one, other))
        for one, other in zip(some, others, strict=True)
    )


def _is_same(one: ShownRun, other: ShownRun) -> bool:
    same_blocks = (one.blocks is None) == (other.blocks is None)  # a run's own never change
    return one.depth is other.depth and (one.name, one.colour) == (other.name, other.colour) and same_blocks
