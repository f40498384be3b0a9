"""Going back through the iterations of the last run: the views show the depth as it was then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject

from gui.curves.curves_panel import CurvesPanel
from gui.state.past import Past
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.latest_question import LatestQuestion
from gui.work.runs import RunController, RunState
from ilf.filter.convergence import IterationRecord
from ilf.run.key_frames import KeyFrame, Track, past_depth

_GOING = (RunState.RUNNING, RunState.RESOLVING)


@dataclass(frozen=True, eq=False)
class _Moment:
    """What the present frame was like after an iteration: the blocks that went on after it, over all others."""

    session: Session
    iteration: int
    present: NDArray[np.float32]
    blocks: list[tuple[Track, KeyFrame]]


class Scrubbing(QObject):
    """The slider under the curves. At iteration i every block is as it was after its own iteration i, or as it ended if
    that was sooner; blocks without key frames are as they are.

    A run that begins or goes on, an edit and another frame lead back to the present.
    """

    def __init__(self, workspace: Workspace, runs: RunController, panel: CurvesPanel) -> None:
        super().__init__(panel)
        self._workspace = workspace
        self._runs = runs
        self._panel = panel
        self._bar = panel.scrub_bar
        self._state = RunState.IDLE
        self._questions = LatestQuestion[_Moment, NDArray[np.float32]](_work_out, self)
        self._questions.answered.connect(self._take)
        self._bar.moved.connect(lambda _: self._go())
        edits = workspace.stroke_changed, workspace.labels_changed, workspace.distrusted_changed
        for changed in (workspace.session_changed, workspace.guide_changed, *edits):
            changed.connect(lambda *_: self._bar.go_to_end())
        runs.state_changed.connect(self._follow_run)

    def show(self) -> None:
        """How far one can go back."""
        session = self._workspace.session if self._workspace.has_session else None
        last = 0 if session is None else max((len(records) for records, _ in _tracks(session)), default=0)
        self._bar.set_range(last)
        self._bar.set_hint("" if session is None else _hint(session))
        if not self._bar.at_end or self._workspace.past is not None:
            self._go()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _follow_run(self) -> None:
        before, self._state = self._state, self._runs.state
        if self._state in _GOING and before not in _GOING:
            self._bar.go_to_end()

    def _go(self) -> None:
        """Show what there was at the position of the slider."""
        if self._bar.at_end or not self._workspace.has_session:
            self._questions.forget()
            self._panel.look_at(None)
            self._workspace.look_back(None)
            return
        session, iteration = self._workspace.session, self._bar.position
        self._panel.look_at(iteration)
        present = session.present_depth()
        base = (session.frame.depth if present is None else present).copy()
        blocks = [(track, track.at(iteration)) for records, track in _tracks(session) if iteration < len(records)]
        self._questions.ask(_Moment(session, iteration, base, blocks))

    def _take(self, moment: _Moment, depth: NDArray[np.float32]) -> None:
        if self._workspace.has_session and moment.session is self._workspace.session and not self._bar.at_end:
            self._workspace.look_back(Past(depth, moment.iteration))


def _work_out(moment: _Moment) -> NDArray[np.float32]:
    """Off the GUI's thread."""
    return past_depth(moment.present, moment.blocks)


def _tracks(session: Session) -> list[tuple[Sequence[IterationRecord], Track]]:
    """The records of all blocks that there are key frames of, and those."""
    found = []
    for label in session.counts():
        records = session.records_of(label)
        track = session.key_frames.track(records)
        if track is not None:
            found.append((records, track))
    return found


def _hint(session: Session) -> str:
    frames = session.key_frames
    strides = {track.stride for _, track in _tracks(session)}
    every = f" Of long runs, one iteration in {max(strides)} is kept." if strides and max(strides) > 1 else ""
    return (
        "Go back through the iterations: the views show the depth as it was after iteration i of every block.\n"
        f"Key frames of this frame: {frames.nbytes / 2**20:.1f} of {frames.budget / 2**20:.0f} MiB.{every}"
    )
