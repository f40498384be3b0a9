"""Runs of ILF on one frame, one at a time in a background thread, and live re-solving of changed blocks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf._runtime.cancellation import check_cancelled, mapped_steps
from ilf._runtime.formatting import counted
from ilf.completion.extrapolation import extrapolation_steps
from ilf.data.results import NO_BLOCK, Completion, IterationRecord, Step, notes_of
from ilf.run.run import EXTRAPOLATED, Execution, Run

from ..state.document import Document
from ..state.results import Preview
from ..state.workspace import Workspace
from .jobs import Order, Worker, spare_cores

_WithPreviews = tuple[Step, list[Preview] | None]

_PATIENCE_MS = 150
"""Time [ms] that a re-solve may still take after its parameters changed: during a drag, slightly outdated results are
better than none."""

_PREVIEWS_S = 0.15
"""Minimum interval [s] between previews of running blocks."""

_FIRST_PREVIEW_S = 0.03
"""Age [s] from which previews of a re-solve replace the block's former result."""


class RunState(Enum):
    """The state of a frame's run."""

    IDLE = "idle"
    RUNNING = "running"
    PAUSED = "paused"
    STOPPING = "stopping"
    EXTRAPOLATING = "extrapolating"
    """Extrapolation of what no block could complete, after a run."""
    RESOLVING = "re-solving"
    """Blocks are solved again because they or their parameters changed; a run has priority."""

    @property
    def free(self) -> bool:
        """Whether a run can be started."""
        return self in (RunState.IDLE, RunState.RESOLVING)

    @property
    def going(self) -> bool:
        """Whether a run can be paused or cancelled."""
        return self in (RunState.RUNNING, RunState.PAUSED, RunState.EXTRAPOLATING)


class RunOutcome(NamedTuple):
    """The outcome of a run or a re-solve.

    Attributes
    ----------
    document : Document
    run : Run
        Its input.
    done : frozenset of int
        Blocks with a result.
    seconds : float
        Duration [s].
    how : str
        "finished", "cancelled" or "failed".
    resolved : bool
        Whether it was a re-solve of changed blocks.
    """

    document: Document
    run: Run
    done: frozenset[int]
    seconds: float
    how: str
    resolved: bool


class RunNews(QObject):
    """What runs tell.

    Signals
    -------
    state_changed()
        `state` or `queued` has changed, of any frame.
    ended(str)
        A run has ended; a message with its outcome.
    resolved(str)
        Blocks of the current frame were re-solved; a message with the duration.
    run_ended(object)
        A run or a re-solve has ended and its results are stored; an `RunOutcome`.
    finished(object)
        A run has finished, including the extrapolation if there is one; its document.
    failed(object)
        A run failed with an exception.
    """

    state_changed = Signal()
    ended = Signal(str)
    resolved = Signal(str)
    run_ended = Signal(object)
    finished = Signal(object)
    failed = Signal(object)


class FrameRuns(QObject):
    """Starts, pauses, steps and cancels the work on one frame, adds its records, previews and results to the workspace,
    and tells of them by `news`."""

    def __init__(self, workspace: Workspace, document: Document, news: RunNews) -> None:
        super().__init__(news)
        self._news = news
        self._workspace = workspace
        self.document = document
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda found: self._end("finished", found))
        self._worker.cancelled.connect(lambda: self._end("cancelled"))
        self._worker.failed.connect(self._fail)
        self._worker.paused.connect(news.state_changed)
        self._run: Run | None = None
        self._steps: Execution | None = None
        self._extrapolating: Completion | None = None
        self._started = 0.0
        self._preview_time = 0.0
        self._stopping = False
        self._abandoned = False
        self.resolving: tuple[int, ...] = ()
        """The blocks that are being re-solved."""
        self._next: Callable[[], None] | None = None
        """What follows the current re-solve, if it is no other re-solve."""
        self._waiting: dict[int, bool] = {}
        """The blocks to re-solve once what is going on has ended, and whether they were edited."""
        self._sizes: dict[int, int] = {}
        """Pixels of the run's blocks."""
        self._begun: set[int] = set()
        self._done: set[int] = set()

    @property
    def state(self) -> RunState:
        """The state of the work on the frame."""
        if self.resolving:
            return RunState.RESOLVING
        if not self._worker.busy:
            return RunState.IDLE
        if self._stopping:
            return RunState.STOPPING
        if self._worker.is_paused:
            return RunState.PAUSED
        return RunState.RUNNING if self._extrapolating is None else RunState.EXTRAPOLATING

    @property
    def queued(self) -> set[int]:
        """Blocks of the run that have not started yet."""
        if self._run is None or self._steps is None or self.resolving:
            return set()
        return set(self._steps.blocks) - self._begun - self._done

    @property
    def completed(self) -> list[int]:
        """The blocks that have a result, of whatever state, or are being run, in ascending order."""
        return sorted({*self.document.results.kept, *(self._steps.blocks if self._steps is not None else ())})

    @property
    def share_done(self) -> float:
        """Share of the pixels of the run's blocks whose block has been filtered, 0-1."""
        if not self._sizes or self._steps is None:
            return 0.0
        done = self._done | self._steps.uncorrected.keys()
        return sum(self._sizes[label] for label in done) / sum(self._sizes.values())

    @property
    def stage(self) -> str:
        """What the run does now ("Preparing", "Filtering", "Correcting") and, if it can be told, of how many blocks."""
        if self.state is not RunState.RUNNING or self._steps is None:
            return self.state.value.capitalize()
        total, done = len(self._steps.blocks), len(self._done | self._steps.uncorrected.keys())
        if not (done or self._begun):
            return "Preparing"
        return "Correcting" if self._steps.uncorrected and done == total else f"Filtering {done} of {total}"

    def start(self, only: set[int] | None = None, stepwise: bool = False) -> None:
        """Run all blocks, or some; with `stepwise`, one block at a time, pausing after each step."""
        if self.resolving:
            self._follow_up(lambda: self.start(only, stepwise))
            return
        self._run = self.document.run(self.document.state.common, only)
        threads = 1 if stepwise else spare_cores()
        self._steps = steps = self._run.steps(threads, self._workspace.watch(self.document, self._run))
        self._sizes = {label: int(np.count_nonzero(block.mask)) for label, block in steps.blocks.items()}
        self._start(lambda: steps, stepwise)

    def start_changed(self) -> None:
        """Run the blocks without an up-to-date result."""
        changed = self.document.changed_blocks()
        if changed:
            self.start(set(changed))
        else:
            self._news.ended.emit(
                f"{self.document.name}: all blocks are up to date. Use Run all blocks to run them again."
            )

    def start_selected(self) -> None:
        """Run the selected blocks."""
        self.start(self._chosen())

    def _chosen(self) -> set[int]:
        return set(self.document.selected) & set(self.document.counts())

    def resolve(self, blocks: Sequence[int], edited: bool = False) -> None:
        """Re-solve blocks in their current state, in this order: now, or after the run that is going on.

        A re-solve that is going on ends at once if blocks were edited, otherwise soon; what it has not finished is
        solved after them. What was edited is solved also if the run before it is cancelled.
        """
        if self.state is RunState.IDLE:
            self._begin_resolve(blocks)
            return
        former = self._waiting
        self._waiting = {label: edited or former.get(label, False) for label in blocks}
        self._waiting |= {label: was for label, was in former.items() if label not in self._waiting}
        if self.resolving and self._next is None:
            age_ms = math.ceil(1000 * (time.perf_counter() - self._started))
            self._worker.cancel(0 if edited else max(_PATIENCE_MS - age_ms, 0))

    def _follow_up(self, action: Callable[[], None]) -> None:
        """Cancel the re-solve and call an action when it has ended."""
        self._next = action
        self._worker.cancel()

    def _resolve_waiting(self, unfinished: Iterable[int] = ()) -> None:
        """Re-solve the blocks that wait for it, then those that these have left unfinished."""
        waiting, self._waiting = self._waiting, {}
        blocks = dict.fromkeys((*waiting, *unfinished)) if waiting else ()
        self._begin_resolve([label for label in blocks if not self.document.is_up_to_date(label)])

    def _begin_resolve(self, blocks: Sequence[int]) -> None:
        there = self.document.counts() if self.document in self._workspace.open else ()
        self.resolving = tuple(label for label in blocks if label in there)
        if not self.resolving:
            self._news.state_changed.emit()
            return
        self._preview_time = max(self._preview_time, time.perf_counter() + _FIRST_PREVIEW_S)
        self._run = run = self.document.run(self.document.state.common, self.resolving)
        watch = self._workspace.watch(self.document, run)
        self._start(lambda: run.steps(spare_cores(), watch))

    def _start(self, make: Callable[[], Execution], paused: bool = False) -> None:
        self._started = time.perf_counter()

        def job() -> Generator[_WithPreviews, None, None]:
            with make() as steps:
                for progress in steps:
                    if progress.result is None:
                        check_cancelled()  # later records are not needed
                    yield progress, self._due_previews(steps)

        self._worker.start(job, paused, lambda step: step[0] is not NO_BLOCK)
        self._news.state_changed.emit()

    def extrapolate(self) -> None:
        """Extrapolate what the blocks leave missing."""
        completion = self.document.completion()
        if self.resolving:
            self._follow_up(self.extrapolate)
        elif self.state.free and completion is not None and not self.document.extrapolated:
            self._begin_extrapolation(completion)

    def _begin_extrapolation(self, completion: Completion) -> None:
        self._extrapolating = completion
        self._started = time.perf_counter()
        present = replace(completion, run=self.document.run(self.document.state.common))

        def told(record: IterationRecord) -> _WithPreviews:
            return Step(EXTRAPOLATED, record=record), None

        self._worker.start(lambda: mapped_steps(extrapolation_steps(present), told))
        self._news.state_changed.emit()

    def _due_previews(self, steps: Execution) -> list[Preview] | None:
        """Called in the background thread; the GUI's thread sets when the next preview is due."""
        if time.perf_counter() < self._preview_time:
            return None
        self._preview_time = math.inf
        return steps.preview()

    def toggle_pause(self) -> None:
        """Pause the run after the current iteration, or resume it."""
        self._worker.order(Order.RUN if self.state is RunState.PAUSED else Order.PAUSE)
        self._news.state_changed.emit()

    def step(self) -> None:
        """Run one iteration, then pause: of the current run, or of a new one over the selected blocks, or all."""
        if self.state.free:
            self.start(self._chosen() or None, stepwise=True)
        else:
            self._worker.order(Order.STEP)
            self._news.state_changed.emit()

    def cancel(self) -> None:
        """Cancel after the current iteration; completed blocks keep their results."""
        if self._worker.busy:
            self._stopping = True
            self._next = None
            self._waiting = {label: True for label, edited in self._waiting.items() if edited and not self.resolving}
            self._worker.cancel()
            self._news.state_changed.emit()

    def clear_results(self) -> None:
        """Remove all results, also those of a re-solve or an extrapolation in progress."""
        if self.resolving or self._extrapolating is not None:
            self._abandoned = self._extrapolating is None
            self._waiting = {}
            self.cancel()
        self.document.clear_results()

    def _take(self, batch: list[_WithPreviews]) -> None:
        run = self._run
        if self._abandoned or run is None:
            return
        fresh: dict[int, list[IterationRecord]] = {}
        results = [progress.result for progress, _ in batch if progress.result is not None]
        for progress, _ in batch:
            if progress.record is not None:
                fresh.setdefault(progress.label, []).append(progress.record)
        self._begun.update(fresh)
        for label, records in fresh.items():
            self.document.add_records(label, records)
        for _, previews in batch:
            if previews is not None:
                self.document.add_previews(previews)
                self._preview_time = time.perf_counter() + _PREVIEWS_S
        if results:
            self._done.update(result.block.label for result in results)
            # the invalid mask may have changed since the run started
            self.document.store_results(results, run.frame)

    def _end(self, how: str, found: Completion | None = None) -> None:
        if self._extrapolating is not None:
            self._end_extrapolation(self._extrapolating, how, found)
            return
        run, self._run = self._run, None
        steps, self._steps = self._steps, None
        done, self._done, self._begun = self._done, set(), set()
        resolved, self.resolving = self.resolving, ()
        following, self._next = self._next, None
        seconds = time.perf_counter() - self._started
        if run is not None and steps is not None and how != "finished" and not (resolved or self._abandoned):
            # blocks that were iterated keep their results, though they are not corrected yet
            self.document.store_results(list(steps.uncorrected.values()), run.frame)
            done.update(steps.uncorrected)
        self._preview_time = 0.0
        self._stopping = self._abandoned = False
        # another re-solve follows: the previews stay until then
        self.document.end_run(keep_previews=bool(resolved and self._waiting and following is None))
        if following is not None:
            following()
        if self.state is RunState.IDLE:
            self._resolve_waiting(one for one in resolved if one not in done)
        if run is not None:
            self._news.run_ended.emit(RunOutcome(self.document, run, frozenset(done), seconds, how, bool(resolved)))
        if resolved:
            self._report_resolved(resolved, done, seconds)
        elif steps is not None:
            self._report_ended(steps, how, done, seconds)

    def _report_resolved(self, blocks: Sequence[int], done: set[int], seconds: float) -> None:
        results = self.document.valid_results()
        there = [label for label in blocks if label in done and label in results]
        if there and self._workspace.is_shown(self.document):
            count = sum(results[label].outcome.iterations for label in there)
            what = self.document.info(there[0]).name if len(there) == 1 else counted(len(there), "block")
            self._news.resolved.emit(f"{what}: {counted(count, 'iteration')} in {1000 * seconds:.0f} ms")

    def _report_ended(self, steps: Execution, how: str, done: set[int], seconds: float) -> None:
        document = self.document
        text = f"{document.name}: run {how}, {counted(len(done), 'block')} in {seconds:.1f} s."
        lost = len(done - set(document.valid_results()))
        if lost:
            text += f" {counted(lost, 'block')} edited meanwhile."
        if uncorrected := len(done & steps.uncorrected.keys()):
            text += f" {counted(uncorrected, 'block')} without the learned correction: run again (F5)."
        self._news.ended.emit(" ".join((text, *notes_of(steps.results))))
        if how == "finished":
            self._go_on()

    def _go_on(self) -> None:
        """After a finished run, extrapolate the rest if that is part of it."""
        completion = self.document.completion()
        if self.document.state.extrapolate and completion is not None and self.state is RunState.IDLE:
            self._begin_extrapolation(completion)
        else:
            self._news.finished.emit(self.document)

    def _end_extrapolation(self, base: Completion, how: str, found: Completion | None) -> None:
        self._extrapolating, self._stopping = None, False
        document = self.document
        holds = found is not None and document.completion() is base
        if found is None:
            text = f"extrapolation {how}."
        elif not (count := int(np.count_nonzero(found.extrapolated))):
            text = "no depth is missing; nothing to extrapolate."
        elif not holds:
            text = "blocks were edited during the extrapolation: extrapolate again."
        else:
            seconds = time.perf_counter() - self._started
            text = f"{counted(count, 'pixel')} extrapolated in {seconds:.1f} s (unsupported by measurements)."
        if found is not None:
            text = " ".join((text, *(note for note in found.notes if note not in base.notes)))
            if holds:
                document.store_extrapolation(base, found)
        self._resolve_waiting()
        self._news.ended.emit(f"{document.name}: {text}")
        if holds:
            self._news.finished.emit(document)

    def _fail(self, error: Any) -> None:
        self._next, self._waiting = None, {}
        self._end("failed")
        self._news.failed.emit(error)
