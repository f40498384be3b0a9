"""Evaluation of a run against its frame's ground truth."""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..completion.confidence.expected_error import expected_error
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.results import Completion
from ..errors import InputError
from ..run.run import Run
from .evaluation import MIN_RELATIVE_COVERAGE, PixelErrors, Progress
from .hold_out import RunEvaluation, completion_steps


def ground_truth_steps(run: Run, *, threads: int | None = None) -> Generator[Progress, None, RunEvaluation]:
    """Complete a run's blocks and compare them with ground truth where depth was missing; nothing is extrapolated, even
    if the run is dense.

    Parameters
    ----------
    run : Run
        A run of a frame with ground truth.
    threads : int, optional
        As for `Run.steps`.

    Yields
    ------
    Progress

    Returns
    -------
    RunEvaluation

    Raises
    ------
    InputError
        If the frame has no ground truth where depth is missing in the blocks that are run.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, ground_truth=np.full((20, 30), 2.01))
    >>> steps = ground_truth_steps(ilf.Run(frame, np.ones((20, 30), np.int32)))
    >>> next(steps).text
    '0 of 1 blocks'
    >>> steps.close()
    """
    started = time.perf_counter()
    errors, _ = yield from against_ground_truth(run, threads)
    return RunEvaluation(run.blocks.labels, (errors,), run, time.perf_counter() - started)


def against_ground_truth(
    run: Run, threads: int | None = None
) -> Generator[Progress, None, tuple[PixelErrors, Completion]]:
    """The errors of `ground_truth_steps`, and the completion; its history contains no errors of the iterations, which
    would take longer."""
    wanted, ground_truth = pixels_with_ground_truth(run), run.frame.ground_truth
    assert ground_truth is not None
    alone = replace(run, frame=_without_ground_truth(run.frame), extrapolate=False)
    completion = yield from completion_steps(alone, threads)
    return PixelErrors.at(wanted, completion.depth, ground_truth, expected_error(completion)), completion


def pixels_with_ground_truth(run: Run) -> NDArray[np.bool_]:
    """Pixels in view, bool (H, W), without depth but with ground truth in the blocks that are run; InputError if there
    are none."""
    frame = run.frame
    if frame.ground_truth is not None:
        there = run.blocks.labels > 0 if run.only is None else np.isin(run.blocks.labels, list(run.only))
        wanted = there & frame.missing & np.isfinite(frame.ground_truth)
        if wanted.any():
            return wanted
    raise InputError(f"{frame.name} has no ground truth where depth is missing in the blocks. Load one, or hold out.")


@once_per_frame
def _without_ground_truth(frame: RGBDFrame) -> RGBDFrame:
    """Cached, so that its edges are found once for all runs."""
    return frame.with_ground_truth(None)


# Pixels for the comparison of several completions of a frame: those that all of them have filled.


def shared_pixels(completions: Sequence[Completion], *, every: bool = False) -> NDArray[np.bool_]:
    """Find the pixels that all completions have filled.

    Those that fill less than nine tenths of what the best one fills are ignored.

    Parameters
    ----------
    completions : sequence of Completion
        Of one frame; at least one.
    every : bool
        Return the pixels where all have depth, filled or known.

    Returns
    -------
    ndarray of bool, shape (H, W)

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> whole = ilf.complete(frame, np.ones((20, 30), np.int32))
    >>> half = ilf.complete(frame, np.repeat([[1, 0]], 20, axis=0).repeat(15, axis=1))
    >>> int(shared_pixels([whole, whole]).sum()), int(shared_pixels([whole, half]).sum())
    (40, 40)
    """
    counts = [int(np.count_nonzero(completion.filled)) for completion in completions]
    leading = [
        one for one, count in zip(completions, counts, strict=True) if count >= MIN_RELATIVE_COVERAGE * max(counts)
    ]
    there = [np.isfinite(completion.depth) if every else completion.filled for completion in leading]
    return np.logical_and.reduce(there)
