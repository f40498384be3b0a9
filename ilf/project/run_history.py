"""The run history: stored runs with their results and errors."""

from __future__ import annotations

import datetime
import weakref
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ..data.arrays import frozen
from ..data.blocks import Colour
from ..data.results import BlockResult, Completion, compose
from ..evaluation.hold_out import HoldOutTest
from ..run.run import Run


class Extrapolation(NamedTuple):
    """Depth that the extrapolation has added to a run's results: flat pixel indices and their depth [m]."""

    pixels: NDArray[np.int64]
    depth: NDArray[np.float32]
    notes: tuple[str, ...]
    network: str | None

    @classmethod
    def of(cls, completion: Completion) -> Self:
        """Return the extrapolated depth of a completion."""
        pixels = np.flatnonzero(completion.extrapolated)
        depth = frozen(completion.depth.ravel()[pixels])
        return cls(pixels, depth, completion.notes, completion.extrapolation_network)

    def added_to(self, completion: Completion) -> Completion:
        """Return the completion with the extrapolated depth added."""
        depth, extrapolated = completion.depth.copy(), np.zeros_like(completion.filled)
        depth.ravel()[self.pixels] = self.depth
        extrapolated.ravel()[self.pixels] = True
        filled = completion.filled | extrapolated
        return replace(
            completion,
            depth=depth,
            filled=filled,
            extrapolated=extrapolated,
            notes=self.notes,
            extrapolation_network=self.network,
        )


@dataclass(eq=False)
class StoredRun:
    """A run in the run history, with its results and errors.

    Stored runs share equal data: frames, label maps, results of blocks.

    Attributes
    ----------
    number : int
        From 1, unique in a frame and never reused.
    name : str
    run : Run
        All blocks of the frame, and their parameters as they were set.
    results : mapping of int to BlockResult
        Block label -> result, of all blocks that had one when the run ended, including blocks that it did not run.
    seconds : float
        Duration [s]; 0 if it is not known, as of a run that was opened from its record.
    colour : tuple of int
        Red, green, blue of its curves.
    note : str
        The user's note on the run.
    when : datetime
    done : frozenset of int
        Blocks that it has run.
    how : str
        "finished", "cancelled" or "failed".
    extrapolation : Extrapolation or None
        Extrapolated depth, if the missing rest was extrapolated.
    ground_truth_error, hold_out_error, expected_error : float or None
        RMS [m] over the pixels that its blocks have filled: of the error against ground truth, of the error on
        hold-out, and of the expected error. NaN if undefined, None if not computed.
    hold_out_test : HoldOutTest or None
        The hold-out; errors on different hold-outs cannot be compared.
    """

    number: int
    name: str
    run: Run
    results: Mapping[int, BlockResult]
    seconds: float
    colour: Colour
    note: str = ""
    when: datetime.datetime = field(default_factory=datetime.datetime.now)
    done: frozenset[int] = frozenset()
    how: str = "finished"
    extrapolation: Extrapolation | None = None
    ground_truth_error: float | None = None
    hold_out_error: float | None = None
    expected_error: float | None = None
    hold_out_test: HoldOutTest | None = None
    _composed: weakref.ref[Completion] | None = field(default=None, repr=False)

    @property
    def completion(self) -> Completion:
        """The composed results, including extrapolated depth; cached by a weak reference."""
        found = None if self._composed is None else self._composed()
        if found is None:
            found = compose(self.run, self.results)
            if self.extrapolation is not None:
                found = self.extrapolation.added_to(found)
            self._composed = weakref.ref(found)
        return found

    def take_extrapolation(self, completion: Completion) -> None:
        """Store the extrapolated depth of a completion."""
        self.extrapolation, self._composed = Extrapolation.of(completion), weakref.ref(completion)

    def take(self, run: Run, results: Mapping[int, BlockResult]) -> None:
        """Replace run and results by a later state of the same step."""
        self.run, self.results = run, results
        self.extrapolation = self.hold_out_test = None
        self.ground_truth_error = self.hold_out_error = self.expected_error = None
        self._composed = None
        for name in ("block_count", "iterations", "recovered", "outdated"):
            self.__dict__.pop(name, None)

    @cached_property
    def block_count(self) -> int:
        """Number of blocks in its label map."""
        return int(np.count_nonzero(np.bincount(self.run.blocks.labels.ravel())[1:]))

    @cached_property
    def iterations(self) -> int:
        """Number of iterations over all blocks that it has run."""
        return sum(self.results[label].outcome.iterations for label in self.done if label in self.results)

    @cached_property
    def recovered(self) -> int:
        """Number of pixels that its blocks have filled."""
        return sum(result.outcome.recovered for result in self.results.values())

    @cached_property
    def outdated(self) -> tuple[int, ...]:
        """Blocks that the run left unchanged and whose results come from other parameters than were set."""
        wanted = self.run.parameters_of
        results = self.results.items()
        return tuple(label for label, result in results if not result.parameters.same_effect(wanted(label)))

    def is_of(self, results: Mapping[int, BlockResult]) -> bool:
        """Return whether these are the same result objects."""
        ours = self.results
        return ours.keys() == results.keys() and all(ours[label] is result for label, result in results.items())

    def equals(self, results: Mapping[int, BlockResult]) -> bool:
        """Return whether these results equal its own in every pixel."""
        ours = self.results
        return ours.keys() == results.keys() and all(_same(ours[label], result) for label, result in results.items())


def _same(one: BlockResult, other: BlockResult) -> bool:
    return one is other or (
        one.parameters == other.parameters
        and one.block.box == other.block.box
        and np.array_equal(one.block.mask, other.block.mask)
        and np.array_equal(one.depth, other.depth, equal_nan=True)
    )
