"""How far a judgement that takes a while has come."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")
S = TypeVar("S")


@dataclass(frozen=True)
class Step:
    """A step of a judgement.

    Attributes
    ----------
    share : float
        How much of all is done, 0-1.
    text : str
        What is under way.
    """

    share: float
    text: str


def part_of(steps: Generator[Step, None, T], start: float, width: float, before: str = "") -> Generator[Step, None, T]:
    """The same steps as a part of more, which takes `width` of its share from `start` on; returns what they come to."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            yield Step(start + width * step.share, before + step.text)


def run_out(steps: Generator[S, None, T], on_step: Callable[[S], None] | None = None) -> T:
    """Go through all steps; what they come to. What `on_step` raises ends them."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            if on_step is not None:
                on_step(step)
