"""What all filters promise to those who iterate with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..data.results import IterationRecord


class Stepper(Iterator[IterationRecord], Protocol):
    """ILF on one block: an iterator, of which every `next()` is one iteration and gives its record.

    It ends when its filter has let through all that it is to let through and the iteration is steady, or after
    `max_iterations`. `next()` is for one thread at a time; `surface` may be looked at from any other meanwhile. The
    results depend on frame, block, its drawn pixels and parameters alone: neither on threads nor on other blocks.
    """

    def __next__(self) -> IterationRecord:
        """One iteration: its record, whose `i` is one more than that of the last, and whose `stage` does not fall."""
        ...

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; before i = 1 what there is to
        start from. Finite everywhere, but not always depth: it may be 0 or below. The caller's own."""
        ...

    def snapshot(self) -> Snapshot:
        """The surface as it stands, to be worked out later: P_i where it may become depth, elsewhere P_i or raw."""
        ...

    def judge(self, pixels: NDArray[np.bool_], truth: NDArray[np.float64]) -> None:
        """Let the records of all iterations to come tell their error against a truth, which changes nothing else.

        Parameters
        ----------
        pixels : ndarray of bool
            Some of the block's pixels, in the order of `block.mask`'s True values.
        truth : ndarray of float64
            Their true depth [m].
        """
        ...

    @property
    def settled(self) -> bool:
        """Whether the last stage has come to its end, rather than the iteration to `max_iterations`."""
        ...

    @property
    def remark(self) -> str:
        """What is to be said about how a settled iteration has ended; "" where there is nothing."""
        ...

    @property
    def explained(self) -> bool:
        """Whether a smooth surface explains all of the known depth up to its noise; False where none is looked for."""
        ...

    @property
    def network(self) -> str | None:
        """SHA-256 of the edge network that had a part in it; None if none had."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know of how it came about: none if all is as asked for."""
        ...


class Snapshot(NamedTuple):
    """What an iteration has come to. It costs next to nothing, and stays as it is when the iteration goes on.

    Attributes
    ----------
    work_out : callable
        Gives P_i at the block's pixels; from any thread.
    nbytes : int
        Memory that it holds for itself.
    shared : int
        Memory that it holds together with all other snapshots of its stepper.
    """

    work_out: Callable[[], NDArray[np.float64]]
    nbytes: int
    shared: int

    @property
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values."""
        return self.work_out()
