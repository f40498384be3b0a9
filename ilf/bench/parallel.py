"""Units of work, one after the other or shared by processes."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

Result = TypeVar("Result")


def run_units(
    function: Callable[..., Result],
    units: Sequence[tuple[Any, ...]],
    *,
    jobs: int = 1,
    on_done: Callable[[int], None] | None = None,
) -> list[Result]:
    """What a function makes of every unit, in the units' order.

    Parameters
    ----------
    function : callable
        At the top level of a module, so that other processes find it.
    units : sequence of tuple
        Its arguments, once per unit.
    jobs : int
        Processes that share the units; with 1 all is done in this one.
    on_done : callable, optional
        Called with a unit's number whenever one is done, in any order. What it raises ends the work, after the units
        that are under way.
    """
    report = on_done or (lambda number: None)
    results: dict[int, Result] = {}
    if jobs == 1:
        for number, unit in enumerate(units):
            results[number] = function(*unit)
            report(number)
    else:
        # Ctrl+C reaches every process of a terminal; here it is answered once
        pool = ProcessPoolExecutor(
            jobs,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),
        )
        try:
            numbers = {pool.submit(function, *unit): number for number, unit in enumerate(units)}
            for done in as_completed(numbers):
                results[numbers[done]] = done.result()
                report(numbers[done])
        finally:
            pool.shutdown(cancel_futures=True)
    return [results[number] for number in range(len(units))]
