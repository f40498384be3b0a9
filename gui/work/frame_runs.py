"""Runs of ILF on one frame, one at a time in a background thread, and live re-solving of changed blocks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction

from ilf._runtime.formatting import counted
from ilf._runtime.long_work import check_cancelled, mapped_steps
from ilf.completion.extrapolation import extrapolation_steps
from ilf.data.results import NO_BLOCK, Completion, IterationRecord, Step, notes_of
from ilf.run.run import EXTRAPOLATED, Execution, Run

from ..state.document import Document
from ..state.parts import Edit, Part
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


@dataclass(eq=False)
class Work:
    """A run, a re-solve of changed blocks or an extrapolation: what is going on, or how it has ended.

    Attributes
    ----------
    document : Document
    run : Run
        Its input.
    started, seconds : float
        When it started, and its duration [s]; 0 until it has ended.
    kind : RunState
        `RUNNING`, `RESOLVING` or `EXTRAPOLATING`.
    steps : Execution or None
        Of a run.
    resolves : tuple of int
        The blocks of a re-solve, in this order.
    base : Completion or None
        What is extrapolated.
    begun, done : set of int
        Blocks with records, and blocks with a result.
    how : str
        "finished", "cancelled" or "failed"; "" until it has ended.
    """

    document: Document
    run: Run
    started: float
    kind: RunState = RunState.RUNNING
    steps: Execution | None = None
    resolves: tuple[int, ...] = ()
    base: Completion | None = None
    begun: set[int] = field(default_factory=set)
    done: set[int] = field(default_factory=set)
    how: str = ""
    seconds: float = 0.0
    preview_time: float = 0.0
    """When the next preview is due [s]."""
    abandoned: bool = False
    """Whether its results are not wanted any more."""

    def due_previews(self, steps: Execution) -> list[Preview] | None:
        """Called in the background thread; the GUI's thread sets when the next preview is due."""
        if time.perf_counter() < self.preview_time:
            return None
        self.preview_time = math.inf
        return steps.preview()


class FrameRuns(QObject):
    """Starts, pauses, steps and cancels the work on one frame, adds its records, previews and results to the document,
    and tells of them by the signals of `runs`."""

    def __init__(self, workspace: Workspace, document: Document, runs: RunController) -> None:
        super().__init__(runs)
        self._runs = runs
        self._workspace = workspace
        self.document = document
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda found: self._end("finished", found))
        self._worker.cancelled.connect(lambda: self._end("cancelled"))
        self._worker.failed.connect(self._fail)
        self._worker.paused.connect(runs.state_changed)
        self._work: Work | None = None
        self._stopping = False
        self._next: Callable[[], None] | None = None
        """What follows the current re-solve, if it is no other re-solve."""
        self._waiting: dict[int, bool] = {}
        """The blocks to re-solve once what is going on has ended, and whether they were edited."""

    @property
    def state(self) -> RunState:
        """The state of the work on the frame."""
        work = self._work
        if work is None or not self._worker.busy:
            return RunState.IDLE
        if work.kind is RunState.RESOLVING:
            return RunState.RESOLVING
        if self._stopping:
            return RunState.STOPPING
        return RunState.PAUSED if self._worker.is_paused else work.kind

    @property
    def resolving(self) -> tuple[int, ...]:
        """The blocks that are being re-solved."""
        return () if self._work is None else self._work.resolves

    @property
    def _steps(self) -> Execution | None:
        return None if self._work is None else self._work.steps

    @property
    def queued(self) -> set[int]:
        """Blocks of the run that have not started yet."""
        work, steps = self._work, self._steps
        return set() if work is None or steps is None else set(steps.blocks) - work.begun - work.done

    @property
    def completed(self) -> list[int]:
        """The blocks that have a result, of whatever state, or are being run, in ascending order."""
        return sorted({*self.document.results.kept, *(() if self._steps is None else self._steps.blocks)})

    @property
    def share_done(self) -> float:
        """Share of the pixels of the run's blocks whose block has been filtered, 0-1."""
        work, steps = self._work, self._steps
        if work is None or steps is None or not steps.blocks:
            return 0.0
        sizes = {label: np.count_nonzero(block.mask) for label, block in steps.blocks.items()}
        return sum(sizes[label] for label in work.done | steps.uncorrected.keys()) / sum(sizes.values())

    @property
    def stage(self) -> str:
        """What the run does now ("Preparing", "Filtering", "Correcting") and, if it can be told, of how many blocks."""
        work, steps = self._work, self._steps
        if self.state is not RunState.RUNNING or work is None or steps is None:
            return self.state.value.capitalize()
        total, done = len(steps.blocks), len(work.done | steps.uncorrected.keys())
        if not (done or work.begun):
            return "Preparing"
        return "Correcting" if steps.uncorrected and done == total else f"Filtering {done} of {total}"

    def start(self, only: set[int] | None = None, stepwise: bool = False) -> None:
        """Run all blocks, or some; with `stepwise`, one block at a time, pausing after each step."""
        if self.resolving:
            self._follow_up(lambda: self.start(only, stepwise))
            return
        run = self.document.run(self.document.state.common, only)
        steps = run.steps(1 if stepwise else spare_cores(), self._workspace.watch(self.document, run))
        self._start(Work(self.document, run, time.perf_counter(), steps=steps), lambda: steps, stepwise)

    def start_changed(self) -> None:
        """Run the blocks without an up-to-date result."""
        changed = self.document.changed_blocks()
        if changed:
            self.start(set(changed))
        else:
            self._runs.ended.emit(
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
        work = self._work
        if work is None:
            self._begin_resolve(blocks)
            return
        former = self._waiting
        self._waiting = {label: edited or former.get(label, False) for label in blocks}
        self._waiting |= {label: was for label, was in former.items() if label not in self._waiting}
        if work.resolves and self._next is None:
            age_ms = math.ceil(1000 * (time.perf_counter() - work.started))
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
        resolves = tuple(label for label in blocks if label in there)
        if not resolves:
            self._runs.state_changed.emit()
            return
        run = self.document.run(self.document.state.common, resolves)
        work = Work(self.document, run, time.perf_counter(), RunState.RESOLVING, resolves=resolves)
        work.preview_time = work.started + _FIRST_PREVIEW_S
        watch = self._workspace.watch(self.document, run)
        self._start(work, lambda: run.steps(spare_cores(), watch))

    def _start(self, work: Work, make: Callable[[], Execution], paused: bool = False) -> None:
        self._work = work

        def job() -> Generator[_WithPreviews, None, None]:
            with closing(make()) as steps:  # ends its threads
                for progress in steps:
                    if progress.result is None:
                        check_cancelled()  # later records are not needed
                    yield progress, work.due_previews(steps)

        self._worker.start(job, paused, lambda step: step[0] is not NO_BLOCK)
        self._runs.state_changed.emit()

    def extrapolate(self) -> None:
        """Extrapolate what the blocks leave missing."""
        completion = self.document.completion()
        if self.resolving:
            self._follow_up(self.extrapolate)
        elif self.state.free and completion is not None and not self.document.extrapolated:
            self._begin_extrapolation(completion)

    def _begin_extrapolation(self, completion: Completion) -> None:
        run = self.document.run(self.document.state.common)
        self._work = Work(self.document, run, time.perf_counter(), RunState.EXTRAPOLATING, base=completion)
        present = replace(completion, run=run)

        def told(record: IterationRecord) -> _WithPreviews:
            return Step(EXTRAPOLATED, record=record), None

        self._worker.start(lambda: mapped_steps(extrapolation_steps(present), told))
        self._runs.state_changed.emit()

    def toggle_pause(self) -> None:
        """Pause the run after the current iteration, or resume it."""
        self._worker.order(Order.RUN if self.state is RunState.PAUSED else Order.PAUSE)
        self._runs.state_changed.emit()

    def step(self) -> None:
        """Run one iteration, then pause: of the current run, or of a new one over the selected blocks, or all."""
        if self.state.free:
            self.start(self._chosen() or None, stepwise=True)
        else:
            self._worker.order(Order.STEP)
            self._runs.state_changed.emit()

    def cancel(self) -> None:
        """Cancel after the current iteration; completed blocks keep their results."""
        if self._worker.busy:
            self._stopping = True
            self._next = None
            self._waiting = {label: True for label, edited in self._waiting.items() if edited and not self.resolving}
            self._worker.cancel()
            self._runs.state_changed.emit()

    def clear_results(self) -> None:
        """Remove all results, also those of a re-solve or an extrapolation in progress."""
        if self._work is not None and self._work.kind is not RunState.RUNNING:
            self._work.abandoned = True
            self._waiting = {}
            self.cancel()
        self.document.clear_results()

    def _take(self, batch: list[_WithPreviews]) -> None:
        work = self._work
        if work is None or work.abandoned or work.base is not None:
            return
        fresh: dict[int, list[IterationRecord]] = {}
        results = [progress.result for progress, _ in batch if progress.result is not None]
        for progress, _ in batch:
            if progress.record is not None:
                fresh.setdefault(progress.label, []).append(progress.record)
        work.begun.update(fresh)
        for label, records in fresh.items():
            self.document.add_records(label, records)
        for _, previews in batch:
            if previews is not None:
                self.document.add_previews(previews)
                work.preview_time = time.perf_counter() + _PREVIEWS_S
        if results:
            work.done.update(result.block.label for result in results)
            # the invalid mask may have changed since the run started
            self.document.store_results(results, work.run.frame)

    def _end(self, how: str, found: Completion | None = None) -> None:
        work, self._work, self._stopping = self._work, None, False
        if work is None:
            return
        work.how, work.seconds = how, time.perf_counter() - work.started
        if work.base is not None:
            self._end_extrapolation(work, work.base, found)
            return
        following, self._next = self._next, None
        if work.steps is not None and how != "finished":
            # blocks that were iterated keep their results, though they are not corrected yet
            self.document.store_results(list(work.steps.uncorrected.values()), work.run.frame)
            work.done.update(work.steps.uncorrected)
        # another re-solve follows: the previews stay until then
        self.document.end_run(keep_previews=bool(work.resolves and self._waiting and following is None))
        if following is not None:
            following()
        if self.state is RunState.IDLE:
            self._resolve_waiting(one for one in work.resolves if one not in work.done)
        self._runs.run_ended.emit(work)
        if work.steps is not None:
            self._report_ended(work, work.steps)

    def _report_ended(self, work: Work, steps: Execution) -> None:
        """Tell how a run has ended; after a finished one, extrapolate the rest if that is part of it."""
        document, completion = self.document, self.document.completion()
        text = f"{document.name}: run {work.how}, {counted(len(work.done), 'block')} in {work.seconds:.1f} s."
        lost = len(work.done - set(document.valid_results()))
        if lost:
            text += f" {counted(lost, 'block')} edited meanwhile."
        if uncorrected := len(work.done & steps.uncorrected.keys()):
            text += f" {counted(uncorrected, 'block')} without the learned correction: run again (F5)."
        self._runs.ended.emit(" ".join((text, *notes_of(steps.results))))
        if work.how != "finished":
            return
        if document.state.extrapolate and completion is not None and self.state is RunState.IDLE:
            self._begin_extrapolation(completion)
        else:
            self._runs.finished.emit(document)

    def _end_extrapolation(self, work: Work, base: Completion, found: Completion | None) -> None:
        document = self.document
        holds = found is not None and document.completion() is base
        if found is None:
            text = f"extrapolation {work.how}."
        elif not (count := int(np.count_nonzero(found.extrapolated))):
            text = "no depth is missing; nothing to extrapolate."
        elif not holds:
            text = "blocks were edited during the extrapolation: extrapolate again."
        else:
            text = f"{counted(count, 'pixel')} extrapolated in {work.seconds:.1f} s (unsupported by measurements)."
        if found is not None:
            text = " ".join((text, *(note for note in found.notes if note not in base.notes)))
            if holds:
                document.store_extrapolation(base, found)
        self._resolve_waiting()
        self._runs.ended.emit(f"{document.name}: {text}")
        if holds:
            self._runs.finished.emit(document)

    def _fail(self, error: Exception) -> None:
        self._next, self._waiting = None, {}
        self._end("failed")
        self._runs.failed.emit(error)


class RunController(QObject):
    """The runs of all frames in parallel; the state is that of the current frame.

    Signals
    -------
    state_changed()
        `state` or `queued` has changed, of any frame.
    ended(str)
        A run has ended; a message with its outcome.
    run_ended(object)
        A run or a re-solve has ended and its results are stored; its `Work`.
    finished(object)
        A run has finished, including the extrapolation if there is one; its document.
    failed(object)
        A run failed with an exception.
    """

    state_changed = Signal()
    ended = Signal(str)
    run_ended = Signal(object)
    finished = Signal(object)
    failed = Signal(object)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._all: dict[Document, FrameRuns] = {}
        """By frame, also those of closed frames until they have ended."""
        workspace.on(Part.LIST, self._cancel_closed)
        self.state_changed.connect(self._forget_closed)

    def of(self, document: Document) -> FrameRuns:
        """Return the runs of a frame."""
        if document not in self._all:
            self._all[document] = FrameRuns(self._workspace, document, self)
        return self._all[document]

    @property
    def current(self) -> FrameRuns:
        """The runs of the current frame."""
        return self.of(self._workspace.current)

    @property
    def running(self) -> list[Document]:
        """Frames with a run or an extrapolation in progress."""
        return [
            document for document, runs in self._all.items() if not runs.state.free and document in self._workspace.open
        ]

    @property
    def state(self) -> RunState:
        """The state of the current frame's run."""
        return self.current.state if self._workspace.shown is not None else RunState.IDLE

    def _cancel_closed(self) -> None:
        """Cancel the runs of frames that are no longer open."""
        for document, runs in list(self._all.items()):
            if document not in self._workspace.open:
                runs.cancel()
        self._forget_closed()

    def _forget_closed(self) -> None:
        """Delete the runs of closed frames that have ended."""
        for document, runs in list(self._all.items()):
            if runs.state is RunState.IDLE and document not in self._workspace.open:
                del self._all[document]
                runs.deleteLater()


# Live depth: blocks that an edit has changed are re-solved automatically.


class LiveSolver(QObject):
    """Re-solves blocks that were edited since the frame was run, or that get other parameters, the selected one first.

    Blocks changed during a run are re-solved after it. States that undo restores are not re-solved.

    Parameters
    ----------
    live : QAction
        The action that switches it on.
    """

    def __init__(self, workspace: Workspace, runs: RunController, live: QAction) -> None:
        super().__init__(runs)
        self._workspace = workspace
        self._runs = runs
        self._live = live
        workspace.edited.connect(self._take)

    def follow_parameters(self, first: Iterable[int]) -> None:
        """Re-solve the blocks of the current frame that the present parameters change, some of them `first`, also if
        these have no result yet; while a slider moves, what is being solved is not dropped at once."""
        if self._live.isChecked():
            runs = self._runs.current
            changed = {*runs.document.changed_blocks(), *runs.resolving}
            if wanted := [label for label in dict.fromkeys((*first, *runs.completed)) if label in changed]:
                runs.resolve(wanted)

    def _take(self, edit: Edit) -> None:
        document, chosen = edit.document, self._workspace.chosen
        if self._live.isChecked() and (document.results.kept or document in self._runs.running):
            there = edit.blocks & document.counts().keys()
            wanted = [label for label in there if not document.is_up_to_date(label)]
            if wanted:
                self._runs.of(document).resolve(sorted(wanted, key=lambda label: (label != chosen, label)), edited=True)
