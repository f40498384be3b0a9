"""The workspace: all changes of the window's state go through it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from ilf.completion.block import Watch
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult, Completion, IterationRecord
from ilf.project.frame_state import own_values
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from .commands import AcceptRun, ClearResults, DeleteRuns, EditParameters
from .results import ErrorEstimate, Preview, ViewedIteration
from .run_history import COLOURS, MAX_COMPARED
from .session import Session
from .workspace_blocks import WorkspaceBlocks
from .workspace_parameters import names_in

_MAX_WATCHED = 4
"""Maximum number of frames with key frames at a time."""


class Workspace(WorkspaceBlocks):
    """The state of the window. Every change is a method that emits a signal.

    The base classes change frames, blocks and parameters; this class changes results and the run history.
    """

    def watch(self, session: Session, run: Run) -> Watch:
        """Return the observer that stores key frames of a run; key frames of frames run long ago are dropped."""
        self._with_key_frames = [*(one for one in self._with_key_frames if one is not session), session]
        while len(self._with_key_frames) > _MAX_WATCHED:
            self._with_key_frames.pop(0).key_frames.clear()
        return session.key_frames.watch(run)

    def view_iteration(self, viewed_iteration: ViewedIteration | None) -> None:
        """Show the current frame's depth as of an earlier iteration; None for its current depth."""
        if viewed_iteration is not self.viewed_iteration:
            self.viewed_iteration = viewed_iteration
            self.viewed_iteration_changed.emit()

    def add_records(self, session: Session, label: int, records: Sequence[IterationRecord]) -> None:
        """Add records of a running block."""
        session.results.add_records(label, records)
        if session is self._session:
            self.records_added.emit()

    def add_previews(self, session: Session, previews: Sequence[Preview]) -> None:
        """Store the depth so far of running blocks."""
        session.add_previews(previews)
        if session is self._session:
            self.previews_changed.emit()

    def store_results(self, session: Session, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Store results of blocks; `frame` is the frame as it was when they started, if it may have changed since."""
        session.add_results(results, frame)
        self.touch(session)
        (self.results_added if session is self._session else self.sessions_changed).emit()

    def store_extrapolation(self, session: Session, base: Completion, extrapolation: Completion) -> None:
        """Store the extrapolation of a completion."""
        session.add_extrapolation(base, extrapolation)
        self.touch(session)
        self.note_results_changed(session)

    def end_run(self, session: Session, keep_previews: bool = False) -> None:
        """End the frame's run; with `keep_previews`, another run starts next."""
        session.end_run(keep_previews)
        self.note_results_changed(session)

    def clear_results(self) -> None:
        """Remove all results of the current frame, as one undo step."""
        if self.session.results.kept:
            self.session.undo_stack.push(ClearResults(self, self.session))

    def store_error_estimate(self, session: Session, completion: Completion, error_estimate: ErrorEstimate) -> None:
        """Store the error estimate of a completion; ignored if the completion is outdated."""
        if completion is session.completion():
            session.results.note_error_estimate(completion, error_estimate)
            if session is self._session:
                self.error_changed.emit()

    # run history

    def keep_run(self, session: Session, kept: StoredRun) -> None:
        """Add a run to a frame's history."""
        session.run_history.append(kept)
        self.touch(session)
        self._note_run_history(session)

    def change_run(self, session: Session, kept: StoredRun, **changes: Any) -> None:
        """Set attributes of a stored run, such as its name or note."""
        for name, value in changes.items():
            setattr(kept, name, value)
        self.note_run_changed(session, kept)

    def note_run_changed(self, session: Session, kept: StoredRun) -> None:
        """Called after a stored run has changed."""
        self.touch(session)
        self._note_run_history(session)
        if kept in session.compared and session is self._session:
            self.compared_changed.emit()

    def note_measured(self, session: Session) -> None:
        """Called after the error of a stored run was computed."""
        self.touch(session, viewing=True)
        self._note_run_history(session)

    def delete_runs(self, session: Session, runs: Collection[StoredRun]) -> None:
        """Delete runs from the history, as one undo step."""
        there = [kept for kept in session.run_history if kept in runs]
        if there:
            session.undo_stack.push(DeleteRuns(self, session, there))

    def drop_run(self, session: Session, kept: StoredRun) -> None:
        """Delete a run from the history; not undoable."""
        session.run_history.remove(kept)
        self.touch(session)
        self._note_run_history(session)

    def take_run_history(self, session: Session, runs: list[StoredRun], compared: list[StoredRun]) -> None:
        """Replace the run history and the compared runs. Called by commands."""
        for kept in runs:
            if kept not in session.run_history:
                kept.ground_truth_error = None  # the ground truth may have changed meanwhile
        session.run_history = runs
        self._note_run_history(session)
        self._compare(session, compared[-MAX_COMPARED:])

    def compare(self, runs: Sequence[StoredRun]) -> None:
        """Compare stored runs of the current frame with its result; the last `MAX_COMPARED` of the given ones."""
        self._compare(self.session, list(runs)[-MAX_COMPARED:])

    def _compare(self, session: Session, runs: list[StoredRun]) -> None:
        if runs == session.compared:
            return
        for kept in session.compared:
            kept.hold(kept in runs)
        for number, kept in enumerate(runs):
            kept.hold(True)
            taken = [other.colour for other in runs[:number]]
            if kept.colour in taken:
                kept.colour = next(colour for colour in COLOURS if colour not in taken)
        session.compared = runs
        self.touch(session, viewing=True)
        if session is self._session:
            self.compared_changed.emit()

    def restore_run(self, kept: StoredRun) -> bool:
        """Restore common and own parameters of a stored run in the current frame, as one undo step; False if they are
        the current ones."""
        session, run = self.session, kept.run
        there = set(session.counts()).intersection(np.unique(run.blocks).tolist())
        own = {label: own_values(run.parameters_of(label), run.parameters) for label in there}
        changes = self._own_changes(own)
        names = names_in(changes).union(own_values(run.parameters, session.common))
        if not names:
            return False
        common = session.common, run.parameters
        text = f"Restore parameters of {kept.name}{self._for_all(session)}"
        session.undo_stack.push(EditParameters(self, session, common, changes, names, text))
        return True

    def accept_run(self, kept: StoredRun) -> list[int]:
        """Replace the current results by those of a stored run, with its parameters, as one undo step.

        Only blocks that have not changed since are replaced. Returns these blocks.
        """
        results = self.session.fitting_results(kept)
        if results:
            where = self._for_all(self.session) if kept.run.parameters != self.session.common else ""
            self.session.undo_stack.push(AcceptRun(self, self.session, kept, results, f"Accept {kept.name}{where}"))
        return [result.block.label for result in results]

    def _note_run_history(self, session: Session) -> None:
        if session is self._session:
            self.run_history_changed.emit()
