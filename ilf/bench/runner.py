"""Running methods over frames and patterns."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..completion import prepare
from ..confidence import DEFAULT_MODEL
from ..ebs import extract_blocks
from ..errors import IlfError
from ..parameters import PRESETS
from .frames import load_bench_frame
from .methods import METHODS
from .parallel import run_units
from .patterns import Task, make_task
from .scoring import score


@dataclass(frozen=True)
class Plan:
    """What is compared: frame folders, names of patterns and methods, and the patterns' base seed."""

    folders: tuple[Path, ...]
    patterns: tuple[str, ...]
    methods: tuple[str, ...]
    seed: int = 0


@dataclass(frozen=True)
class Row:
    """One method on one frame under one pattern.

    Attributes
    ----------
    pattern, frame, method : str
    pixels : int
        Pixels scored.
    rmse, mae, median : float
        Over them [m].
    rel : float
    delta_1 : float
        Share with depth within a factor of 1.25 of the truth.
    coverage : float
        Share that the method filled itself.
    within : float or None
        Share of that whose error is at most the expected error; None if the method filled nothing.
    seconds : float
    extraction_seconds : float or None
        Time that the extraction of the blocks took before, and the filter's edges; None for methods without blocks.
    failure : str
        Why the method gave nothing, "" if it did not fail.
    """

    pattern: str
    frame: str
    method: str
    pixels: int
    rmse: float
    mae: float
    median: float
    rel: float
    delta_1: float
    coverage: float
    within: float | None
    seconds: float
    extraction_seconds: float | None
    failure: str = ""


@dataclass(frozen=True)
class Skipped:
    """A frame that was left out, of one pattern or ("") of all, and why."""

    frame: str
    pattern: str
    reason: str


@dataclass(frozen=True)
class BenchResult:
    """All rows, by pattern, frame and method in the order of the plan, and the frames that were left out."""

    plan: Plan
    rows: tuple[Row, ...]
    skipped: tuple[Skipped, ...]


@dataclass
class _Part:
    """What one frame under one pattern gave."""

    rows: list[Row] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)


def run_bench(plan: Plan, *, jobs: int = 1, on_progress: Callable[[str], None] | None = None) -> BenchResult:
    """Run every method on every frame under every pattern.

    Parameters
    ----------
    plan : Plan
    jobs : int
        Processes that share the frames. More than one makes the seconds longer and less certain; all else stays.
    on_progress : callable, optional
        Called with a frame's name whenever it is done under one pattern.
    """
    units = [(folder, pattern, plan.methods, plan.seed) for pattern in plan.patterns for folder in plan.folders]
    report = on_progress or (lambda name: None)
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: report(units[number][0].name))
    rows = tuple(row for part in parts for row in part.rows)
    # a frame that cannot be read is found out once per pattern
    skipped = tuple(dict.fromkeys(item for part in parts for item in part.skipped))
    return BenchResult(plan, rows, skipped)


def _run_unit(folder: Path, pattern: str, methods: Sequence[str], seed: int) -> _Part:
    part = _Part()
    try:
        source = load_bench_frame(folder)
    except IlfError as error:
        part.skipped.append(Skipped(folder.name, "", str(error)))
        return part
    name = source.frame.name
    try:
        task = make_task(source, pattern, seed)
    except IlfError as error:
        part.skipped.append(Skipped(name, pattern, str(error)))
        return part
    labels, extraction_seconds = np.zeros(task.frame.shape, np.int32), 0.0
    if any(METHODS[method].needs_blocks for method in methods):
        started = time.perf_counter()
        labels = extract_blocks(task.frame)
        extraction_seconds = time.perf_counter() - started
    part.rows += [_run_method(method, task, labels, extraction_seconds, pattern, name) for method in methods]
    return part


def _run_method(name: str, task: Task, labels: np.ndarray, extraction_seconds: float, pattern: str, frame: str) -> Row:
    method = METHODS[name]
    failure = ""
    if name in PRESETS:
        started = time.perf_counter()
        prepare(task.frame, PRESETS[name])
        extraction_seconds += time.perf_counter() - started
    started = time.perf_counter()
    try:
        depth = method.run(task.frame, labels)
    except (IlfError, MemoryError) as error:
        # failing counts as filling nothing
        depth, failure = task.frame.depth, str(error) or type(error).__name__
    seconds = time.perf_counter() - started
    scored = score(depth, task, PRESETS[name].filter if name in PRESETS else DEFAULT_MODEL)
    errors = scored.errors
    return Row(
        pattern=pattern,
        frame=frame,
        method=name,
        pixels=errors.pixels,
        rmse=errors.rmse,
        mae=errors.mae,
        median=errors.median,
        rel=errors.rel,
        delta_1=errors.delta[0],
        coverage=scored.coverage,
        within=scored.within,
        seconds=seconds,
        extraction_seconds=extraction_seconds if method.needs_blocks else None,
        failure=failure,
    )
