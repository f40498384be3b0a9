"""Running ILF from the window: one run at a time, off the GUI's thread."""

from __future__ import annotations

import time
from collections.abc import Generator
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.session import Session
from gui.worker import Worker
from gui.workspace import Workspace
from ilf.completion import CompletionRun, Progress
from ilf.filter.convergence import IterationRecord

_PREVIEW_INTERVAL_S = 0.15
_PREVIEW_SHARE = 6.0
"""Least interval between previews, in times that drawing one takes."""


class RunState(Enum):
    """What the run is doing."""

    IDLE = "idle"
    RUNNING = "running"
    PAUSED = "paused"
    STOPPING = "stopping"


class RunController(QObject):
    """Starts, pauses, steps and cancels; brings records and results to the workspace.

    Signals
    -------
    state_changed()
        `state`, or the block that runs, has changed.
    records(int, list)
        New records of a block, in batches.
    block_started(int)
        A block's first record is about to come.
    previewed()
        A new `preview()` is worth drawing.
    ended(str)
        The run is over; a sentence that says how.
    failed(object)
        The run broke on an exception.
    """

    state_changed = Signal()
    records = Signal(int, list)
    block_started = Signal(int)
    previewed = Signal()
    ended = Signal(str)
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
        self._next_preview = 0.0
        self._stopping = False
        self.session: Session | None = None
        self.live: dict[int, list[IterationRecord]] = {}
        """Records of the run so far, by block."""
        self.block = 0
        """The block that runs; 0 for none."""

    @property
    def state(self) -> RunState:
        """What the run is doing."""
        if not self._worker.busy:
            return RunState.IDLE
        if self._stopping:
            return RunState.STOPPING
        return RunState.PAUSED if self._worker.is_paused else RunState.RUNNING

    @property
    def queued(self) -> set[int]:
        """Blocks of the run that have not been reached yet."""
        if self._run is None:
            return set()
        return set(self._run.blocks) - set(self.live) - set(self._run.results)

    @property
    def share_done(self) -> float:
        """Share of the run's blocks that are done, 0-1."""
        if self._run is None or not self._run.blocks:
            return 0.0
        return len(self._run.results) / len(self._run.blocks)

    def start(self, only: set[int] | None = None, paused: bool = False) -> None:
        """Run all blocks of the present frame, or just some; with `paused`, a single step of the first."""
        session = self._workspace.session
        counts = session.counts()
        choice = {label: session.parameters_of(label, self._workspace.parameters) for label in counts}
        self._run = CompletionRun(session.frame, session.labels.copy(), choice, only)
        self.session = session
        self.live = {}
        self.block = 0
        self._stopping = False
        self._started = time.perf_counter()
        run = self._run

        def job() -> Generator[Progress, None, None]:
            yield from run

        self._worker.start(job, paused)
        self.state_changed.emit()

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
            self._worker.cancel()
            self.state_changed.emit()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._worker.shutdown()

    def preview(self) -> tuple[tuple[slice, slice], NDArray[np.bool_], NDArray[np.float32]] | None:
        """Box, mask and depth [m] of the running block as it stands; None between blocks."""
        found = self._run.preview() if self._run is not None else None
        if found is None:
            return None
        block, depth = found
        return block.box, block.mask, depth

    def _take(self, batch: list[Progress]) -> None:
        results = [item.result for item in batch if item.result is not None]
        fresh: dict[int, list[IterationRecord]] = {}
        for item in batch:
            if item.record is not None:
                fresh.setdefault(item.label, []).append(item.record)
        for label, records in fresh.items():
            if label != self.block:
                self.block = label
                self.live[label] = []
                self.block_started.emit(label)
            self.live[label] += records
            self.records.emit(label, records)
        if results and self.session is not None:
            self._workspace.store_results(self.session, results)
        self._offer_preview()
        self.state_changed.emit()

    def _offer_preview(self) -> None:
        """Now and then, and seldom enough that drawing it takes a fraction of the window's time."""
        now = time.perf_counter()
        if now >= self._next_preview:
            self.previewed.emit()
            cost = time.perf_counter() - now
            self._next_preview = now + max(_PREVIEW_INTERVAL_S, _PREVIEW_SHARE * cost)

    def _end(self, how: str) -> None:
        run, self._run = self._run, None
        session, self.session = self.session, None
        self.block = 0
        self.live = {}
        self._stopping = False
        self.state_changed.emit()
        self.previewed.emit()
        if run is None or session is None:
            return
        done, seconds = len(run.results), time.perf_counter() - self._started
        text = f"{session.name}: run {how}, {done} block{'s' * (done != 1)} in {seconds:.1f} s."
        lost = len(set(run.results) - set(session.valid_results()))
        if lost:
            text += f" {lost} had been edited meanwhile: run them again."
        self.ended.emit(text)

    def _fail(self, error: Any) -> None:
        self._end("failed")
        self.failed.emit(error)
