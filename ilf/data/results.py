"""What a completion gives: a block's outcome and result, and the frame that results compose to."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import StrEnum
from functools import lru_cache
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted, grouped
from .blocks import Block
from .frame import RGBDFrame
from .parameters import BlockParameters, Parameters
from .pictures import html_row, plot_row

# Equality of records that may hold NaN.


class NanEqual:
    """Base of dataclasses, made with eq=False, in which NaN, the lack of a number, equals NaN."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return _values(self) == _values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(_values(self))


def _values(record: Any) -> tuple[object, ...]:
    """A record's values, None for NaN."""
    values = (getattr(record, field.name) for field in dataclasses.fields(record))
    return tuple(None if value != value else value for value in values)


# The record of one iteration, the curves that it carries, and the pixels that one of them takes.

_SEED = 0


@dataclass(frozen=True, slots=True, eq=False)
class IterationRecord(NanEqual):
    """What one iteration did, whatever the filter. NaN equals NaN when records are compared.

    Attributes
    ----------
    i : int
        Number of the iteration, from 1.
    stage : int
        Number of the stage, from 1: a stretch of iterations that all let the same through, after which the filter lets
        more through.
    sigma_i : float
        Deviation between P_i and P_(i-1) over the block [m], Eq. (2).
    l1 : float
        L1 norm of P_i over the block [m]: the sum of its absolute values.
    residual : float
        Root mean square of P_i - raw [m] over the block's known pixels that the iteration takes; NaN if there are
        none.
    held_out : float
        The same over the known pixels that are held out of it; NaN if there are none. Its minimum says where noise
        begins to come in with the band, which sigma_i does not see.
    seconds : float
        Time since the block's iteration was set up [s].
    error : float
        Root mean square of P_i - truth [m] over the block's pixels without known depth, where the frame's truth is
        known (`RGBDFrame.truth`); NaN if there are none. It is measured after the iteration, which knows nothing of it.
    """

    i: int
    stage: int
    sigma_i: float
    l1: float
    residual: float
    held_out: float
    seconds: float
    error: float = field(default=math.nan, kw_only=True)


def held_out_of(known: NDArray[np.bool_], share: float) -> NDArray[np.bool_]:
    """Known pixels to hold out of a block's iteration: a fixed choice, whatever else the frame holds.

    Parameters
    ----------
    known : ndarray of bool, shape (h, w)
        The block's known pixels on its bounding box.
    share : float
        Share of them to hold out, below 1: at least one known pixel is left.

    Returns
    -------
    ndarray of bool, shape (h, w)
    """
    held = np.zeros(known.shape, bool)
    if share == 0:
        return held
    places = np.flatnonzero(known)
    chosen = np.random.default_rng(_SEED).permutation(places)[: int(share * places.size)]
    held.flat[chosen] = True
    return held


def deviation(current: NDArray[np.float64], previous: NDArray[np.float64]) -> float:
    """sigma_i = sqrt(sum (P_i - P_(i-1))^2 / N), Eq. (2); the arguments hold the block's N pixels [m]."""
    difference = current - previous
    return float(np.sqrt(np.mean(difference * difference)))


def l1_norm(values: NDArray[np.float64]) -> float:
    """Sum of absolute values of P_i over the block's pixels [m]."""
    return float(np.sum(np.abs(values)))


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
    frame : RGBDFrame
        As it was before.
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN where it could not be recovered.
    filled : ndarray of bool, shape (H, W)
        Pixels that had no depth and now have.
    results : dict
        Block label -> BlockResult, in rising order of labels.
    guessed : ndarray of bool, shape (H, W)
        The filled pixels that no block vouches for: none, unless `ilf.fill_rest` has been asked for them.
    notes : tuple of str
        What the user should know of how it came about, each sentence once.
    guess_network : str or None
        SHA-256 of the edge network that had a part in the guesses; None if none had.
    """

    frame: RGBDFrame
    depth: NDArray[np.float32]
    filled: NDArray[np.bool_]
    results: dict[int, BlockResult]
    guessed: NDArray[np.bool_]
    notes: tuple[str, ...] = ()
    guess_network: str | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.summary()}>"

    def summary(self) -> str:
        """Name and size of the frame, what was filled and what is still missing, in a line."""
        height, width = self.depth.shape
        masks = self.filled, self.guessed, ~np.isfinite(self.depth)
        filled, guessed, left = (int(np.count_nonzero(mask)) for mask in masks)
        return (
            f"{self.frame.name!r}: {width} x {height} pixels, {counted(len(self.results), 'block')}, "
            f"{counted(filled, 'pixel')} filled{f' ({grouped(guessed)} guessed)' if guessed else ''}, "
            f"{grouped(left)} still missing"
        )

    def _repr_html_(self) -> str:
        return html_row(self.summary(), self.frame.rgb, self._depths())

    def plot(self) -> NDArray[Any]:
        """Plot colour, depth and completed depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes
            Of the three; `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row(self.frame.rgb, self._depths())

    def _depths(self) -> dict[str, NDArray[np.float32]]:
        return {"Depth": self.frame.depth, "Completed depth": self.depth}

    @property
    def blocks(self) -> NDArray[np.int32]:
        """Label map of the blocks that were run, int32, shape (H, W), 0 = no block."""
        labels = np.zeros(self.depth.shape, np.int32)
        for label, result in self.results.items():
            labels[result.block.box][result.block.mask] = label
        return labels

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
    return Completion(frame, depth, filled, in_order, np.zeros_like(filled), notes_of(in_order))


def notes_of(results: Mapping[int, BlockResult]) -> tuple[str, ...]:
    """Each sentence once."""
    return tuple(dict.fromkeys(note for result in results.values() for note in result.notes))


# The record of one iteration in a pass band.


@dataclass(frozen=True, slots=True, eq=False)
class PassBandRecord(IterationRecord):
    """What one iteration of the ideal low-pass filter did. A stage is one pass band.

    Attributes
    ----------
    radii : tuple of float
        Cut-off radii (r_y, r_x) of this iteration, in cycles per padded grid.
    weighted : bool
        Whether the colour spectrum weighted this iteration.
    """

    radii: tuple[float, float]
    weighted: bool


# The record of one iteration of the edge-aware filter.


@dataclass(frozen=True, slots=True, eq=False)
class EdgeAwareRecord(IterationRecord):
    """What one iteration of the edge-aware filter did. A stage is one grid, or one round on the finest.

    Attributes
    ----------
    cell : int
        Side of the cells of the grid that the iteration worked on [px]; 1 on the finest.
    round : int
        Which of the rounds in which jumps let go, from 1; 0 before them.
    """

    cell: int
    round: int


# All records of a block's iterations, in little memory.

_AT_HAND = 32
"""Histories whose records stay as they are when they have been looked at: plots ask for the same again and again."""


class CompactHistory(Sequence[IterationRecord]):
    """Records in arrays, a quarter of their size or less; each is made anew when it is looked at, but for the first:
    by that very record, what belongs to the iteration can be told from what belongs to a like one.

    Parameters
    ----------
    records : sequence of IterationRecord
        All of one filter, one at least.

    Examples
    --------
    >>> records = [IterationRecord(i, 1, 0.1 / i, 20.0, 0.01, float("nan"), 0.002 * i) for i in (1, 2, 3)]
    >>> history = CompactHistory(records)
    >>> len(history), history[-1] == records[-1], list(history) == records
    (3, True, True)
    """

    def __init__(self, records: Sequence[IterationRecord]) -> None:
        self._first = records[0]
        self._columns: dict[str, NDArray[Any]] = {
            field.name: np.array([getattr(record, field.name) for record in records]) for field in fields(self._first)
        }

    @classmethod
    def of_columns(cls, kind: type[IterationRecord], columns: Mapping[str, NDArray[Any]]) -> Self:
        """Inverse of `columns`: records of a kind, one at least, each value from the array of its name.

        Examples
        --------
        >>> record = IterationRecord(1, 1, 0.1, 20.0, 0.01, float("nan"), 0.002)
        >>> history = CompactHistory([record])
        >>> CompactHistory.of_columns(history.kind, history.columns)[0] == record
        True
        """
        made = cls.__new__(cls)
        made._columns = dict(columns)
        made._first = kind(**dict(zip(columns, next(_rows(made._columns)), strict=True)))
        return made

    @property
    def kind(self) -> type[IterationRecord]:
        """What its records are."""
        return type(self._first)

    @property
    def columns(self) -> Mapping[str, NDArray[Any]]:
        """Name of a value -> that of every record, shape (N,), or (N, 2) for pairs; int64, float64 or bool."""
        return self._columns

    def __len__(self) -> int:
        return len(self._columns["i"])

    @overload
    def __getitem__(self, place: int) -> IterationRecord: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[IterationRecord, ...]: ...
    def __getitem__(self, place: int | slice) -> IterationRecord | tuple[IterationRecord, ...]:
        return self._first if place == 0 else self.records()[place]

    def __repr__(self) -> str:
        return repr(self.records())

    def records(self) -> tuple[IterationRecord, ...]:
        """All records."""
        return _records(self)


@lru_cache(maxsize=_AT_HAND)
def _records(history: CompactHistory) -> tuple[IterationRecord, ...]:
    first, columns = history._first, history._columns
    others = itertools.islice(_rows(columns), 1, None)
    return first, *(type(first)(**dict(zip(columns, row, strict=True))) for row in others)


def _rows(columns: Mapping[str, NDArray[Any]]) -> Iterator[tuple[Any, ...]]:
    values = [
        [tuple(row) for row in column.tolist()] if column.ndim > 1 else column.tolist() for column in columns.values()
    ]
    return zip(*values, strict=True)
