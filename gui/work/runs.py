"""Running ILF from the window: one run at a time, off the GUI's thread; and solving a block anew, live."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.worker import Worker
from ilf.blocks import Block
from ilf.completion import BlockResult, CompletionRun, Progress
from ilf.filter.convergence import IterationRecord
from ilf.threads import available_cores

Previews = list[tuple[Block, NDArray[np.float32]]]

_PATIENCE_MS = 150
"""A re-solve whose values have changed meanwhile may end if it takes no longer: during a drag, slightly old results
show more than none."""

_INTERVAL_S = 0.15
"""Least interval between previews, and between looks at what is done."""

_COSTS = 6.0
"""The same, in times that drawing takes, so that the window has most of its time for the user."""

_FIRST_PREVIEW_S = 0.1
"""Age at which a re-solve may take the place of the block's former result before it has ended."""


class RunState(Enum):
    """What the run is doing."""

    IDLE = "idle"
    RUNNING = "running"
    PAUSED = "paused"
    STOPPING = "stopping"
    RESOLVING = "solving anew"
    """One block, because its values have changed: it gives way to a run."""


@dataclass(frozen=True)
class _FollowUp:
    """What is to be done when a re-solve has ended, if its frame is still the present one; a run keeps its place."""

    session: Session
    action: Callable[[], None]
    is_run: bool


class RunController(QObject):
    """Starts, pauses, steps and cancels; brings records and results to the workspace.

    Signals
    -------
    state_changed()
        `state`, or how far the blocks are, has changed.
    records(int, list)
        New records of a block, in batches.
    block_started(int)
        A block's first records are about to come.
    previewed(list)
        Blocks that run, and their depth [m] as it stands: worth drawing.
    ended(str)
        The run is over; a sentence that says how.
    resolved(str)
        A block has been solved anew; a sentence that says how fast.
    failed(object)
        The run broke on an exception.
    """

    state_changed = Signal()
    records = Signal(int, list)
    block_started = Signal(int)
    previewed = Signal(list)
    ended = Signal(str)
    resolved = Signal(str)
    failed = Signal(object)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda _: self._end("finished"))
        self._worker.cancelled.connect(lambda: self._end("cancelled"))
        self._worker.failed.connect(self._fail)
        self._worker.paused.connect(self.state_changed)
        self._run: CompletionRun | None = None
        self._started = 0.0
        self._preview_time = 0.0
        self._report_time = 0.0
        self._stopping = False
        self._abandoned = False
        self._resolving = 0
        self._next: _FollowUp | None = None
        self._patience = QTimer(self, singleShot=True)
        self._patience.timeout.connect(self._worker.cancel)
        self.session: Session | None = None
        self.live: dict[int, list[IterationRecord]] = {}
        """Records of the run so far, by block, in the order in which the blocks began."""
        self._done: set[int] = set()
        self._unreported: list[BlockResult] = []

    @property
    def state(self) -> RunState:
        """What the run is doing."""
        if self._resolving:
            return RunState.RESOLVING
        if not self._worker.busy:
            return RunState.IDLE
        if self._stopping:
            return RunState.STOPPING
        return RunState.PAUSED if self._worker.is_paused else RunState.RUNNING

    @property
    def free(self) -> bool:
        """Whether a run can be started."""
        return self.state in (RunState.IDLE, RunState.RESOLVING)

    @property
    def resolving(self) -> int:
        """The block that is being solved anew; 0 for none."""
        return self._resolving

    @property
    def running(self) -> list[int]:
        """Blocks that have records but no result in the workspace yet, the one that began last at the end."""
        return [label for label in self.live if label not in self._done]

    @property
    def queued(self) -> set[int]:
        """Blocks of the run that have not been reached yet."""
        if self._run is None or self._resolving:
            return set()
        return set(self._run.blocks) - set(self.live) - self._done

    @property
    def share_done(self) -> float:
        """Share of the run's blocks that are done, 0-1."""
        if self._run is None or not self._run.blocks:
            return 0.0
        return len(self._done) / len(self._run.blocks)

    def start(self, only: set[int] | None = None, stepwise: bool = False) -> None:
        """Run all blocks of the present frame, or just some; with `stepwise`, one by one, and hold after a step."""
        if self._resolving:
            self._follow_up(lambda: self.start(only, stepwise), 0, is_run=True)
        else:
            # one core stays the window's
            self._begin(only, threads=1 if stepwise else max(available_cores() - 1, 1), paused=stepwise)

    def resolve(self, label: int) -> None:
        """Solve a block of the present frame anew, with the values it has now; nothing happens during a run.

        Of the values that come while a re-solve is under way only the latest count: they are taken up when it ends,
        and it ends soon.
        """
        if self.state is RunState.IDLE:
            self._begin({label}, threads=1, resolving=label)
        elif self._resolving and (self._next is None or not self._next.is_run):
            age_ms = math.ceil(1000 * (time.perf_counter() - self._started))
            self._follow_up(lambda: self.resolve(label), max(_PATIENCE_MS - age_ms, 0))

    def _follow_up(self, action: Callable[[], None], patience_ms: int, is_run: bool = False) -> None:
        """Do something with the present frame when the re-solve has ended, which is cancelled after a while."""
        self._next = _FollowUp(self._workspace.session, action, is_run)
        if patience_ms == 0:
            self._patience.stop()
            self._worker.cancel()
        elif not self._patience.isActive():
            self._patience.start(patience_ms)

    def _begin(self, only: set[int] | None, threads: int, paused: bool = False, resolving: int = 0) -> None:
        session = self._workspace.session
        choice = {label: session.parameters_of(label, self._workspace.parameters) for label in session.counts()}
        run = CompletionRun(
            session.frame, session.labels.copy(), choice, only, threads, extraction=session.notes.extraction
        )
        self._run = run
        self.session = session
        self._started = time.perf_counter()
        self._resolving = resolving
        if resolving:
            self._preview_time = max(self._preview_time, self._started + _FIRST_PREVIEW_S)

        def job() -> Generator[tuple[Progress, Previews | None], None, None]:
            with run:
                for progress in run:
                    yield progress, self._due_previews(run)

        self._worker.start(job, paused)
        self.state_changed.emit()

    def _due_previews(self, run: CompletionRun) -> Previews | None:
        """Called off the GUI's thread, which says when it has drawn the last."""
        if time.perf_counter() < self._preview_time:
            return None
        self._preview_time = math.inf
        return run.preview()

    def pause(self) -> None:
        """Hold after the present iteration."""
        self._worker.pause()
        self.state_changed.emit()

    def resume(self) -> None:
        """Go on."""
        self._worker.resume()
        self.state_changed.emit()

    def step(self) -> None:
        """One iteration more, then hold."""
        self._worker.step()
        self.state_changed.emit()

    def cancel(self) -> None:
        """Stop after the present iteration; blocks that are done keep their results."""
        if self._worker.busy:
            self._stopping = True
            self._next = None
            self._worker.cancel()
            self.state_changed.emit()

    def clear_results(self) -> None:
        """Forget all results of the present frame, also the one that a re-solve under way is about to give."""
        if self._resolving and self.session is self._workspace.session:
            self._abandoned = True
            self.cancel()
        self._workspace.clear_results()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._patience.stop()
        return self._worker.shutdown()

    def _take(self, batch: list[tuple[Progress, Previews | None]]) -> None:
        if self._abandoned:
            return
        fresh: dict[int, list[IterationRecord]] = {}
        for progress, _ in batch:
            if progress.record is not None:
                fresh.setdefault(progress.label, []).append(progress.record)
            if progress.result is not None:
                self._unreported.append(progress.result)
        for label, records in fresh.items():
            if label not in self.live:
                self.live[label] = []
                self.block_started.emit(label)
            self.live[label] += records
            self.records.emit(label, records)
        if not self._resolving and time.perf_counter() >= self._report_time:
            self._report_time = _next_time(self._report)
        for _, previews in batch:
            if previews is not None:
                self._preview_time = _next_time(partial(self.previewed.emit, previews))

    def _report(self) -> None:
        """Bring the results that have come to the workspace, and say how far the run is."""
        results, self._unreported = self._unreported, []
        if results and self.session is not None:
            self._done.update(result.block.label for result in results)
            self._workspace.store_results(self.session, results)
        self.state_changed.emit()

    def _end(self, how: str) -> None:
        if self._abandoned:
            self._unreported.clear()
        self._report()
        run, self._run = self._run, None
        session, self.session = self.session, None
        done, self._done = self._done, set()
        resolved, self._resolving = self._resolving, 0
        following, self._next = self._next, None
        seconds = time.perf_counter() - self._started
        self._patience.stop()
        self._preview_time = self._report_time = 0.0
        self._stopping = self._abandoned = False
        self.live = {}
        if following is not None and self._workspace.has_session and following.session is self._workspace.session:
            following.action()
        else:
            self.state_changed.emit()
        if run is None or session is None:
            return
        if resolved:
            if resolved in done:
                outcome = run.results[resolved].outcome
                name = session.info(resolved).name
                self.resolved.emit(f"{name}: {outcome.iterations} iterations in {1000 * seconds:.0f} ms")
            elif following is None:
                self.previewed.emit([])
            return
        self.previewed.emit([])
        text = f"{session.name}: run {how}, {len(done)} block{'s' * (len(done) != 1)} in {seconds:.1f} s."
        lost = len(done - set(session.valid_results()))
        if lost:
            text += f" {lost} had been edited meanwhile: run them again."
        self.ended.emit(text)

    def _fail(self, error: Any) -> None:
        self._next = None
        self._end("failed")
        self.failed.emit(error)


def _next_time(draw: Callable[[], None]) -> float:
    """Draw, and say when to do it again."""
    begun = time.perf_counter()
    draw()
    return begun + max(_INTERVAL_S, _COSTS * (time.perf_counter() - begun))
