"""Work as a generator: steps for progress and cancellation, and a result at its end."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from typing import TypeVar

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")


def run_to_end(steps: Generator[S, None, T], on_step: Callable[[S], object] | None = None) -> T:
    """Run all steps and return their result. An exception in `on_step` ends them."""
    told = mapped_steps(steps, on_step or (lambda step: None))
    while True:
        try:
            next(told)
        except StopIteration as end:
            result: T = end.value
            return result


def mapped_steps(steps: Generator[S, None, T], change: Callable[[S], R]) -> Generator[R, None, T]:
    """Yield the changed steps, and return their result."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            yield change(step)
