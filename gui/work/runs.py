"""Running ILF from the window: each frame has a run of its own; commands are about that of the present frame."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction

from ..state.commands import Change
from ..state.session import Session
from ..state.workspace import Workspace
from .frame_runs import Ended, FrameRuns, RunState

__all__ = ["Ended", "RunController", "RunState"]


class RunController(QObject):
    """What goes on for the frames, side by side: whoever asks or commands means the present frame.

    Signals
    -------
    state_changed()
        `state` has changed, or which blocks are queued, of any frame.
    records(int, list)
        New records of a block of the present frame, in batches.
    ended(str), resolved(str), run_ended(object), finished(object), failed(object)
        As of `FrameRuns`, of any frame.
    """

    state_changed = Signal()
    records = Signal(int, list)
    ended = Signal(str)
    resolved = Signal(str)
    run_ended = Signal(object)
    finished = Signal(object)
    failed = Signal(object)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._all: dict[Session, FrameRuns] = {}
        self._left: list[FrameRuns] = []
        """Of frames that have been closed, until they have ended."""
        workspace.sessions_changed.connect(self._leave_closed)
        workspace.session_changed.connect(self.state_changed)

    def of(self, session: Session) -> FrameRuns:
        """What goes on for a frame."""
        if session not in self._all:
            self._all[session] = runs = FrameRuns(self._workspace, session, self)
            for signal in ("state_changed", "ended", "run_ended", "finished", "failed"):
                getattr(runs, signal).connect(getattr(self, signal))
            runs.records.connect(lambda label, records: self._pass_records(session, label, records))
            runs.resolved.connect(lambda text: self._pass_resolved(session, text))
        return self._all[session]

    def _pass_records(self, session: Session, label: int, records: list[object]) -> None:
        if self._workspace.is_present(session):
            self.records.emit(label, records)

    def _pass_resolved(self, session: Session, text: str) -> None:
        if self._workspace.is_present(session):
            self.resolved.emit(text)

    @property
    def _present(self) -> FrameRuns | None:
        return self._all.get(self._workspace.session) if self._workspace.has_session else None

    @property
    def running(self) -> list[Session]:
        """Frames with a run, or a guess, that is not over."""
        return [session for session, runs in self._all.items() if not runs.free]

    @property
    def state(self) -> RunState:
        """What goes on for the present frame."""
        present = self._present
        return RunState.IDLE if present is None else present.state

    @property
    def free(self) -> bool:
        """Whether a run of the present frame can be started."""
        return self.state in (RunState.IDLE, RunState.RESOLVING)

    @property
    def resolving(self) -> tuple[int, ...]:
        """The blocks of the present frame that are being solved anew."""
        present = self._present
        return () if present is None else present.resolving

    @property
    def queued(self) -> set[int]:
        """Blocks of the present frame's run that have not been reached yet."""
        present = self._present
        return set() if present is None else present.queued

    @property
    def share_done(self) -> float:
        """Share of the blocks of the present frame's run that are done, 0-1."""
        present = self._present
        return 0.0 if present is None else present.share_done

    @property
    def seconds(self) -> float:
        """How long what goes on for the present frame has taken so far [s]."""
        present = self._present
        return 0.0 if present is None else present.seconds

    def start(self, only: set[int] | None = None, stepwise: bool = False) -> None:
        """Run all blocks of the present frame, or just some; with `stepwise`, one by one, and hold after a step."""
        self.of(self._workspace.session).start(only, stepwise)

    def start_changed(self) -> None:
        """Run the blocks of the present frame that have no result of their present state and parameters."""
        self.of(self._workspace.session).start_changed()

    def start_chosen(self) -> None:
        """Run the chosen blocks of the present frame."""
        self.of(self._workspace.session).start_chosen()

    def resolve(self, blocks: Sequence[int], edited: bool = False) -> bool:
        """Solve blocks of the present frame anew, as they are now, in this order; False if a run comes first."""
        return self.of(self._workspace.session).resolve(blocks, edited)

    def guess(self) -> None:
        """Guess what the present frame's blocks leave missing."""
        self.of(self._workspace.session).guess()

    def toggle_pause(self) -> None:
        """Hold the present frame's run, or let it go on."""
        self.of(self._workspace.session).toggle_pause()

    def pause(self) -> None:
        """Hold the present frame's run after its present iteration."""
        self.of(self._workspace.session).pause()

    def resume(self) -> None:
        """Let the present frame's run go on."""
        self.of(self._workspace.session).resume()

    def step(self) -> None:
        """One iteration of the present frame, then hold: of its run, or of a new one."""
        self.of(self._workspace.session).step()

    def cancel(self) -> None:
        """Stop the present frame's run; blocks that are done keep their results."""
        self.of(self._workspace.session).cancel()

    def clear_results(self) -> None:
        """Forget all results of the present frame, also what is about to come."""
        self.of(self._workspace.session).clear_results()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if all threads have ended."""
        ended = [runs.shutdown() for runs in (*self._all.values(), *self._left)]
        return all(ended)

    def _leave_closed(self) -> None:
        """Nothing goes on for a frame that is no longer open."""
        for session in [session for session in self._all if session not in self._workspace.sessions]:
            runs = self._all.pop(session)
            self._left.append(runs)
            runs.cancel()
            runs.state_changed.connect(self._forget_idle)
        self._forget_idle()

    def _forget_idle(self) -> None:
        """What has ended of frames that are closed can go."""
        for runs in [runs for runs in self._left if runs.state is RunState.IDLE]:
            self._left.remove(runs)
            runs.deleteLater()


# Depth that follows edits: the blocks that an edit has touched are solved again by themselves.


class LiveSolver(QObject):
    """Has blocks solved again that were edited since the frame was run, the chosen one first.

    What is touched during a run is solved after it. What undo brings back needs no solving.

    Parameters
    ----------
    live : QAction
        Whether that is wanted.
    """

    def __init__(self, workspace: Workspace, runs: RunController, live: QAction) -> None:
        super().__init__(runs)
        self._workspace = workspace
        self._runs = runs
        self._live = live
        self._touched: WeakKeyDictionary[Session, set[int]] = WeakKeyDictionary()
        """Blocks that are to be solved again, also of frames that are not shown."""
        self._asked: set[int] = set()
        """Those of the present frame that have been asked for since they were touched last."""
        workspace.edited.connect(self._take)
        workspace.distrusted_changed.connect(self._take_all)
        workspace.guide_changed.connect(self._take_all)
        workspace.session_changed.connect(self._turn)
        runs.state_changed.connect(self._go_on)

    def _take(self, change: Change) -> None:
        self._add(change.session, change.blocks)

    def _take_all(self) -> None:
        """Edges, noise and guide are those of all known depth, so that it may have a part in any block."""
        self._add(self._workspace.session, self._workspace.session.counts())

    def _add(self, session: Session, blocks: Collection[int]) -> None:
        if self._live.isChecked() and session.results.kept:
            self._touched.setdefault(session, set()).update(blocks)
            self._asked.difference_update(blocks)
            self._go_on()

    def _turn(self) -> None:
        """What was asked for may be dropped when another frame is shown: it is asked for again when the first is."""
        self._asked.clear()
        self._go_on()

    def _go_on(self) -> None:
        runs, workspace = self._runs, self._workspace
        if not workspace.has_session or runs.state not in (RunState.IDLE, RunState.RESOLVING):
            return
        session, chosen = workspace.session, workspace.chosen
        touched = self._touched.get(session, set())
        if runs.state is RunState.IDLE:  # what was asked for has been solved, or given up
            touched -= self._asked
            self._asked.clear()
        there = touched.intersection(session.counts()) - self._asked
        wanted = [label for label in there if not session.is_up_to_date(label)]
        touched -= there.difference(wanted)  # other values set later are no edit
        wanted.sort(key=lambda label: (label != chosen, label))
        if wanted:
            self._asked.update(wanted)  # before: that the state has changed is heard at once
            if not runs.resolve(wanted, edited=True):
                self._asked.difference_update(wanted)
