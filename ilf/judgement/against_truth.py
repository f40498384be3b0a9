"""How well a run does against its frame's truth."""

from __future__ import annotations

import time
from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..confidence import expected_error
from ..errors import InputError
from ..frame import RGBDFrame
from ..outcomes import Completion
from ..per_frame import once_per_frame
from ..run import Run
from .completing import completion_steps
from .judged import Judged, PixelErrors, RunJudged
from .step import Step


@dataclass(frozen=True, eq=False)
class TruthResult(RunJudged):
    """How well a run did against the truth, where depth was missing in the blocks that were run.

    Attributes
    ----------
    completion : Completion
        Nothing in it is guessed, and its history tells no error of the iterations, which would take longer.
    """

    completion: Completion


def truth_steps(run: Run, *, threads: int | None = None) -> Generator[Step, None, TruthResult]:
    """Complete a run's blocks and compare them with the truth; nothing is guessed, even if the run is dense.

    Parameters
    ----------
    run : Run
        Its frame has a truth.
    threads : int, optional
        As for `Run.steps`.

    Yields
    ------
    Step

    Returns
    -------
    TruthResult

    Raises
    ------
    InputError
        If the frame has no truth where depth is missing in the blocks that are run.

    Examples
    --------
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth, truth=np.full((20, 30), 2.01))
    >>> steps = truth_steps(ilf.Run(frame, np.ones((20, 30), np.int32)))
    >>> next(steps).text
    '0 of 1 blocks'
    >>> steps.close()
    """
    wanted, started = pixels_with_truth(run), time.perf_counter()
    frame, truth = _without_truth(run.frame), run.frame.truth
    assert truth is not None
    completion = yield from completion_steps(replace(run, frame=frame, dense=False), threads)
    expected = expected_error(frame, completion)
    errors = PixelErrors(np.flatnonzero(wanted), completion.depth[wanted], truth[wanted], expected[wanted])
    return TruthResult(run, Judged(run.blocks, (errors,)), time.perf_counter() - started, completion)


def pixels_with_truth(run: Run) -> NDArray[np.bool_]:
    """Pixels in view, bool (H, W), without depth but with a truth in the blocks that are run; InputError if there are
    none."""
    frame = run.frame
    if frame.truth is not None:
        there = run.blocks > 0 if run.only is None else np.isin(run.blocks, list(run.only))
        wanted = there & frame.missing & np.isfinite(frame.truth)
        if wanted.any():
            return wanted
    raise InputError(
        f"{frame.name} has no truth where depth is missing in the blocks that are run. Load one, or test on hidden "
        "depth."
    )


@once_per_frame
def _without_truth(frame: RGBDFrame) -> RGBDFrame:
    """Once, so that its edges are found once for all runs."""
    return frame.with_truth(None)
