"""Several runs of one frame, judged one after the other and then over the same pixels."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import TypeVar

from .judged import RunJudged, over_shared
from .step import Step, part_of

R = TypeVar("R", bound=RunJudged)


def compared_steps(several: Sequence[Generator[Step, None, R]]) -> Generator[Step, None, list[R]]:
    """Judge runs one after the other; returns what they come to, over the pixels that all of them have filled.

    Runs that leave more than a tenth of what the best one fills open have no say in which pixels these are.

    Parameters
    ----------
    several : sequence of generators
        `hidden_steps` of every run with the same test, or `truth_steps` of every run.

    Yields
    ------
    Step

    Returns
    -------
    list
        What these return, in their order.
    """
    width = 1 / max(len(several), 1)
    results = []
    for number, steps in enumerate(several):
        text = f"run {number + 1} of {len(several)}, "
        result = yield from part_of(steps, number * width, width, text)
        results.append(result)
    shared = over_shared([result.judged for result in results])
    return [replace(result, judged=judged) for result, judged in zip(results, shared, strict=True)]
