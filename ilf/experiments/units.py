"""Units of an experiment's work, counted as they are done."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from ..processes import run_units
from .experiment import OnProgress

Result = TypeVar("Result")


def run_counted(
    function: Callable[..., Result], units: Sequence[tuple[Any, ...]], jobs: int, on_progress: OnProgress
) -> list[Result]:
    """What a function at the top level of a module makes of every unit, in the units' order."""
    done = 0

    def count(_: int) -> None:
        nonlocal done
        done += 1
        on_progress(done, len(units))

    on_progress(0, len(units))
    return run_units(function, units, jobs=jobs, on_done=count)
