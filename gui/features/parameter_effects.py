"""How much a change of a parameter changes the depth of a frame: one that was made, and those that can be tried."""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import grouped, millimetres
from ilf.data.declarations import Declaration, Value
from ilf.data.parameters import Parameters
from ilf.evaluation.sweep import can_be_swept, suggested_range
from ilf.run.run import Run

from ..work.jobs import spare_cores

_LEAST = 1e-4
"""Smallest difference of depth that counts as a change [m]."""

Depth = NDArray[np.float32]


class Effect(NamedTuple):
    """How much depth has changed.

    Attributes
    ----------
    pixels : int
        Pixels that differ by 0.1 mm or more, or are missing in one of the two only.
    median, largest : float
        Of the differences at these pixels [m]; NaN if there are none.
    """

    pixels: int
    median: float
    largest: float

    @property
    def text(self) -> str:
        """The effect in words."""
        if not self.pixels:
            return "no pixel changed by 0.1 mm"
        if np.isnan(self.median):
            return f"{grouped(self.pixels)} px changed: missing before or after"
        return (
            f"{grouped(self.pixels)} px changed: median {millimetres(self.median)}, "
            f"largest {millimetres(self.largest)} mm"
        )

    @property
    def size(self) -> float:
        """What effects are compared by: the median difference, for every changed pixel [m]."""
        return self.pixels * self.median if np.isfinite(self.median) else 0.0


def effect_of(pairs: Iterable[tuple[Depth, Depth]]) -> Effect:
    """Compare depth [m] before and after a change, NaN = missing, in any number of parts."""
    pixels, changed = 0, []
    for before, after in pairs:
        difference = np.abs(after - before)
        pixels += int(np.count_nonzero(np.isnan(before) != np.isnan(after)))
        changed.append(difference[difference >= _LEAST])
    differences = np.concatenate(changed) if changed else np.empty(0, np.float32)
    if not differences.size:
        return Effect(pixels, np.nan, np.nan)
    return Effect(pixels + differences.size, float(np.median(differences)), float(differences.max()))


Tried = tuple[Value, Effect]
"""The value of a parameter that changed the depth most of those that were tried, and its effect."""


def try_parameters(run: Run, names: Sequence[str], blocks: Collection[int]) -> Generator[float, None, dict[str, Tried]]:
    """Try other values of parameters on some blocks of a run, all if none are given; yield the share done."""
    run = replace(run, only=tuple(blocks) or None, extrapolate=False)
    declarations = Parameters.declarations()
    present = run.parameters_of(next(iter(blocks))) if blocks else run.parameters
    trials = [(name, value) for name in names for value in _other_values(declarations[name], getattr(present, name))]
    yield 0.0
    base = run.complete(threads=spare_cores()).depth
    found: dict[str, Tried] = {}
    for number, (name, value) in enumerate(trials, 1):
        yield number / (len(trials) + 1)
        own = {label: run.parameters_of(label).replace(**{name: value}) for label in blocks}
        common = run.parameters if blocks else run.parameters.replace(**{name: value})
        depth = run.with_parameters(common, own).complete(threads=spare_cores()).depth
        effect = effect_of([(base, depth)])
        if name not in found or effect.size > found[name][1].size:
            found[name] = value, effect
    return found


def _other_values(declaration: Declaration, value: Value) -> list[Value]:
    """Return values that differ from the present one: both ends of a range around a number, all other choices."""
    if declaration.choices:
        values: Sequence[Value] = tuple(declaration.choices)
    elif declaration.kind is bool:
        values = (True, False)
    elif can_be_swept(declaration):
        values = [declaration.checked(declaration.kind(end)) for end in suggested_range(declaration, value)]
    else:
        values = ()
    return [other for other in values if other != value]
