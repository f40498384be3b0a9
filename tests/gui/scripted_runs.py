"""Runs that go on step by step as a test allows, and a workspace with the run control to start them from."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QTimer

from gui.state.document import Document
from gui.state.workspace import Workspace
from gui.work.frame_runs import RunController, RunState, Work
from ilf import RGBDFrame
from ilf.data.blocks import Block, find_blocks
from ilf.data.results import NO_BLOCK, BlockOutcome, BlockResult, IterationRecord, Status, Step
from ilf.run.run import Run
from ilf.segmentation.edges.frame_edges import edge_parameters
from ilf.segmentation.editing.patches import LabelPatch, patch_between


def record(i: int) -> IterationRecord:
    return IterationRecord(i, 1, 0.01 / i, 1.0, 0.0, np.nan, 0.0)


class Script:
    """What the scripted runs have been asked for, and how far they may go.

    Every block takes `records` iterations, one after the other, and `silent` steps that tell of none; each step waits
    for `allow`. Results have the `notes`.
    """

    def __init__(self) -> None:
        self.records = 2
        self.silent = 0
        self.notes: tuple[str, ...] = ()
        self.error: Exception | None = None
        self.runs: list[ScriptedSteps] = []
        self._steps = threading.Semaphore(0)

    def allow(self, steps: int = 100_000) -> None:
        self._steps.release(steps)

    def wait(self) -> None:
        assert self._steps.acquire(timeout=20)
        if self.error is not None:
            raise self.error


class ScriptedSteps(Iterator[Step]):
    """Takes the place of `ilf.run.run.Execution`."""

    def __init__(self, script: Script, run: Run, threads: int | None) -> None:
        self.run = run
        self.threads = threads
        self.blocks = find_blocks(run.blocks.labels, run.only)
        self.results: dict[int, BlockResult] = {}
        self.uncorrected: dict[int, BlockResult] = {}
        self.previews = 0
        self.closed = False
        self._script = script
        self._live: list[Block] = []
        self._all = self._steps()
        script.runs.append(self)

    def _steps(self) -> Iterator[Step]:
        for label, block in self.blocks.items():
            self._live = [block]
            for i in range(1, self._script.records + 1):
                self._script.wait()
                yield Step(label, record=record(i))
            for _ in range(self._script.silent):
                self._script.wait()
                yield NO_BLOCK
            self._script.wait()
            self._live = []
            self.results[label] = self._result(label, block)
            yield Step(label, result=self.results[label])

    def _result(self, label: int, block: Block) -> BlockResult:
        depth = np.full(np.count_nonzero(block.mask), 2.0, np.float32)
        count = self._script.records
        outcome = BlockOutcome(label, Status.COMPLETED, "", depth.size, 0, depth.size, count, 1, 0.001)
        history = tuple(record(i) for i in range(1, count + 1))
        parameters = self.run.parameters_of(label)
        edges = edge_parameters(parameters, self.run.blocks.extraction)
        return BlockResult(
            block,
            depth,
            outcome,
            history,
            parameters,
            notes=self._script.notes,
            edges=edges,
            drawn=self.run.blocks.drawn_of(block),
        )

    def preview(self) -> list[tuple[Block, NDArray[np.float32]]]:
        self.previews += 1
        return [(block, np.full(np.count_nonzero(block.mask), 1.5, np.float32)) for block in self._live]

    def __next__(self) -> Step:
        return next(self._all)

    def close(self) -> None:
        self.closed = True


class Bench:
    """A workspace with one frame of two blocks, the run control, and all that it says."""

    def __init__(
        self, frame: RGBDFrame, labels: NDArray[np.int32], script: Script, until: Callable[[Callable[[], bool]], None]
    ) -> None:
        self.frame, self.labels, self.script, self._until = frame, labels, script, until
        self.workspace = Workspace()
        self.records: list[tuple[int, list[int]]] = []
        self.document = self.open("first")
        self.workspace.tell()
        self.runs = RunController(self.workspace)
        self.said: list[str] = []
        self.resolved: list[Work] = []
        self.failed: list[Exception] = []
        self.finished: list[Document] = []
        self.states: list[RunState] = []
        runs = self.runs
        runs.ended.connect(self.said.append)
        runs.run_ended.connect(lambda work: self.resolved.extend([work] if work.resolves and work.done else []))
        runs.failed.connect(self.failed.append)
        runs.finished.connect(self.finished.append)
        runs.state_changed.connect(lambda: self.states.append(runs.state))

    def open(self, name: str) -> Document:
        frame = replace(self.frame, name=name)
        document = Document.of(Run(frame, self.labels), None, name)
        self.workspace.open_document(document)
        add = document.add_records

        def note(label: int, records: Sequence[IterationRecord]) -> None:
            self.records.append((label, [record.i for record in records]))
            add(label, records)

        document.add_records = note  # type: ignore[method-assign]
        return document

    def patch(self, label: int, rows: slice, columns: slice) -> LabelPatch | None:
        """A box of the blocks that becomes another one's."""
        labels = self.document.labels.copy()
        labels[rows, columns] = label
        return patch_between(self.document.labels, labels)

    def get_going(self, label: int = 1) -> None:
        """Let what was started make its first iteration, of this block."""
        self.script.allow(1)
        self._until(lambda: self.document.results.running == [label])

    def finish(self) -> None:
        """Let what is under way go on to its end, and wait for what is said of it."""
        self.script.allow()
        self._until(lambda: bool(self.said))

    def rest(self, steps: int | None = None) -> None:
        """Let it make so many steps, or all, and wait until nothing runs."""
        self.script.allow() if steps is None else self.script.allow(steps)
        self._until(lambda: self.runs.state is RunState.IDLE)

    def cancel(self) -> None:
        self.runs.current.cancel()
        self.finish()

    def run_all(self, labels: set[int] | None = None) -> None:
        """Run all blocks, or these, to the end."""
        self.runs.current.start(labels)
        self.rest()

    def run_first_block(self) -> None:
        """Start a run, and wait until its first block is done."""
        self.runs.current.start()
        self.script.allow(3)
        self._until(lambda: 1 in self.document.valid_results())

    @property
    def patience(self) -> QTimer:
        """What lets a re-solve of the first frame end when its values have changed."""
        return self.runs.of(self.document)._worker._later

    @property
    def run(self) -> ScriptedSteps:
        """The latest run."""
        return self.script.runs[-1]
