"""Bench of completion: run methods over frames and patterns."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..._runtime.children import run_units
from ..._runtime.files import read_json
from ..._runtime.schema import converted
from ...completion.confidence.expected_error import DEFAULT_MODEL, depth_error
from ...completion.filter import edges_for
from ...completion.interpolation import nearest
from ...data.parameters import PRESETS
from ...errors import FormatError, IlfError, InputError, told_as
from ...segmentation.extraction import extract_blocks
from ..evaluation import evaluate
from ..metrics import share_within, sparsification_error
from .frames import load_bench_frame
from .methods import METHODS
from .patterns import Task, make_task
from .results import BenchResult, Row, Score, Skipped, TaskFacts


def score(depth: NDArray[np.floating], task: Task, error_model: str = DEFAULT_MODEL) -> Score:
    """Score completed depth [m], shape (H, W), NaN = not filled.

    Pixels that the method did not fill count with the nearest input depth, so leaving pixels out is no advantage.
    `error_model`, one of `ilf.completion.confidence.fitted.MODELS`, gives the expected error.
    """
    covered = np.isfinite(depth) & (depth > 0)
    dense = np.where(covered, depth, nearest(task.frame))
    errors, coverage = evaluate(dense, task.ground_truth, task.scored), float(np.mean(covered[task.scored]))
    found = Score(errors.pixels, errors.rmse, errors.mae, errors.median, errors.rel, errors.delta[0], coverage)
    filled = task.scored & covered
    if not filled.any():
        return found
    error = depth[filled] - task.ground_truth[filled]
    expected = depth_error(task.frame, depth, error_model)[filled]
    return replace(
        found,
        within=share_within(error, expected),
        within_twice=share_within(error, expected, 2),
        sparsification=sparsification_error(error, expected),
    )


T = TypeVar("T")


def timed(run: Callable[[], T], otherwise: T) -> tuple[T, float, str]:
    """Run a method; returns its result, or `otherwise` if it fails, the seconds, and the reason of a failure or ""."""
    started, failure = time.perf_counter(), ""
    try:
        result = run()
    except (IlfError, MemoryError) as error:
        result, failure = otherwise, str(error) or type(error).__name__
    return result, time.perf_counter() - started, failure


@dataclass(frozen=True)
class EarlierResult:
    """Rows of an earlier bench, of methods that do not depend on this program and need not run again.

    Attributes
    ----------
    path : str
        File of the earlier result.
    tasks : tuple of TaskFacts
    rows : tuple of Row
    """

    path: str
    tasks: tuple[TaskFacts, ...]
    rows: tuple[Row, ...]

    def of(self, facts: TaskFacts) -> dict[str, Row]:
        """Return method -> row for a task that is the same as in the earlier bench.

        Raises
        ------
        InputError
            If the earlier bench does not have the frame, or its input or scored pixels differ.
        """
        task, what = (facts.pattern, facts.frame), f"{facts.frame}, pattern {facts.pattern}"
        known = [earlier.sha256 for earlier in self.tasks if (earlier.pattern, earlier.frame) == task]
        if not known:
            raise InputError(f"{self.path} has no rows of {what}. Use its frames and patterns, or run the peers again.")
        if facts.sha256 not in known:
            told = "its methods had other colour or depth, or hidden pixels. Use its seed, or run the peers again."
            raise InputError(f"{self.path} does not fit {what}: {told}")
        return {row.method: row for row in self.rows if (row.pattern, row.frame) == task}


def read_earlier_result(path: str | os.PathLike[str], methods: Sequence[str]) -> EarlierResult:
    """Read the methods of a result that need not run again: peers that use no blocks.

    Their expected errors are taken from the earlier result.

    Parameters
    ----------
    path : path-like
        Written by `ilf bench --json`.
    methods : sequence of str
        Methods of the new bench.

    Raises
    ------
    InputError
        If the file does not exist, or has none of these methods.
    FormatError
        If it is not a result of this bench.
    """
    told = f"{path} is not a result of `ilf bench --json` of this version ({{error}}). Run the peers again."
    with told_as(FormatError, told, FormatError):
        result = converted(read_json(path), BenchResult, "result")
    rows = tuple(row for row in result.rows if row.method in methods and not METHODS[row.method].needs_blocks)
    if not rows:
        raise InputError(f"{path} has no rows of the peers to compare. Run the peers again.")
    return EarlierResult(str(path), result.tasks, rows)


def run_bench(
    folders: Sequence[Path],
    patterns: Sequence[str],
    methods: Sequence[str],
    seed: int = 0,
    *,
    jobs: int = 1,
    earlier: EarlierResult | None = None,
    on_progress: Callable[[str], None] = lambda name: None,
) -> BenchResult:
    """Run every method on every frame under every pattern.

    Parameters
    ----------
    folders : sequence of Path
        Frame folders.
    patterns, methods : sequence of str
        Of `PATTERNS` and `METHODS`.
    seed : int
        Base seed of the patterns.
    jobs : int
        Processes that share the frames. More than one makes the timings longer and less accurate; all else stays.
    earlier : EarlierResult, optional
        Its methods are not run again.
    on_progress : callable, optional
        Called with a frame's name whenever it is done under one pattern.

    Raises
    ------
    InputError
        If the earlier rows do not fit.
    """
    units = [(folder, pattern, methods, seed, earlier) for pattern in patterns for folder in folders]
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: on_progress(units[number][0].name))
    return BenchResult(
        tuple(row for part in parts for row in part.rows),
        tuple(task for part in parts for task in part.tasks),
        # an unreadable frame is reported once per pattern
        tuple(dict.fromkeys(item for part in parts for item in part.skipped)),
    )


def _run_unit(
    folder: Path, pattern: str, methods: Sequence[str], seed: int, earlier: EarlierResult | None
) -> BenchResult:
    try:
        source = load_bench_frame(folder)
    except IlfError as error:
        return BenchResult((), (), (Skipped(folder.name, "", str(error)),))
    name = source.frame.name
    try:
        task = make_task(source, pattern, seed)
    except IlfError as error:
        return BenchResult((), (), (Skipped(name, pattern, str(error)),))
    facts = TaskFacts(pattern, name, source.sensor, task.sha256)
    taken = {} if earlier is None else earlier.of(facts)
    labels, extraction_seconds = np.zeros(task.frame.shape, np.int32), 0.0
    if any(METHODS[method].needs_blocks for method in methods):
        started = time.perf_counter()
        labels = extract_blocks(task.frame)
        extraction_seconds = time.perf_counter() - started
    rows = (taken.get(method) or _run_method(method, task, labels, extraction_seconds, facts) for method in methods)
    return BenchResult(tuple(rows), (facts,), ())


def _run_method(name: str, task: Task, labels: np.ndarray, extraction_seconds: float, facts: TaskFacts) -> Row:
    method, error_model = METHODS[name], DEFAULT_MODEL
    if name in PRESETS:
        error_model = PRESETS[name].filter
        started = time.perf_counter()
        edges_for(task.frame, PRESETS[name])
        extraction_seconds += time.perf_counter() - started
    # failing counts as filling nothing
    depth, seconds, failure = timed(lambda: method.run(task.frame, labels), task.frame.depth)
    return Row(
        **vars(score(depth, task, error_model)),
        pattern=facts.pattern,
        frame=facts.frame,
        method=name,
        seconds=seconds,
        extraction_seconds=extraction_seconds if method.needs_blocks else None,
        failure=failure,
    )
