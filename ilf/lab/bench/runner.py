"""Bench of completion: run methods over frames and patterns."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_json
from ..._runtime.processes import run_units
from ..._runtime.schema import converted
from ...completion.completion import prepare
from ...completion.confidence.expected_error import DEFAULT_MODEL, depth_error
from ...completion.interpolation import nearest
from ...data.parameters import PRESETS
from ...errors import FormatError, IlfError, InputError
from ...evaluation.metrics import ErrorMeasures, fill_rate, measure_errors, share_within, sparsification_error
from ...segmentation.extraction import extract_blocks
from .frames import load_bench_frame
from .methods import METHODS
from .patterns import Task, make_task
from .results import BenchResult, Plan, Row, Skipped, TaskFacts

# Score of completed depth on a task.


@dataclass(frozen=True)
class Score:
    """Score of completed depth.

    Attributes
    ----------
    errors : ErrorMeasures
        Over all scored pixels.
    coverage : float
        Share of these (0-1) that the method filled itself.
    within : float or None
        Share of the filled pixels whose error lies within the expected error; None if the method filled none.
    within_twice : float or None
        The same for twice the expected error.
    sparsification : float or None
        `ilf.evaluation.metrics.sparsification_error` of the filled pixels.
    """

    errors: ErrorMeasures
    coverage: float
    within: float | None = None
    within_twice: float | None = None
    sparsification: float | None = None


def score(depth: NDArray[np.floating], task: Task, error_model: str = DEFAULT_MODEL) -> Score:
    """Score completed depth [m], shape (H, W), NaN = not filled.

    Pixels that the method did not fill count with the nearest input depth, so leaving pixels out is no advantage.
    `error_model`, one of `ilf.completion.confidence.fitted.MODELS`, gives the expected error.
    """
    covered = np.isfinite(depth) & (depth > 0)
    dense = np.where(covered, depth, nearest(task.frame))
    errors, coverage = measure_errors(dense, task.ground_truth, task.scored), fill_rate(depth, task.scored)
    filled = task.scored & covered
    if not filled.any():
        return Score(errors, coverage)
    error = depth[filled] - task.ground_truth[filled]
    expected = depth_error(task.frame, depth, error_model)[filled]
    return Score(
        errors,
        coverage,
        share_within(error, expected),
        share_within(error, expected, 2),
        sparsification_error(error, expected),
    )


# Rows of peers from an earlier result: methods that do not depend on this program need not run again.


@dataclass(frozen=True)
class EarlierResult:
    """Rows of an earlier bench, of methods that use no blocks.

    Attributes
    ----------
    path : str
        File of the earlier result.
    methods : tuple of str
    rows : mapping
        (pattern, frame, method) -> Row.
    sha256 : mapping
        (pattern, frame) -> `TaskFacts.sha256`.
    """

    path: str
    methods: tuple[str, ...]
    rows: Mapping[tuple[str, str, str], Row]
    sha256: Mapping[tuple[str, str], str]

    def of(self, facts: TaskFacts) -> dict[str, Row]:
        """Return method -> row for a task that is the same as in the earlier bench.

        Raises
        ------
        InputError
            If the earlier bench does not have the frame, or its input or scored pixels differ.
        """
        what = f"{facts.frame}, pattern {facts.pattern}"
        known = self.sha256.get((facts.pattern, facts.frame))
        if known is None:
            raise InputError(f"{self.path} has no rows of {what}. Use its frames and patterns, or run the peers again.")
        if known != facts.sha256:
            raise InputError(
                f"{self.path} does not fit {what}: its methods had other colour or depth, or other held-out pixels. "
                "Use its seed, or run the peers again."
            )
        return {method: self.rows[facts.pattern, facts.frame, method] for method in self.methods}


@dataclass(frozen=True)
class _ResultFile:
    """The part of a result's file that is read."""

    rows: tuple[Row, ...]
    tasks: tuple[TaskFacts, ...]


def read_earlier_result(path: str | os.PathLike[str], methods: Sequence[str]) -> EarlierResult:
    """Read the methods of a result that need not run again: peers that use no blocks.

    Their expected errors are taken from the earlier result.

    Parameters
    ----------
    path : path-like
        Written by `write_json`.
    methods : sequence of str
        Methods of the new bench.

    Raises
    ------
    InputError
        If the file does not exist, or has none of these methods.
    FormatError
        If it is not a result of this bench.
    """
    try:
        result = converted(read_json(path), _ResultFile, "result")
    except FormatError as error:
        raise FormatError(
            f"{path} is not a result of `ilf bench --json` of this version ({error!s:.120}). Run the peers again."
        ) from error
    found = {row.method for row in result.rows}
    taken = tuple(method for method in methods if method in found and not METHODS[method].needs_blocks)
    if not taken:
        raise InputError(f"{path} has no rows of the peers to compare. Run the peers again.")
    return EarlierResult(
        str(path),
        taken,
        {(row.pattern, row.frame, row.method): row for row in result.rows},
        {(task.pattern, task.frame): task.sha256 for task in result.tasks},
    )


@dataclass
class _Part:
    """Results of one frame under one pattern."""

    rows: list[Row] = field(default_factory=list)
    tasks: list[TaskFacts] = field(default_factory=list)
    skipped: list[Skipped] = field(default_factory=list)


def run_bench(
    plan: Plan,
    *,
    jobs: int = 1,
    earlier: EarlierResult | None = None,
    on_progress: Callable[[str], None] | None = None,
) -> BenchResult:
    """Run every method on every frame under every pattern.

    Parameters
    ----------
    plan : Plan
    jobs : int
        Processes that share the frames. More than one makes the timings longer and less accurate; all else stays.
    earlier : EarlierResult, optional
        Its methods are not run again.
    on_progress : callable, optional
        Called with a frame's name whenever it is done under one pattern.

    Raises
    ------
    InputError
        If the earlier rows do not fit the plan.
    """
    units = [
        (folder, pattern, plan.methods, plan.seed, earlier) for pattern in plan.patterns for folder in plan.folders
    ]
    report = on_progress or (lambda name: None)
    parts = run_units(_run_unit, units, jobs=jobs, on_done=lambda number: report(units[number][0].name))
    rows = tuple(row for part in parts for row in part.rows)
    tasks = tuple(task for part in parts for task in part.tasks)
    # an unreadable frame is reported once per pattern
    skipped = tuple(dict.fromkeys(item for part in parts for item in part.skipped))
    return BenchResult(plan, rows, tasks, skipped)


def _run_unit(folder: Path, pattern: str, methods: Sequence[str], seed: int, earlier: EarlierResult | None) -> _Part:
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
