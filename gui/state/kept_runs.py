"""Runs of a frame that are kept beside each other, to be compared and come back to. No widgets."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import dataclass, field

from ilf.outcomes import BlockResult, Completion, compose
from ilf.run import Run

Colour = tuple[int, int, int]

MOST_COMPARED = 4
"""Kept runs that can be compared at a time."""


@dataclass(eq=False)
class KeptRun:
    """What a run was made of, and what it gave.

    Attributes
    ----------
    number : int
        From 1, never given twice in a frame.
    name : str
    run : ilf.Run
        What it was made of.
    results : mapping of int to BlockResult
        Block label -> result.
    seconds : float
        How long it took [s].
    colour : tuple of int
        Red, green, blue of its curves.
    note : str
        What the user says of it.
    when : datetime
    """

    number: int
    name: str
    run: Run
    results: Mapping[int, BlockResult]
    seconds: float
    colour: Colour
    note: str = ""
    when: datetime.datetime = field(default_factory=datetime.datetime.now)
    _completion: Completion | None = field(default=None, repr=False)

    @property
    def completion(self) -> Completion:
        """What its results compose to."""
        if self._completion is None:
            self._completion = compose(self.run.frame, self.results)
        return self._completion
