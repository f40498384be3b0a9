"""The base of all filters."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.results import IterationRecord


class Stepper(Iterator[IterationRecord]):
    """ILF on one block: an iterator; every `next()` runs one iteration and returns its record: `i` is one more than the
    last, and `stage` never decreases.

    It ends when the filter has reached its last stage and the iteration is steady, or after `max_iterations`. Call
    `next()` from one thread at a time; `surface` may be read from any thread meanwhile. The results depend only on
    frame, block, its drawn pixels and depth by hand, and parameters, not on threads or other blocks.
    """

    settled: bool = False
    """Whether the last stage has ended, rather than the iteration at `max_iterations`."""
    remark: str = ""
    """A remark on how a settled iteration has ended; "" for none."""
    explained: bool = False
    """Whether a smooth surface explains all of the known depth up to its noise; False if none is fitted."""
    network: str | None = None
    """SHA-256 of the edge network used; None for none."""
    notes: tuple[str, ...] = ()
    """Notes for the user, for example on replaced networks; empty if all is as requested."""

    @property
    @abstractmethod
    def surface(self) -> NDArray[np.float64]:
        """P_i at the block's pixels [m], in the order of `block.mask`'s True values; before i = 1 the initial surface.
        Finite everywhere, but may be 0 or negative, which is not depth. A copy."""

    @abstractmethod
    def snapshot(self) -> Snapshot:
        """The current surface, to be computed later: P_i where it may become depth, elsewhere P_i or raw depth."""

    @abstractmethod
    def evaluate(self, pixels: NDArray[np.bool_], ground_truth: NDArray[np.float64]) -> None:
        """Add the error against ground truth to the records of all later iterations; nothing else changes.

        Parameters
        ----------
        pixels : ndarray of bool
            Some of the block's pixels, in the order of `block.mask`'s True values.
        ground_truth : ndarray of float64
            Their ground-truth depth [m].
        """


class Snapshot(NamedTuple):
    """The state of an iteration. It is cheap, and does not change when the iteration goes on.

    Attributes
    ----------
    surface : callable
        Returns P_i at the block's pixels [m], in the order of `block.mask`'s True values; from any thread.
    nbytes : int
        Memory of its own.
    shared : int
        Memory that it shares with all other snapshots of its stepper.
    """

    surface: Callable[[], NDArray[np.float64]]
    nbytes: int
    shared: int
