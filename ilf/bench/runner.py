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
from ..processes import run_units
from .earlier import EarlierRows
from .frames import load_bench_frame
from .methods import METHODS
from .patterns import Task, make_task
from .rows import BenchResult, Plan, Row, Skipped, TaskFacts
from .scoring import score


@dataclass
class _Part:
    """What one frame under one pattern gave."""

    rows: list[Row] = field(default_factory=list)
    tasks: list[TaskFacts] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)


def run_bench(
    plan: Plan,
    *,
    jobs: int = 1,
    earlier: EarlierRows | None = None,
    on_progress: Callable[[str], None] | None = None,
) -> BenchResult:
    """Run every method on every frame under every pattern.

    Parameters
    ----------
    plan : Plan
    jobs : int
        Processes that share the frames. More than one makes the seconds longer and less certain; all else stays.
    earlier : EarlierRows, optional
        Methods that it has are not run again.
    on_progress : callable, optional
        Called with a frame's name whenever it is done under one pattern.

    Raises
    ------
    InputError
        If the earlier rows are of anything else than what is asked for.
    """
    units = [
        (folder, pattern, plan.methods, plan.seed, earlier) for pattern in plan.patterns for folder in plan.folders
    ]
    report = on_progress or (lambda name: None)
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: report(units[number][0].name))
    rows = tuple(row for part in parts for row in part.rows)
    tasks = tuple(task for part in parts for task in part.tasks)
    # a frame that cannot be read is found out once per pattern
    skipped = tuple(dict.fromkeys(item for part in parts for item in part.skipped))
    return BenchResult(plan, rows, tasks, skipped)


def _run_unit(folder: Path, pattern: str, methods: Sequence[str], seed: int, earlier: EarlierRows | None) -> _Part:
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
    facts = TaskFacts(pattern, name, source.sensor, task.sha256)
    part.tasks.append(facts)
    taken = {} if earlier is None else earlier.of(facts)
    labels, extraction_seconds = np.zeros(task.frame.shape, np.int32), 0.0
    if any(METHODS[method].needs_blocks for method in methods):
        started = time.perf_counter()
        labels = extract_blocks(task.frame)
        extraction_seconds = time.perf_counter() - started
    part.rows += [
        taken.get(method) or _run_method(method, task, labels, extraction_seconds, pattern, name) for method in methods
    ]
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
        within_twice=scored.within_twice,
        sparsification=scored.sparsification,
        seconds=seconds,
        extraction_seconds=extraction_seconds if method.needs_blocks else None,
        failure=failure,
    )
