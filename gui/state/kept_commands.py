"""Undoable commands on kept runs: to delete some, and to have the results of one for the present ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from PySide6.QtGui import QUndoCommand

from gui.state.commands import Notices
from gui.state.results import Held
from gui.state.session import Session
from ilf.outcomes import BlockResult
from ilf.project.kept_run import KeptRun
from ilf.project.own_values import OwnValues, own_values


class KeptNotices(Notices, Protocol):
    """Who is told, also of kept runs."""

    def take_kept_runs(self, session: Session, runs: list[KeptRun], compared: list[KeptRun]) -> None:
        """Other runs are kept, and others of them compared."""
        ...


class DeleteRuns(QUndoCommand):
    """Some runs are kept no longer. Undo brings them back beside those that have been kept since."""

    def __init__(self, notices: KeptNotices, session: Session, runs: Collection[KeptRun]) -> None:
        super().__init__(f"Delete {next(iter(runs)).name}" if len(runs) == 1 else f"Delete {len(runs)} runs")
        self._notices = notices
        self._session = session
        self._runs = list(runs)
        self._compared = [kept for kept in session.compared if kept in runs]

    def redo(self) -> None:
        """Make the change."""
        session, runs = self._session, self._runs
        self._notices.take_kept_runs(
            session,
            [kept for kept in session.kept_runs if kept not in runs],
            [kept for kept in session.compared if kept not in runs],
        )

    def undo(self) -> None:
        """Take it back."""
        session = self._session
        runs = sorted([*session.kept_runs, *self._runs], key=lambda kept: kept.number)
        self._notices.take_kept_runs(session, runs, [*session.compared, *self._compared])


class AcceptRun(QUndoCommand):
    """Results of a kept run become the present ones, with the parameters that they are of."""

    def __init__(
        self, notices: Notices, session: Session, kept: KeptRun, results: Collection[BlockResult], text: str
    ) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._kept = kept
        self._results = list(results)
        self._before, self._accepted = Held({}), Held({})
        common = kept.run.parameters
        self._common = session.common.to_dict(), common.to_dict()
        own = session.notes.own
        after = {
            result.block.label: None if result.parameters.same_effect(common) else own_values(result.parameters, common)
            for result in results
        }
        self._own = {label: (own.get(label), values) for label, values in after.items()}

    def redo(self) -> None:
        """Make the change."""
        self._take(1)
        self._before = self._session.bring_back(self._results, self._kept.guess)
        self._accepted = self._session.results.held()
        self._notices.note_results_changed(self._session)

    def undo(self) -> None:
        """Take it back; what has come since stays."""
        self._take(0)
        newer = self._session.swap_results(Held({})).without(self._accepted)
        self._session.swap_results(self._before.with_newer(newer))
        self._notices.note_results_changed(self._session)

    def _take(self, which: int) -> None:
        own: Mapping[int, OwnValues | None] = {label: values[which] for label, values in self._own.items()}
        self._notices.take_parameters(self._session, self._common[which], own)
