"""Sweep of one parameter over a range, or of two on a grid: the error of each value, and the best one."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import run_to_end
from ..data.declarations import Declaration, Value
from ..data.parameters import Parameters, to_text
from ..errors import InputError, ParameterError
from ..run.run import Run
from .evaluation import PixelErrors, Progress, fills_enough, restrict_to_shared, scaled_progress
from .ground_truth import against_ground_truth, pixels_with_ground_truth
from .hold_out import HoldOutTest, RunEvaluation, completion_steps, hold_out_steps
from .ties import Ties, find_ties

MAX_POINTS = 150
"""Maximum number of points of a sweep: the depth of every point stays in memory."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """The parameters and values of a sweep, and its criterion.

    Parameters
    ----------
    run : Run
        The run to vary.
    values : mapping of str to sequence
        Name of a parameter of the filter -> its values; one name, or two for a grid.
    criterion : HoldOutTest, optional
        A hold-out test; the frame's ground truth at the filled pixels if left out.
    only : collection of int, optional
        Vary the own parameters of these blocks, and run only them. If left out, the common parameters are varied and
        all blocks are run; blocks with own parameters keep them.

    Raises
    ------
    ParameterError
        If there are not one or two names, no values, more than `MAX_POINTS` points, an unknown parameter, a value out
        of range, or a parameter without effect for all values of the others.
    InputError
        If the frame has no ground truth for the criterion, or there are no such blocks.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> run = ilf.Run(frame, np.ones((40, 50), np.int32))
    >>> sweep = Sweep(run, {"smoothness": [1, 3], "trend": [True, False]}, HoldOutTest("areas", (0,)))
    >>> len(sweep.points), sweep.points[1]
    (4, {'smoothness': 1.0, 'trend': False})
    """

    run: Run
    values: Mapping[str, Sequence[Value]]
    criterion: HoldOutTest | None = None
    only: Collection[int] | None = None

    def __post_init__(self) -> None:
        known = Parameters.declarations()
        if not 1 <= len(self.values) <= 2 or not all(len(values) for values in self.values.values()):
            raise ParameterError("A sweep needs one or two parameters with at least one value each.")
        if unknown := [name for name in self.values if name not in known]:
            self.run.parameters.replace(**dict.fromkeys(unknown))
        checked = {
            name: tuple(dict.fromkeys(known[name].checked(value) for value in values))
            for name, values in self.values.items()
        }
        object.__setattr__(self, "values", checked)
        if self.only is not None and not (self.only and np.isin(list(self.only), self.run.blocks.labels).all()):
            raise InputError(f"There are no such blocks: {sorted(self.only)}. Select existing blocks.")
        if (count := math.prod(map(len, checked.values()))) > MAX_POINTS:
            raise ParameterError(f"A sweep of {count} points needs too much memory. Give up to {MAX_POINTS} points.")
        bases = [self.run.parameters] if self.only is None else [self.run.parameters_of(label) for label in self.only]
        variants = [base.replace(**values) for base in bases for values in self.points]
        for name in checked:
            if not any(variant.has_effect(name) for variant in variants):
                raise ParameterError(variants[0].without_effect([name])[0])
        if self.criterion is None:
            pixels_with_ground_truth(self.run_with(self.points[0]))

    @property
    def points(self) -> tuple[dict[str, Value], ...]:
        """The values of every point; for two parameters every pair, the second one changing fastest."""
        return tuple(
            dict(zip(self.values, combination, strict=True)) for combination in itertools.product(*self.values.values())
        )

    def run_with(self, values: Mapping[str, Value]) -> Run:
        """The run with the values of a point."""
        if self.only is None:
            return replace(self.run, extrapolate=False).with_parameters(self.run.parameters.replace(**values))
        run = replace(self.run, only=tuple(self.only), extrapolate=False)
        own = {label: run.parameters_of(label).replace(**values) for label in self.only}
        return run.with_parameters(run.parameters, own)


@dataclass(frozen=True, eq=False)
class SweepPoint(RunEvaluation):
    """The result for some values, which its run has.

    Attributes
    ----------
    values : dict
        Name of the parameter -> value.
    depth : ndarray of float32, shape (H, W)
        Completed depth [m] without hidden depth; measured depth in blocks that were not run.
    """

    values: dict[str, Value] = field(default_factory=dict)
    depth: NDArray[np.float32] = field(kw_only=True)


@dataclass(frozen=True, eq=False)
class SweepResult:
    """All points of a sweep, evaluated over the pixels that all of them have filled.

    Points that fill less than nine tenths of what the best one fills do not restrict these pixels.

    Attributes
    ----------
    sweep : Sweep
    points : tuple of SweepPoint
        In the order of `Sweep.points`.
    ties : Ties or None
        Which points, by number, cannot be told from the best; None if none filled anything.
    """

    sweep: Sweep
    points: tuple[SweepPoint, ...]
    ties: Ties | None

    @property
    def best(self) -> SweepPoint | None:
        """The point with the smallest RMSE, the first of equals; None if none filled anything."""
        return None if self.ties is None else self.points[self.ties.best]


def sweep_steps(sweep: Sweep, *, threads: int | None = None) -> Generator[Progress | SweepPoint, None, SweepResult]:
    """`run_sweep` step by step, for progress and cancellation.

    Parameters
    ----------
    sweep, threads
        As for `run_sweep`.

    Yields
    ------
    Progress or SweepPoint
        A finished point, evaluated over all that it has filled; those of the result are evaluated over what all of them
        have filled.

    Returns
    -------
    SweepResult

    Raises
    ------
    InputError
        If too little depth is known for a hold-out.
    """
    points: list[SweepPoint] = []
    width = 1 / len(sweep.points)
    for number, values in enumerate(sweep.points):
        steps = _one_point(sweep, values, threads)
        point = yield from scaled_progress(steps, number * width, width, f"{', '.join(to_text(values))}: ")
        points.append(point)
        yield point
    points = restrict_to_shared(points)
    able = [number for number, point in enumerate(points) if fills_enough(point, points)]
    return SweepResult(sweep, tuple(points), find_ties(points, able))


def run_sweep(
    sweep: Sweep, *, threads: int | None = None, on_step: Callable[[Progress | SweepPoint], None] | None = None
) -> SweepResult:
    """Run all points of a sweep.

    Parameters
    ----------
    sweep : Sweep
    threads : int, optional
        As for `Run.steps`.
    on_step : callable, optional
        Called with every `Progress` and every finished `SweepPoint`; an exception in it ends the sweep.

    Returns
    -------
    SweepResult

    Raises
    ------
    InputError
        If too little depth is known for a hold-out.

    Examples
    --------
    >>> import ilf
    >>> ground_truth = 2 + 0.01 * np.arange(50, dtype=np.float32) * np.ones((40, 1), np.float32)
    >>> depth = ground_truth.copy()
    >>> depth[10:30, 30:] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), depth, ground_truth=ground_truth)
    >>> result = run_sweep(Sweep(ilf.Run(frame, np.ones((40, 50), np.int32)), {"filter": ["ideal", "edge-aware"]}))
    >>> [point.whole.pixels for point in result.points], result.best.values
    ([400, 400], {'filter': 'edge-aware'})
    """
    return run_to_end(sweep_steps(sweep, threads=threads), on_step)


def _one_point(sweep: Sweep, values: dict[str, Value], threads: int | None) -> Generator[Progress, None, SweepPoint]:
    started, run = time.perf_counter(), sweep.run_with(values)
    if sweep.criterion is None:
        errors, completion = yield from against_ground_truth(run, threads)
        parts: tuple[PixelErrors, ...] = (errors,)
    else:
        width = 1 / (1 + len(sweep.criterion.seeds))
        completion = yield from scaled_progress(completion_steps(run, threads), 0, width)
        hidden = yield from scaled_progress(hold_out_steps(run, sweep.criterion, threads=threads), width, 1 - width)
        parts = hidden.parts
    seconds = time.perf_counter() - started
    return SweepPoint(run.blocks.labels, parts, run, seconds, sweep.criterion, values, depth=completion.depth)


# Values of a parameter for a sweep: a range around the present value, and values spread over it.

MIN_STEPS, MAX_STEPS = 2, 50
"""Minimum and maximum number of values in a range."""

_FACTOR = 8.0
"""Range of a parameter with a logarithmic scale: from an eighth of its value to eight times it."""

_LINEAR_STEPS = 20
"""Range of other parameters in their steps, or twice the distance from the minimum if that is more."""

_DIGITS = 3
"""Number of significant digits of values."""


def can_be_swept(declaration: Declaration) -> bool:
    """Whether a parameter is a number, and thus has a range."""
    return declaration.kind in (int, float)


def suggested_range(declaration: Declaration, present: Value) -> tuple[float, float]:
    """A suitable range around the present value, within the parameter's bounds.

    Examples
    --------
    >>> from ilf.data.parameters import Parameters
    >>> suggested_range(Parameters.declarations()["smoothness"], 1.0)
    (0.125, 8.0)
    >>> suggested_range(Parameters.declarations()["boundary_strength"], 0.3)
    (0.0, 1.0)
    """
    now, step = float(present), declaration.step
    least = -math.inf if declaration.minimum is None else float(declaration.minimum)
    most = math.inf if declaration.maximum is None else float(declaration.maximum)
    if declaration.scale == "log":
        # a value without a ratio, such as 0 for "auto", is replaced by one step
        centre = now if now > 0 else max(step, least)
        low, high = centre / _FACTOR, centre * _FACTOR
    else:
        span = _LINEAR_STEPS * step
        if math.isfinite(least):
            span = max(span, 2 * (now - least))
        low = max(now - span / 2, least)
        high = low + span
    low, high = max(low, least), min(high, most)
    if declaration.kind is int:
        low, high = math.floor(low) if low >= 1 else max(least, round(low)), math.ceil(high)
    return float(f"{low:.{_DIGITS}g}"), float(f"{high:.{_DIGITS}g}")


def spread(
    declaration: Declaration,
    low: float,
    high: float,
    steps: int,
    logarithmic: bool,
    present: Value | None = None,
) -> tuple[Value, ...]:
    """Values from one end of a range to the other, increasing, each once.

    Parameters
    ----------
    declaration : Declaration
        The declaration of a number.
    low, high : float
        Both ends, which are among the values.
    steps : int
        Number of values; fewer if an integer range has fewer.
    logarithmic : bool
        Equal ratios of neighbours instead of equal differences.
    present : int or float, optional
        A value to include if it lies in the range.

    Raises
    ------
    ParameterError
        With a sentence on the error in the range.

    Examples
    --------
    >>> from ilf.data.parameters import Parameters
    >>> smoothness = Parameters.declarations()["smoothness"]
    >>> spread(smoothness, 0.1, 10, 3, logarithmic=True, present=0.5)
    (0.1, 0.5, 1.0, 10.0)
    """
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(f"{declaration.label}: the range must increase, not go from {low:g} to {high:g}.")
    if not MIN_STEPS <= steps <= MAX_STEPS:
        raise ParameterError(f"A range has {MIN_STEPS} to {MAX_STEPS} values, not {steps}.")
    if logarithmic and low <= 0:
        raise ParameterError(f"{declaration.label}: no ratios from {low:g}. Start above 0, or use differences.")
    if logarithmic:
        digits = _DIGITS + max(-math.floor(math.log10(high / low - 1)), 0)  # more where neighbours are closer
        between = [float(f"{value:.{digits}g}") for value in np.geomspace(low, high, steps)[1:-1]]
    else:
        digits = _DIGITS - math.floor(math.log10(high - low))
        between = [round(float(value), digits) for value in np.linspace(low, high, steps)[1:-1]]
    inside = (min(max(value, low), high) for value in between)
    whole = declaration.kind is int
    found = {declaration.checked(round(value) if whole else value) for value in (low, *inside, high)}
    if present is not None and low <= float(present) <= high:
        found.add(declaration.checked(present))
    return tuple(sorted(found, key=float))
