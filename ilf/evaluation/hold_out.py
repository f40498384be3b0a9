"""Hold-out evaluation of a run: known depth is hidden, completed and compared."""

from __future__ import annotations

import hashlib
import math
import time
from collections.abc import Callable, Collection, Generator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import run_to_end
from ..completion.confidence.expected_error import expected_error
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.pixel_grids import drawn_from
from ..data.results import Completion
from ..errors import InputError, ParameterError, check_kind
from ..run.run import Run
from ..sources.frame_ref import COMPLETED_DEPTH, FrameRef, is_result
from .evaluation import Evaluated, PixelErrors, Progress, restrict_to_shared, scaled_progress

# Patterns of hidden depth: the same pixels for the same frame and seed.

RANDOM_KEPT = 0.4277
"""Share of the known depth that the pattern "random" keeps; that of the paper's Table 1."""

AREAS_HIDDEN = 0.25
"""Share of the known depth that the pattern "areas" hides."""

AREA_SEMI_AXES = (0.03, 0.12)
"""Shortest and longest semi-axis of its ellipses, in widths of the frame."""

HOLD_OUT_PATTERNS = {
    "random": f"{RANDOM_KEPT:.2%} of the known depth kept, pixel by pixel",
    "areas": f"{AREAS_HIDDEN:.0%} of the known depth hidden in ellipses",
}
"""Name -> description."""


@once_per_frame
def hidden_pixels(frame: RGBDFrame, pattern: str, seed: int = 0) -> NDArray[np.bool_]:
    """Find the pixels whose depth a pattern hides.

    Parameters
    ----------
    frame : RGBDFrame
        The pixels depend on its name and on where depth was measured, not on its invalid mask.
    pattern : str
        One of `HOLD_OUT_PATTERNS`.
    seed : int
        Not negative.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Some of the pixels with measured depth.

    Raises
    ------
    InputError
        For another pattern, or for depth that was completed by this program: some of it was not measured.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> int(hidden_pixels(frame, "areas").sum()), int(hidden_pixels(frame, "random", seed=3).sum())
    (500, 1145)
    """
    if pattern not in HOLD_OUT_PATTERNS:
        raise InputError(f"There is no pattern {pattern!r}. Known: {', '.join(HOLD_OUT_PATTERNS)}.")
    if frame.inputs is not None and is_result(FrameRef.of(frame.inputs)):
        raise InputError(f"{frame.inputs.depth.path}: {COMPLETED_DEPTH}")
    measured = np.isfinite(frame.measured)
    rng = generator(frame.name, pattern, seed)
    if pattern == "random":
        return drawn_from(measured, rng, slice(round(RANDOM_KEPT * int(np.count_nonzero(measured))), None))
    return _areas(measured, rng)


@once_per_frame
def frame_without(frame: RGBDFrame, pattern: str, seed: int = 0) -> RGBDFrame:
    """Make a frame of the same colour without the depth that a pattern hides, invalid depth and ground truth.

    Parameters
    ----------
    frame, pattern, seed
        As for `hidden_pixels`.

    Raises
    ------
    InputError
        If no depth would be left, or for another pattern.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> frame_without(frame, "areas").missing_share
    0.25
    """
    depth = np.where(hidden_pixels(frame, pattern, seed), np.float32(np.nan), frame.own_depth)
    if not np.isfinite(depth).any():
        raise InputError("Too little depth is known: all of it would be hidden. Use a frame with more depth.")
    return RGBDFrame(
        frame.edge_rgb,
        depth,
        frame.intrinsics,
        frame.name,
        guide=frame.guide,
        notes=frame.notes,  # what is doubted there is not doubted again
        outside_view=frame.outside_view,
        neighbours=frame.neighbours,
    )


def untrusted_note(frame: RGBDFrame) -> str:
    """A sentence on known depth of a frame that is not counted as ground truth (`RGBDFrame.trusted`); "" for none."""
    own = int(np.count_nonzero(frame.own))
    left_out = own - int(np.count_nonzero(frame.trusted))
    if not left_out:
        return ""
    return (
        f"{left_out / own:.1%} of the known depth, a constant {frame.invalid_marker:.3f} m, most likely marks missing "
        "depth and is not counted as ground truth."
    )


def generator(name: str, pattern: str, seed: int) -> np.random.Generator:
    """The random numbers of a pattern for a frame of this name."""
    digest = hashlib.sha256(f"{pattern}:{name}".encode()).digest()
    return np.random.default_rng([seed, *np.frombuffer(digest, "<u4").tolist()])


def _areas(known: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
    """Ellipses around known pixels; the last one is reduced to the required share."""
    rows, columns = np.indices(known.shape, np.float32)
    visible = known.copy()
    left = round(AREAS_HIDDEN * np.count_nonzero(known))
    while left > 0:
        row, column = divmod(int(rng.choice(np.flatnonzero(visible))), known.shape[1])
        semi_axes = np.maximum(rng.uniform(*AREA_SEMI_AXES, 2) * known.shape[1], 1.0)
        angle = rng.uniform(0, math.pi)
        along = (columns - column) * math.cos(angle) + (rows - row) * math.sin(angle)
        across = (rows - row) * math.cos(angle) - (columns - column) * math.sin(angle)
        distance = (along / semi_axes[0]) ** 2 + (across / semi_axes[1]) ** 2
        inside = np.flatnonzero(visible & (distance <= 1))
        nearest = inside[np.argsort(distance.ravel()[inside], kind="stable")[:left]]
        visible.ravel()[nearest] = False
        left -= nearest.size
    return known & ~visible


@dataclass(frozen=True)
class HoldOutTest:
    """The pattern and the seeds of a hold-out test.

    Parameters
    ----------
    pattern : str
        "areas", holes as large as those of cameras, or "random", pixel by pixel (`HOLD_OUT_PATTERNS`).
    seeds : tuple of int
        Not negative; the test runs once for each, and the errors are pooled.

    Raises
    ------
    ParameterError
        For another pattern, without seeds, or for a seed that is not an integer from 0 on.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> print(HoldOutTest("areas", seeds=(0, 1)).hidden(frame, 0).mean())
    0.25
    """

    pattern: str = "areas"
    seeds: tuple[int, ...] = (0, 1, 2)

    def __post_init__(self) -> None:
        check_kind(self.seeds, Collection, "Seeds are several integers", "give them as (0, 1, 2).")
        if self.pattern not in HOLD_OUT_PATTERNS:
            raise ParameterError(f"There is no pattern {self.pattern!r}. Known: {', '.join(HOLD_OUT_PATTERNS)}.")
        object.__setattr__(self, "seeds", tuple(dict.fromkeys(self.seeds)))
        if not self.seeds or not all(type(seed) is int and seed >= 0 for seed in self.seeds):
            raise ParameterError(f"A hold-out test needs seeds: integers from 0 on, not {self.seeds!r:.40}.")

    def hidden(self, frame: RGBDFrame, seed: int) -> NDArray[np.bool_]:
        """The hidden pixels, bool (H, W), for one of the seeds; the same for all runs of a frame."""
        return hidden_pixels(frame, self.pattern, seed)


@dataclass(frozen=True, eq=False)
class RunEvaluation(Evaluated):
    """The evaluation of a run, with one part, or one per seed of a hold-out test.

    Attributes
    ----------
    run : Run
    seconds : float
        Duration.
    test : HoldOutTest or None
        None for an evaluation against ground truth.
    """

    run: Run
    seconds: float
    test: HoldOutTest | None = None


# Several runs of one frame, evaluated one after the other and then over the same pixels.

R = TypeVar("R", bound=RunEvaluation)


def compared_steps(several: Sequence[Generator[Progress, None, R]]) -> Generator[Progress, None, list[R]]:
    """Evaluate runs one after the other; returns the results over the pixels that all of them have filled.

    Runs that fill less than nine tenths of what the best one fills do not restrict these pixels.

    Parameters
    ----------
    several : sequence of generators
        `hold_out_steps` of every run with the same test, or `ground_truth_steps` of every run.

    Yields
    ------
    Progress

    Returns
    -------
    list
        Their results, in the same order.
    """
    width = 1 / max(len(several), 1)
    results = []
    for number, steps in enumerate(several):
        text = f"run {number + 1} of {len(several)}, "
        result = yield from scaled_progress(steps, number * width, width, text)
        results.append(result)
    return restrict_to_shared(results)


# A run, step by step, with the finished fraction.


def completion_steps(run: Run, threads: int | None) -> Generator[Progress, None, Completion]:
    """Complete a run's blocks, with a step per iteration of a block; returns the completion."""
    with run.steps(threads) as steps:
        sizes = {label: int(np.count_nonzero(block.mask)) for label, block in steps.blocks.items()}
        total, done = max(sum(sizes.values()), 1), 0
        for progress in steps:
            if progress.result is not None:
                done += sizes[progress.label]
            yield Progress(done / total, f"{len(steps.results)} of {len(sizes)} blocks")
        return steps.completion()


def hold_out_steps(
    run: Run, test: HoldOutTest | None = None, only: Collection[int] | None = None, *, threads: int | None = None
) -> Generator[Progress, None, RunEvaluation]:
    """`evaluate_hold_out` step by step, for progress and cancellation.

    Parameters
    ----------
    run, test, only, threads
        As for `evaluate_hold_out`.

    Yields
    ------
    Progress

    Returns
    -------
    RunEvaluation

    Raises
    ------
    InputError
        If too little depth is known.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> steps = hold_out_steps(ilf.Run(frame, np.ones((40, 50), np.int32)), HoldOutTest("random", (0,)))
    >>> step = next(steps)
    >>> step.share, step.text
    (0.0, 'seed 0: 0 of 1 blocks')
    >>> steps.close()
    """
    chosen, started = test or HoldOutTest(), time.perf_counter()
    width = 1 / len(chosen.seeds)
    parts = []
    for number, seed in enumerate(chosen.seeds):
        steps = _one_seed(run, chosen.pattern, seed, only, threads)
        part = yield from scaled_progress(steps, number * width, width, f"seed {seed}: ")
        parts.append(part)
    return RunEvaluation(run.blocks.labels, tuple(parts), run, time.perf_counter() - started, chosen)


def evaluate_hold_out(
    run: Run,
    test: HoldOutTest | str | None = None,
    only: Collection[int] | None = None,
    *,
    threads: int | None = None,
    on_step: Callable[[Progress], None] | None = None,
) -> RunEvaluation:
    """Hide some of a frame's known depth, complete its blocks without it, and compute the errors.

    The blocks are not changed: the hidden depth may have affected their borders, but nothing else. On eight real
    frames, this made errors 3 % (RMSE) and 7 % (MAE) smaller, in the median, than with blocks extracted without that
    depth. Nothing is extrapolated, even if the run is dense. Hidden depth that most likely marks missing depth, as the
    frame's plausibility warnings say, is not evaluated (`RGBDFrame.trusted`).

    Parameters
    ----------
    run : Run or Completion
    test : HoldOutTest or str, optional
        A pattern of `HOLD_OUT_PATTERNS` stands for its test with three seeds; areas if left out.
    only : collection of int, optional
        Only these blocks; those of the run if left out. Blocks without hidden depth are not run.
    threads : int, optional
        As for `Run.steps`.
    on_step : callable, optional
        Called with every `Progress`; an exception in it ends the test.

    Returns
    -------
    RunEvaluation

    Raises
    ------
    InputError
        If too little depth is known.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> result = evaluate_hold_out(ilf.Run(frame, np.ones((40, 50), np.int32)), HoldOutTest("areas", (0, 1)))
    >>> result.pixels, result.coverage, result.whole.pixels, bool(result.whole.rmse < 0.001)
    (1000, 1.0, 1000, True)
    """
    run = run.run if isinstance(run, Completion) else run
    check_kind(run, Run, "A hold-out needs a run", "give ilf.Run.of(frame), or what ilf.complete returns.")
    test = HoldOutTest(test) if isinstance(test, str) else test
    check_kind(test, HoldOutTest | None, "The second argument must be a test", 'give ilf.HoldOutTest("areas", (0, 1)).')
    return run_to_end(hold_out_steps(run, test, only, threads=threads), on_step)


def _one_seed(
    run: Run, pattern: str, seed: int, only: Collection[int] | None, threads: int | None
) -> Generator[Progress, None, PixelErrors]:
    evaluated = hidden_pixels(run.frame, pattern, seed) & run.frame.trusted & (run.blocks.labels > 0)
    wanted = run.only if only is None else only
    if wanted is not None:
        evaluated &= np.isin(run.blocks.labels, list(wanted))
    labels = np.unique(run.blocks.labels[evaluated]).tolist()
    alone = replace(run, frame=frame_without(run.frame, pattern, seed), only=frozenset(labels), extrapolate=False)
    completion = yield from completion_steps(alone, threads)
    return PixelErrors.at(evaluated, completion.depth, run.frame.depth, expected_error(completion))
