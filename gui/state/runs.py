"""Results and run history of the workspace, and their commands."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoCommand

from ilf.completion.block import Watch
from ilf.data.blocks import OwnValues, own_values
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult, Completion, IterationRecord
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from .blocks import WorkspaceBlocks
from .frames import WorkspaceFrames
from .parameters import WorkspaceParameters
from .results import ErrorEstimate, FrameResults, Preview, ViewedIteration
from .run_history import COLOURS, MAX_COMPARED
from .session import Session

_MAX_WATCHED = 4
"""Maximum number of frames with key frames at a time."""


class WorkspaceRuns(QObject):
    """Results of the frames, of runs in progress and of earlier ones, and the run history."""

    results_changed = Signal()
    """Results changed or were removed, or a run has ended."""
    results_added = Signal()
    """The run in progress has new results; up to several times a second."""
    records_added = Signal()
    """Running blocks have new records."""
    previews_changed = Signal()
    """The depth of running blocks has changed."""
    error_changed = Signal()
    """The expected error of the results was computed."""
    history_changed = Signal()
    """The run history of the current frame has changed."""
    viewed_iteration_changed = Signal()
    """The iteration that the views show has changed."""
    compared_changed = Signal()
    """The set of compared runs has changed."""

    def __init__(
        self,
        frames: WorkspaceFrames,
        blocks: WorkspaceBlocks,
        parameters: WorkspaceParameters,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._frames = frames
        self._parameters = parameters
        self.viewed_iteration: ViewedIteration | None = None
        """The earlier iteration that the views show instead of the current depth."""
        self._with_key_frames: WeakKeyDictionary[Session, None] = WeakKeyDictionary()
        """Frames with key frames, the last run at the end."""
        for part in (blocks, parameters):
            part.validity_changed.connect(self.note_results_changed)

    def watch(self, session: Session, run: Run) -> Watch:
        """Return the observer that stores key frames of a run; key frames of frames run long ago are dropped."""
        others = [one for one in self._with_key_frames if one is not session]
        for one in others[: 1 - _MAX_WATCHED]:
            one.key_frames.clear()
        self._with_key_frames = WeakKeyDictionary(dict.fromkeys([*others[1 - _MAX_WATCHED :], session]))
        return session.key_frames.watch(run)

    def view_iteration(self, viewed_iteration: ViewedIteration | None) -> None:
        """Show the current frame's depth as of an earlier iteration; None for its current depth."""
        if viewed_iteration is not self.viewed_iteration:
            self.viewed_iteration = viewed_iteration
            self.viewed_iteration_changed.emit()

    def add_records(self, session: Session, label: int, records: Sequence[IterationRecord]) -> None:
        """Add records of a running block."""
        session.results.add_records(label, records)
        if self._frames.is_current(session):
            self.records_added.emit()

    def add_previews(self, session: Session, previews: Sequence[Preview]) -> None:
        """Store the depth so far of running blocks."""
        session.add_previews(previews)
        if self._frames.is_current(session):
            self.previews_changed.emit()

    def store_results(self, session: Session, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Store results of blocks; `frame` is the frame as it was when they started, if it may have changed since."""
        session.add_results(results, frame)
        self._frames.touch(session)
        (self.results_added if self._frames.is_current(session) else self._frames.sessions_changed).emit()

    def store_extrapolation(self, session: Session, base: Completion, extrapolation: Completion) -> None:
        """Store the extrapolation of a completion."""
        session.add_extrapolation(base, extrapolation)
        self._frames.touch(session)
        self.note_results_changed(session)

    def note_results_changed(self, session: Session) -> None:
        """Called after results were added, removed or restored, or other results are valid."""
        (self.results_changed if self._frames.is_current(session) else self._frames.sessions_changed).emit()

    def end(self, session: Session, keep_previews: bool = False) -> None:
        """End the frame's run; with `keep_previews`, another run starts next."""
        session.end_run(keep_previews)
        self.note_results_changed(session)

    def clear_results(self) -> None:
        """Remove all results of the current frame, as one undo step."""
        if self._frames.session.results.kept:
            self._frames.session.undo_stack.push(ClearResults(self, self._frames.session))

    def store_error_estimate(self, session: Session, completion: Completion, error_estimate: ErrorEstimate) -> None:
        """Store the error estimate of a completion; ignored if the completion is outdated."""
        if completion is session.completion():
            session.results.note_error_estimate(completion, error_estimate)
            if self._frames.is_current(session):
                self.error_changed.emit()

    # run history

    def keep(self, session: Session, kept: StoredRun) -> None:
        """Add a run to a frame's history."""
        session.change(runs=(*session.state.runs, kept), next_number=max(session.state.next_number, kept.number + 1))
        self._frames.touch(session)
        self._note_history(session)

    def change(self, session: Session, kept: StoredRun, **changes: Any) -> None:
        """Set attributes of a stored run, such as its name or note."""
        for name, value in changes.items():
            setattr(kept, name, value)
        self.note_changed(session, kept)

    def note_changed(self, session: Session, kept: StoredRun) -> None:
        """Called after a stored run has changed."""
        self._frames.touch(session)
        self._note_history(session)
        if kept in session.compared and self._frames.is_current(session):
            self.compared_changed.emit()

    def note_measured(self, session: Session) -> None:
        """Called after the error of a stored run was computed."""
        self._frames.touch(session, viewing=True)
        self._note_history(session)

    def delete(self, session: Session, runs: Collection[StoredRun]) -> None:
        """Delete runs from the history, as one undo step."""
        there = [kept for kept in session.state.runs if kept in runs]
        if there:
            session.undo_stack.push(DeleteRuns(self, session, there))

    def drop(self, session: Session, kept: StoredRun) -> None:
        """Delete a run from the history; not undoable."""
        session.change(runs=tuple(one for one in session.state.runs if one is not kept))
        self._frames.touch(session)
        self._note_history(session)

    def take_history(self, session: Session, runs: list[StoredRun], compared: list[StoredRun]) -> None:
        """Replace the run history and the compared runs. Called by commands."""
        for kept in runs:
            if kept not in session.state.runs:
                kept.ground_truth_error = None  # the ground truth may have changed meanwhile
        former = session.compared
        session.change(runs=tuple(runs))
        self._note_history(session)
        self._compare(session, former, compared[-MAX_COMPARED:])

    def compare(self, runs: Sequence[StoredRun]) -> None:
        """Compare stored runs of the current frame with its result; the last `MAX_COMPARED` of the given ones."""
        session = self._frames.session
        self._compare(session, session.compared, list(runs)[-MAX_COMPARED:])

    def _compare(self, session: Session, former: list[StoredRun], runs: list[StoredRun]) -> None:
        if runs == former:
            return
        for kept in former:
            kept.hold(kept in runs)
        for number, kept in enumerate(runs):
            kept.hold(True)
            taken = [other.colour for other in runs[:number]]
            if kept.colour in taken:
                kept.colour = next(colour for colour in COLOURS if colour not in taken)
        session.change(compared=tuple(kept.number for kept in runs))
        self._frames.touch(session, viewing=True)
        if self._frames.is_current(session):
            self.compared_changed.emit()

    def accept(self, kept: StoredRun) -> list[int]:
        """Replace the current results by those of a stored run, with its parameters, as one undo step.

        Only blocks that have not changed since are replaced. Returns these blocks.
        """
        session = self._frames.session
        results = session.fitting_results(kept)
        if results:
            where = self._parameters.all_frames_text(session) if kept.run.parameters != session.state.common else ""
            session.undo_stack.push(
                AcceptRun(self, self._parameters, session, kept, results, f"Accept {kept.name}{where}")
            )
        return [result.block.label for result in results]

    def _note_history(self, session: Session) -> None:
        if self._frames.is_current(session):
            self.history_changed.emit()


class ClearResults(QUndoCommand):
    """Removal of all results of a frame. Undo restores them; results of later runs stay."""

    def __init__(self, host: WorkspaceRuns, session: Session) -> None:
        super().__init__("Clear results")
        self._host = host
        self._session = session
        self._cleared = FrameResults({})

    def redo(self) -> None:
        """Apply the change."""
        self._cleared = self._session.swap_results(FrameResults({}))
        self._host.note_results_changed(self._session)

    def undo(self) -> None:
        """Undo the change."""
        newer = self._session.swap_results(FrameResults({}))
        self._session.swap_results(self._cleared.with_newer(newer))
        self._host.note_results_changed(self._session)


class DeleteRuns(QUndoCommand):
    """Deletion of runs from the history. Undo restores them; later runs stay."""

    def __init__(self, host: WorkspaceRuns, session: Session, runs: Collection[StoredRun]) -> None:
        super().__init__(f"Delete {next(iter(runs)).name}" if len(runs) == 1 else f"Delete {len(runs)} runs")
        self._host = host
        self._session = session
        self._runs = list(runs)
        self._compared = [kept for kept in session.compared if kept in runs]

    def redo(self) -> None:
        """Apply the change."""
        session, runs = self._session, self._runs
        self._host.take_history(
            session,
            [kept for kept in session.state.runs if kept not in runs],
            [kept for kept in session.compared if kept not in runs],
        )

    def undo(self) -> None:
        """Undo the change."""
        session = self._session
        runs = sorted([*session.state.runs, *self._runs], key=lambda kept: kept.number)
        self._host.take_history(session, runs, [*session.compared, *self._compared])


class AcceptRun(QUndoCommand):
    """Replacement of the current results by those of a stored run, with its parameters."""

    def __init__(
        self,
        host: WorkspaceRuns,
        parameters: WorkspaceParameters,
        session: Session,
        kept: StoredRun,
        results: Collection[BlockResult],
        text: str,
    ) -> None:
        super().__init__(text)
        self._host = host
        self._parameters = parameters
        self._session = session
        self._kept = kept
        self._results = list(results)
        self._before, self._accepted = FrameResults({}), FrameResults({})
        common = kept.run.parameters
        self._common = session.state.common.to_dict(), common.to_dict()
        own = session.blocks.own
        after = {
            result.block.label: None if result.parameters.same_effect(common) else own_values(result.parameters, common)
            for result in results
        }
        self._own = {label: (own.get(label), values) for label, values in after.items()}

    def redo(self) -> None:
        """Apply the change."""
        self._take(1)
        self._before = self._session.restore_results(self._results, self._kept.extrapolation)
        self._accepted = self._session.results.snapshot()
        self._host.note_results_changed(self._session)

    def undo(self) -> None:
        """Undo the change; later results stay."""
        self._take(0)
        newer = self._session.swap_results(FrameResults({})).without(self._accepted)
        self._session.swap_results(self._before.with_newer(newer))
        self._host.note_results_changed(self._session)

    def _take(self, which: int) -> None:
        own: Mapping[int, OwnValues | None] = {label: values[which] for label, values in self._own.items()}
        self._parameters.take(self._session, self._common[which], own)
