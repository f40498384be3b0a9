"""What a completion gives: a block's outcome and result, and the frame that results compose to."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from .blocks import Block
from .equality import NanEqual
from .filter.convergence import IterationRecord
from .frame import RGBDFrame
from .parameters import BlockParameters, Parameters

History = Sequence[IterationRecord]


class Status(StrEnum):
    """How a block ended."""

    COMPLETED = "completed"
    ITERATION_LIMIT = "iteration limit"
    NOT_RECOVERABLE = "not recoverable"
    NOTHING_MISSING = "nothing missing"


@dataclass(frozen=True, eq=False)
class BlockOutcome(NanEqual):
    """What became of one block. NaN equals NaN when outcomes are compared.

    Attributes
    ----------
    label : int
    status : Status
    message : str
        The reason in words, where there is one to give.
    pixels, known, recovered : int
        Pixels of the block, those with raw depth, and those in the depth camera's view that were missing and now have
        depth.
    iterations, stages : int
    sigma_i : float
        Deviation of the last iteration [m], NaN where there was none.
    outside : int
        Pixels of the block outside the depth camera's view. They count as neither missing nor recovered.
    """

    label: int
    status: Status
    message: str
    pixels: int
    known: int
    recovered: int = 0
    iterations: int = 0
    stages: int = 0
    sigma_i: float = math.nan
    outside: int = 0

    @property
    def defect_rate(self) -> float:
        """Share of the block's pixels without raw depth in the depth camera's view, 0-1."""
        return 1.0 - (self.known + self.outside) / self.pixels


def blocks_by_message(outcomes: Iterable[BlockOutcome]) -> dict[str, list[int]]:
    """Message -> labels of the blocks whose outcome has it, in their order; without those that have none."""
    found: dict[str, list[int]] = {}
    for outcome in outcomes:
        if outcome.message:
            found.setdefault(outcome.message, []).append(outcome.label)
    return found


@dataclass(frozen=True, eq=False)
class BlockResult:
    """One block's completed depth, with all that explains it.

    Attributes
    ----------
    block : Block
        The pixels, as they were when the block was run.
    depth : ndarray of float32
        Depth [m] at the block's pixels in the order of `block.mask`'s True values, NaN = still missing.
    outcome : BlockOutcome
    history : sequence of IterationRecord
    parameters : Parameters
    network : str or None
        SHA-256 of the edge network that had a part in it; None if none had.
    notes : tuple of str
        What the user should know of how it came about: none if all is as asked for.
    edges : BlockParameters or None
        What the edges that the filter took were found with (`edge_parameters`); None for the pass band.
    drawn : ndarray of bool or None
        Which of the block's pixels were marked as at a drawn border, in the order of `block.mask`'s True values
        (`drawn_of`); None if none was.
    correction : str or None
        SHA-256 of the correction network that had a part in it; None if none had.
    explained : bool
        Whether a smooth surface explains all of the block's known depth: nothing is left that a network could correct.
        Told of the run alone, and not kept.
    """

    block: Block
    depth: NDArray[np.float32]
    outcome: BlockOutcome
    history: History
    parameters: Parameters
    network: str | None = None
    notes: tuple[str, ...] = ()
    edges: BlockParameters | None = None
    drawn: NDArray[np.bool_] | None = None
    correction: str | None = None
    explained: bool = False


@dataclass(frozen=True, eq=False)
class Completion:
    """A frame's completed depth.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN where it could not be recovered.
    filled : ndarray of bool, shape (H, W)
        Pixels that had no depth and now have.
    results : dict
        Block label -> BlockResult, in rising order of labels.
    guessed : ndarray of bool, shape (H, W)
        The filled pixels that no block vouches for: none, unless `ilf.dense.fill_rest` has been asked for them.
    notes : tuple of str
        What the user should know of how it came about, each sentence once.
    guess_network : str or None
        SHA-256 of the edge network that had a part in the guesses; None if none had.
    """

    depth: NDArray[np.float32]
    filled: NDArray[np.bool_]
    results: dict[int, BlockResult]
    guessed: NDArray[np.bool_]
    notes: tuple[str, ...] = ()
    guess_network: str | None = None

    @property
    def filled_by_blocks(self) -> NDArray[np.bool_]:
        """The filled pixels without the guesses, bool, shape (H, W)."""
        return self.filled & ~self.guessed

    @property
    def history(self) -> dict[int, History]:
        """Block label -> the record of every iteration."""
        return {label: result.history for label, result in self.results.items()}

    @property
    def outcomes(self) -> dict[int, BlockOutcome]:
        """Block label -> what became of the block."""
        return {label: result.outcome for label, result in self.results.items()}


@dataclass(frozen=True, eq=False)
class Progress:
    """One step of a run: an iteration's record, or a block's result at its end, or something that is of no block."""

    label: int
    record: IterationRecord | None = None
    result: BlockResult | None = None


NO_BLOCK = Progress(0)
"""A step that tells of no block: the run has gone on, and may be left."""


def compose(frame: RGBDFrame, results: Mapping[int, BlockResult], base: Completion | None = None) -> Completion:
    """The frame's depth with the blocks' results put in; pixels of no block keep their raw depth.

    With `base`, a completion of the same frame without guesses, only what differs from it is put in anew.
    """
    former = {} if base is None else base.results
    depth = (frame.depth if base is None else base.depth).copy()
    for label, result in former.items():
        if results.get(label) is not result:
            box, mask = result.block.box, result.block.mask
            depth[box][mask] = frame.depth[box][mask]
    for label, result in results.items():
        if former.get(label) is not result:
            depth[result.block.box][result.block.mask] = result.depth
    filled = ~frame.known & np.isfinite(depth)
    in_order = dict(sorted(results.items()))
    return Completion(depth, filled, in_order, np.zeros_like(filled), notes_of(in_order))


def notes_of(results: Mapping[int, BlockResult]) -> tuple[str, ...]:
    """Each sentence once."""
    return tuple(dict.fromkeys(note for result in results.values() for note in result.notes))
