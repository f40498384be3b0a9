"""The workspace: all changes of the window's state go through it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from ilf.completion.block import Watch
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult, Completion, IterationRecord
from ilf.project.frame_state import own_values
from ilf.project.run_history import KeptRun
from ilf.run.run import Run

from .changing_blocks import ChangingBlocks
from .changing_parameters import names_in
from .commands import AcceptRun, ClearResults, DeleteRuns, EditParameters
from .results import Doubt, Past, Preview
from .run_history import COLOURS, MOST_COMPARED
from .session import Session

_MOST_WATCHED = 4
"""Maximum number of frames with key frames at a time."""


class Workspace(ChangingBlocks):
    """The state of the window. Every change is a method that emits a signal.

    The base classes change frames, blocks and parameters; this class changes results and the run history.
    """

    def watch(self, session: Session, run: Run) -> Watch:
        """Return the observer that stores key frames of a run; key frames of frames run long ago are dropped."""
        self._watched = [*(one for one in self._watched if one is not session), session]
        while len(self._watched) > _MOST_WATCHED:
            self._watched.pop(0).key_frames.clear()
        return session.key_frames.watch(run)

    def look_back(self, past: Past | None) -> None:
        """Show the current frame's depth as of an earlier iteration; None for its current depth."""
        if past is not self.past:
            self.past = past
            self.past_changed.emit()

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

    def store_guess(self, session: Session, base: Completion, guess: Completion) -> None:
        """Store the extrapolation of a completion."""
        session.add_guess(base, guess)
        self.touch(session)
        self.note_results_changed(session)

    def end_run(self, session: Session, previews_stay: bool = False) -> None:
        """End the frame's run; with `previews_stay`, another run starts next."""
        session.end_run(previews_stay)
        self.note_results_changed(session)

    def clear_results(self) -> None:
        """Remove all results of the current frame, as one undo step."""
        if self.session.results.kept:
            self.session.undo_stack.push(ClearResults(self, self.session))

    def store_doubt(self, session: Session, completion: Completion, doubt: Doubt) -> None:
        """Store the error estimate of a completion; ignored if the completion is outdated."""
        if completion is session.completion():
            session.results.note_doubt(completion, doubt)
            if session is self._session:
                self.error_changed.emit()

    # run history

    def keep_run(self, session: Session, kept: KeptRun) -> None:
        """Add a run to a frame's history."""
        session.kept_runs.append(kept)
        self.touch(session)
        self._note_kept_runs(session)

    def change_run(self, session: Session, kept: KeptRun, **changes: Any) -> None:
        """Set attributes of a stored run, such as its name or note."""
        for name, value in changes.items():
            setattr(kept, name, value)
        self.note_run_changed(session, kept)

    def note_run_changed(self, session: Session, kept: KeptRun) -> None:
        """Called after a stored run has changed."""
        self.touch(session)
        self._note_kept_runs(session)
        if kept in session.compared and session is self._session:
            self.compared_changed.emit()

    def note_measured(self, session: Session) -> None:
        """Called after the error of a stored run was computed."""
        self.touch(session, looked=True)
        self._note_kept_runs(session)

    def delete_runs(self, session: Session, runs: Collection[KeptRun]) -> None:
        """Delete runs from the history, as one undo step."""
        there = [kept for kept in session.kept_runs if kept in runs]
        if there:
            session.undo_stack.push(DeleteRuns(self, session, there))

    def drop_run(self, session: Session, kept: KeptRun) -> None:
        """Delete a run from the history; not undoable."""
        session.kept_runs.remove(kept)
        self.touch(session)
        self._note_kept_runs(session)

    def take_kept_runs(self, session: Session, runs: list[KeptRun], compared: list[KeptRun]) -> None:
        """Replace the run history and the compared runs. Called by commands."""
        for kept in runs:
            if kept not in session.kept_runs:
                kept.truth_error = None  # the ground truth may have changed meanwhile
        session.kept_runs = runs
        self._note_kept_runs(session)
        self._compare(session, compared[-MOST_COMPARED:])

    def compare(self, runs: Sequence[KeptRun]) -> None:
        """Compare stored runs of the current frame with its result; the last `MOST_COMPARED` of the given ones."""
        self._compare(self.session, list(runs)[-MOST_COMPARED:])

    def _compare(self, session: Session, runs: list[KeptRun]) -> None:
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
        self.touch(session, looked=True)
        if session is self._session:
            self.compared_changed.emit()

    def restore_run(self, kept: KeptRun) -> bool:
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

    def accept_run(self, kept: KeptRun) -> list[int]:
        """Replace the current results by those of a stored run, with its parameters, as one undo step.

        Only blocks that have not changed since are replaced. Returns these blocks.
        """
        results = self.session.still_fitting(kept)
        if results:
            where = self._for_all(self.session) if kept.run.parameters != self.session.common else ""
            self.session.undo_stack.push(AcceptRun(self, self.session, kept, results, f"Accept {kept.name}{where}"))
        return [result.block.label for result in results]

    def _note_kept_runs(self, session: Session) -> None:
        if session is self._session:
            self.kept_runs_changed.emit()
