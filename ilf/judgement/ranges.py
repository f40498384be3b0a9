"""Which values of a parameter are worth trying: a range around the present value, and values spread over it."""

from __future__ import annotations

import math

import numpy as np

from ..declarations import Declaration, Value
from ..errors import ParameterError

LEAST_STEPS, MOST_STEPS = 2, 50
"""Values that a range is spread over."""

_FACTOR = 8.0
"""A parameter whose size is felt by its ratio is tried from an eighth of its value to eight times it."""

_LINEAR_STEPS = 20
"""Another over so many of its own steps, or twice its distance from its minimum if that is more."""

_DIGITS = 3
"""Significant digits of values."""


def can_be_swept(declaration: Declaration) -> bool:
    """Whether a parameter is a number, which has a range."""
    return declaration.kind in (int, float)


def usual_range(declaration: Declaration, present: Value) -> tuple[float, float]:
    """A range around the present value that is likely to show what the parameter does, within its bounds.

    Examples
    --------
    >>> from ilf.parameters import Parameters
    >>> usual_range(Parameters.declarations()["smoothness"], 1.0)
    (0.125, 8.0)
    >>> usual_range(Parameters.declarations()["boundary_strength"], 0.3)
    (0.0, 1.0)
    """
    now, step = float(present), declaration.step
    least = -math.inf if declaration.minimum is None else float(declaration.minimum)
    most = math.inf if declaration.maximum is None else float(declaration.maximum)
    if declaration.scale == "log":
        # what has no ratio to the rest, as 0 for "auto", is left by as little as a person would
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
    """Values from one end of a range to the other, rising, each once.

    Parameters
    ----------
    declaration : Declaration
        Of a number.
    low, high : float
        Both ends, which are among the values.
    steps : int
        How many values; fewer come where a whole number has not so many.
    logarithmic : bool
        Whether neighbours have equal ratios, and not equal differences.
    present : int or float, optional
        A value that is to be among them if it lies in the range.

    Raises
    ------
    ParameterError
        With a sentence that says what is wrong with the range.

    Examples
    --------
    >>> from ilf.parameters import Parameters
    >>> smoothness = Parameters.declarations()["smoothness"]
    >>> spread(smoothness, 0.1, 10, 3, logarithmic=True, present=0.5)
    (0.1, 0.5, 1.0, 10.0)
    """
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(f"{declaration.label}: the range must rise, from {low:g} to {high:g} it does not.")
    if not LEAST_STEPS <= steps <= MOST_STEPS:
        raise ParameterError(f"A range is spread over {LEAST_STEPS} to {MOST_STEPS} values, not {steps}.")
    if logarithmic and low <= 0:
        raise ParameterError(
            f"{declaration.label}: equal ratios cannot start at {low:g}. Start above 0, or take equal differences."
        )
    if logarithmic:
        digits = _DIGITS + max(-math.floor(math.log10(high / low - 1)), 0)  # more where neighbours are closer
        between = [float(f"{value:.{digits}g}") for value in np.geomspace(low, high, steps)[1:-1]]
    else:
        digits = _DIGITS - math.floor(math.log10(high - low))
        between = [round(float(value), digits) for value in np.linspace(low, high, steps)[1:-1]]
    inside = (min(max(value, low), high) for value in between)
    found = {declaration.checked(_whole(declaration, value)) for value in (low, *inside, high)}
    if present is not None and low <= float(present) <= high:
        found.add(declaration.checked(present))
    return tuple(sorted(found, key=float))


def _whole(declaration: Declaration, value: float) -> float:
    return round(value) if declaration.kind is int else value
