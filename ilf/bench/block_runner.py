"""Running the block methods over frames."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import IlfError
from ..frame import RGBDFrame
from ..processes import run_units
from .block_measures import BlockScore, score_blocks
from .block_methods import BLOCK_METHODS
from .evidence import Evidence, find_evidence
from .frames import load_bench_frame


@dataclass(frozen=True)
class BlockPlan:
    """What is compared: frame folders, and names of methods."""

    folders: tuple[Path, ...]
    methods: tuple[str, ...]


@dataclass(frozen=True)
class BlockRow(BlockScore):
    """One method on one frame: its score, the seconds of the extraction, and why it failed, "" if it did not."""

    frame: str
    method: str
    seconds: float
    failure: str


@dataclass(frozen=True)
class SkippedFrame:
    """A frame that was left out, and why."""

    frame: str
    reason: str


@dataclass(frozen=True)
class BlockBenchResult:
    """All rows, by frame and method in the order of the plan, and the frames that were left out."""

    plan: BlockPlan
    rows: tuple[BlockRow, ...]
    skipped: tuple[SkippedFrame, ...]


def run_block_bench(
    plan: BlockPlan, *, jobs: int = 1, on_progress: Callable[[str], None] | None = None
) -> BlockBenchResult:
    """Run every method on every frame, with all of its depth.

    Nothing is hidden from the methods: those that use depth have seen what they are measured with, just as they see
    it when the frame is completed.

    Parameters
    ----------
    plan : BlockPlan
    jobs : int
        Processes that share the frames. More than one makes the seconds longer and less certain; all else stays.
    on_progress : callable, optional
        Called with a frame's name whenever it is done.
    """
    report = on_progress or (lambda name: None)
    units = [(folder, plan.methods) for folder in plan.folders]
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: report(units[number][0].name))
    rows = tuple(row for part in parts if not isinstance(part, SkippedFrame) for row in part)
    return BlockBenchResult(plan, rows, tuple(part for part in parts if isinstance(part, SkippedFrame)))


def _run_unit(folder: Path, methods: Sequence[str]) -> list[BlockRow] | SkippedFrame:
    try:
        frame = load_bench_frame(folder).frame
    except IlfError as error:
        return SkippedFrame(folder.name, str(error))
    evidence = find_evidence(frame)
    return [_run_method(method, frame, evidence) for method in methods]


def _run_method(name: str, frame: RGBDFrame, evidence: Evidence) -> BlockRow:
    failure = ""
    started = time.perf_counter()
    try:
        labels = BLOCK_METHODS[name].run(frame)
    except (IlfError, MemoryError) as error:
        labels, failure = np.zeros(frame.shape, np.int32), str(error) or type(error).__name__
    seconds = time.perf_counter() - started
    score = dataclasses.asdict(score_blocks(labels, evidence))
    return BlockRow(frame=frame.name, method=name, seconds=seconds, failure=failure, **score)
