"""Bench of completion: run methods over frames and patterns."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..._runtime.children import run_in_processes
from ...completion.confidence.expected_error import DEFAULT_MODEL, depth_error
from ...completion.interpolation import nearest
from ...data.parameters import PRESETS
from ...errors import IlfError
from ...segmentation.edges.frame_edges import edges_for
from ...segmentation.extraction import extract_blocks
from ..evaluation import evaluate, share_within
from .frames import Task, load_bench_frame, make_task
from .methods import BY_BLOCKS, METHODS
from .results import BenchResult, BenchRow, Score, Skipped


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


def sparsification_error(error: NDArray[np.floating], expected: NDArray[np.floating]) -> float:
    """Compute the area between the sparsification curves of the expected and of the true errors: 0 is perfect.

    Pixels are removed one by one, those with the largest expected error first, and the RMSE of the rest is computed
    each time; likewise by their true errors, which is the optimal order. The result is the mean difference of these two
    curves over the RMSE of all pixels. A random order has 0.6 for normally distributed errors, and more if few are
    large. It depends only on the order of the expected errors, not on their size.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True errors (signed) and expected errors (positive) [m]; at least one. Pixels with equal expected errors have
        the mean of their squared errors.

    Examples
    --------
    >>> error = np.array([0.1, 0.2, 0.4])
    >>> sparsification_error(error, error), round(sparsification_error(error, 1 - error), 2)
    (0.0, 0.58)
    """
    squares = np.square(error, dtype=np.float64)
    _, ranks, counts = np.unique(expected, return_inverse=True, return_counts=True)
    by_expected = np.repeat(np.bincount(ranks, squares) / counts, counts)
    total = float(np.sqrt(squares.mean()))
    if total == 0:
        return 0.0
    return float(np.mean(_rmse_of_first(by_expected) - _rmse_of_first(np.sort(squares)))) / total


def _rmse_of_first(squares: NDArray[np.float64]) -> NDArray[np.float64]:
    """RMSE of the first, the first two, ... of some squared errors."""
    return np.sqrt(np.cumsum(squares) / np.arange(1, squares.size + 1))


T = TypeVar("T")


def timed(run: Callable[[], T], otherwise: T) -> tuple[T, float, str]:
    """Run a method; returns its result, or `otherwise` if it fails, the seconds, and the reason of a failure or ""."""
    started, failure = time.perf_counter(), ""
    try:
        result = run()
    except (IlfError, MemoryError) as error:
        result, failure = otherwise, str(error) or type(error).__name__
    return result, time.perf_counter() - started, failure


_Unit = tuple[Path, str, tuple[str, ...], int]
"""Folder, pattern, methods and base seed."""


def run_bench(
    folders: Sequence[Path],
    patterns: Sequence[str],
    methods: Sequence[str],
    seed: int = 0,
    *,
    jobs: int = 1,
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
    on_progress : callable, optional
        Called with a frame's name whenever it is done under one pattern.

    Raises
    ------
    IlfError
        If a process has ended before its work was done.
    """
    units = [(folder, pattern, tuple(methods), seed) for pattern in patterns for folder in folders]
    here = ((unit, _run_unit(unit)) for unit in units)
    found: dict[_Unit, BenchResult] = {}
    for unit, part in here if jobs == 1 else run_in_processes(_run_unit, units, jobs=jobs):
        if part is None:
            raise IlfError("A worker process ended. Memory may have run out: close programs, or use fewer --jobs.")
        found[unit] = part
        on_progress(unit[0].name)
    parts = [found[unit] for unit in units]
    return BenchResult(
        tuple(row for part in parts for row in part.rows),
        # an unreadable frame is reported once per pattern
        tuple(dict.fromkeys(item for part in parts for item in part.skipped)),
    )


def _run_unit(unit: _Unit) -> BenchResult:
    folder, pattern, methods, seed = unit
    try:
        source = load_bench_frame(folder)
    except IlfError as error:
        return BenchResult((), (Skipped(folder.name, "", str(error)),))
    name = source.frame.name
    try:
        task = make_task(source, pattern, seed)
    except IlfError as error:
        return BenchResult((), (Skipped(name, pattern, str(error)),))
    labels, extraction_seconds = np.zeros(task.frame.shape, np.int32), 0.0
    if any(method in BY_BLOCKS for method in methods):
        started = time.perf_counter()
        labels = extract_blocks(task.frame)
        extraction_seconds = time.perf_counter() - started
    rows = (_run_method(method, task, labels, extraction_seconds) for method in methods)
    return BenchResult(tuple(replace(row, pattern=pattern, sensor=source.sensor) for row in rows), ())


def _run_method(name: str, task: Task, labels: np.ndarray, extraction_seconds: float) -> BenchRow:
    error_model = DEFAULT_MODEL
    if name in PRESETS:
        error_model = PRESETS[name].filter
        started = time.perf_counter()
        edges_for(task.frame, PRESETS[name])
        extraction_seconds += time.perf_counter() - started
    # failing counts as filling nothing
    depth, seconds, failure = timed(lambda: METHODS[name](task.frame, labels), task.frame.depth)
    return BenchRow(
        **vars(score(depth, task, error_model)),
        frame=task.frame.name,
        method=name,
        seconds=seconds,
        extraction_seconds=extraction_seconds if name in BY_BLOCKS else None,
        failure=failure,
    )
