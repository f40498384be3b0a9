"""What runs have given for one frame, and how the run under way stands: the one place that holds it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ilf.completion.filter import edge_parameters
from ilf.data.blocks import Block, Box, drawn_of, union
from ilf.data.frame import RGBDFrame
from ilf.data.guide import Guide
from ilf.data.parameters import BlockParameters, Parameters
from ilf.data.results import BlockResult, Completion, IterationRecord

Preview = tuple[Block, NDArray[np.float32]]
"""A block that runs, and the depth [m] at its pixels as it stands."""


class Kept(NamedTuple):
    """A result, and the distrusted depth and the guide of the frame that it is of."""

    result: BlockResult
    distrusted: NDArray[np.bool_] | None
    guide: Guide | None = None

    @classmethod
    def of(cls, result: BlockResult, frame: RGBDFrame) -> Self:
        """A result of a frame."""
        return cls(result, frame.distrusted, frame.guide)

    def is_of_state(self, other: Kept) -> bool:
        """Whether both are of the same pixels of a block, with the same borders and edges, of the same known depth."""
        one, another = self.result, other.result
        return (
            one.edges == another.edges
            and one.block.box == another.block.box
            and np.array_equal(one.block.mask, another.block.mask)
            and same_mask(one.drawn, another.drawn)
            and same_mask(self.distrusted, other.distrusted)
            and same_guide(self.guide, other.guide)
        )

    def fits(
        self,
        labels: NDArray[np.int32],
        pixels: int,
        frame: RGBDFrame,
        drawn: NDArray[np.bool_] | None,
        extraction: BlockParameters | None,
    ) -> bool:
        """Whether it is of a block as it is in a label map, where it has so many pixels, with such drawn borders and
        extraction, in a frame with such distrusted depth and such a guide."""
        result = self.result
        block = result.block
        return (
            pixels == result.depth.size
            and result.edges == edge_parameters(result.parameters, extraction)
            and np.array_equal(labels[block.box] == block.label, block.mask)
            and same_mask(self.distrusted, frame.distrusted)
            and same_guide(self.guide, frame.guide)
            and same_mask(result.drawn, drawn_of(block, drawn))
        )


class Doubt(NamedTuple):
    """How far a completion may be off: its expected error [m], float32 (H, W), and which of it nothing vouches for."""

    error: NDArray[np.float32]
    unvouched: NDArray[np.bool_]


class Held(NamedTuple):
    """All results of a frame: of blocks, the expected error of a completion, the guess of one."""

    kept: dict[int, list[Kept]]
    doubt: tuple[Completion, Doubt] | None = None
    guess: tuple[Completion, Completion] | None = None

    def with_newer(self, newer: Held) -> Held:
        """These results and newer ones, as those of a run after these had been cleared."""
        labels = self.kept.keys() | newer.kept.keys()
        kept = {label: [*self.kept.get(label, ()), *newer.kept.get(label, ())] for label in labels}
        return Held(kept, newer.doubt or self.doubt, newer.guess or self.guess)

    def without(self, others: Held) -> Held:
        """Those of these results that are none of the others."""
        theirs = {id(one) for kept in others.kept.values() for one in kept}
        left = {label: [one for one in kept if id(one) not in theirs] for label, kept in self.kept.items()}
        return Held({label: kept for label, kept in left.items() if kept})


class Results:
    """Results, live records and previews of a frame's blocks. The workspace alone changes them.

    Attributes
    ----------
    kept : dict
        Block label -> results of all states that it has had, the latest last: undo may bring back what they are of.
    live : dict
        Label -> records so far of the blocks that run, the one that began last at the end.
    previews : dict
        Label -> Preview of blocks that run.
    settled : set of Parameters
        Parameters of blocks that a step of the history has begun or ended with.
    """

    def __init__(self) -> None:
        self.kept: dict[int, list[Kept]] = {}
        self.live: dict[int, list[IterationRecord]] = {}
        self.previews: dict[int, Preview] = {}
        self.settled: set[Parameters] = set()
        self._doubt: tuple[Completion, Doubt] | None = None
        self._guess: tuple[Completion, Completion] | None = None

    @property
    def running(self) -> list[int]:
        """Blocks that have records but no result of the run under way, the one that began last at the end."""
        return list(self.live)

    def doubt_of(self, completion: Completion | None) -> Doubt | None:
        """How far that very completion may be off, if it has been worked out."""
        return self._doubt[1] if self._doubt is not None and self._doubt[0] is completion else None

    def note_doubt(self, completion: Completion, doubt: Doubt) -> None:
        """Keep how far a completion may be off in place of any other's."""
        self._doubt = completion, doubt

    def guess_of(self, completion: Completion | None) -> Completion | None:
        """That very completion with the rest guessed, if it has been."""
        return self._guess[1] if self._guess is not None and self._guess[0] is completion else None

    @property
    def guess_base(self) -> Completion | None:
        """The completion whose rest has been guessed last."""
        return None if self._guess is None else self._guess[0]

    def forget_guess(self) -> None:
        """There is no guess that holds."""
        self._guess = None

    def note_guess(self, completion: Completion, guess: Completion) -> None:
        """Keep the guess of what a completion leaves missing."""
        self._guess = completion, guess

    def add_records(self, label: int, records: Iterable[IterationRecord]) -> None:
        """A block that runs has gone on."""
        self.live.setdefault(label, []).extend(records)

    def add_previews(self, previews: Iterable[Preview]) -> None:
        """Where blocks stand now; those that have ended meanwhile are left out."""
        self.previews |= {block.label: (block, depth) for block, depth in previews if block.label in self.live}

    def add(self, results: Iterable[BlockResult], frame: RGBDFrame) -> None:
        """Blocks of a frame as it was when they were begun have ended."""
        for result in results:
            label = result.block.label
            self._keep(label, Kept.of(result, frame))
            self.live.pop(label, None)
            self.previews.pop(label, None)

    def _keep(self, label: int, kept: Kept) -> None:
        """Keep a result beside those that undo and redo may bring back; not beside what a drag has passed over."""
        stays = self.settled - {kept.result.parameters}
        others = self.kept.get(label, [])
        self.kept[label] = [one for one in others if one.result.parameters in stays or not one.is_of_state(kept)]
        self.kept[label].append(kept)

    def end_run(self, previews_stay: bool = False) -> None:
        """Nothing runs any more; with `previews_stay`, another run of the same is about to begin."""
        self.live.clear()
        if not previews_stay:
            self.previews.clear()

    def held(self) -> Held:
        """What there is, whatever comes after it."""
        return Held({label: list(kept) for label, kept in self.kept.items()}, self._doubt, self._guess)

    def swap(self, other: Held) -> Held:
        """Take other results, none or those of before; the former ones are returned."""
        former = Held(self.kept, self._doubt, self._guess)
        self.kept, self._doubt, self._guess = other
        return former


def same_guide(one: Guide | None, other: Guide | None) -> bool:
    """Whether two guides say the same; None is no guide."""
    return one is other or (one is not None and one.says_the_same(other))


def same_mask(one: NDArray[np.bool_] | None, other: NDArray[np.bool_] | None) -> bool:
    """Whether two masks are the same; None is one without any pixel."""
    if one is None or other is None:
        return one is other or not np.any(other if one is None else one)
    return one is other or np.array_equal(one, other)


# The depth that the views show, kept up to date where something has changed.

Depth = NDArray[np.float32]


class ShownDepth:
    """What is completed, the last depth of blocks that have changed since, and previews of the blocks that run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where there is none. Changed in place.
    stale : ndarray of bool, shape (H, W)
        Pixels whose depth is what a block had before it was changed. Changed in place.
    """

    def __init__(self, frame: RGBDFrame) -> None:
        self._raw = frame.depth
        self.depth: Depth = frame.depth.copy()
        self.stale: NDArray[np.bool_] = np.zeros(frame.shape, bool)
        self._last: Depth = np.full(frame.shape, np.nan, np.float32)
        self._changed: Box | None = None

    def take_frame(self, frame: RGBDFrame) -> None:
        """Go by another frame of the same shape, as when other depth is distrusted."""
        self._raw = frame.depth
        self.note_all()

    def keep(self, results: Iterable[BlockResult]) -> None:
        """What blocks have come to: shown until there is something newer, whatever becomes of the blocks."""
        for result in results:
            self._last[result.block.box][result.block.mask] = result.depth
            self.note(result.block.box)

    def forget(self) -> None:
        """There are no results any more."""
        self._last.fill(np.nan)
        self.note_all()

    def note(self, box: Box) -> None:
        """Something has changed inside a box (rows, columns)."""
        self._changed = box if self._changed is None else union(self._changed, box)

    def note_all(self) -> None:
        """Something has changed all over the frame."""
        self._changed = _whole(self._raw.shape)

    def update(
        self,
        labels: NDArray[np.int32],
        valid: Collection[int],
        completion: Completion | None,
        previews: Iterable[Preview],
    ) -> Box | None:
        """Bring `depth` and `stale` up to date.

        Parameters
        ----------
        labels : ndarray of int32, shape (H, W)
            The label map as it is.
        valid : collection of int
            Blocks whose results are of it.
        completion : Completion or None
            What they make, guesses included.
        previews : iterable of (Block, ndarray)

        Returns
        -------
        (slice, slice) or None
            Where they have changed; None if they have not.
        """
        box, self._changed = self._changed, None
        if box is None:
            return None
        part = (self._raw if completion is None else completion.depth)[box].copy()
        here = labels[box]
        fresh = np.zeros(max(int(here.max()), 0) + 1, bool)
        fresh[[0, *(label for label in valid if label < fresh.size)]] = True
        stale = ~fresh[here]
        if stale.any():
            last = self._last[box]
            stale &= np.isfinite(last)
            part = np.where(stale, last, part)
        self.depth[box], self.stale[box] = part, stale
        for block, preview in previews:
            still = labels[block.box][block.mask] == block.label  # it may have lost pixels since it began
            mask = block.mask.copy()
            mask[block.mask] = still
            self.depth[block.box][mask] = preview[still]
            self.stale[block.box][mask] = False
        return box


def _whole(shape: tuple[int, ...]) -> Box:
    return slice(0, shape[0]), slice(0, shape[1])


# What the views show while somebody looks back.


@dataclass(frozen=True, eq=False)
class Past:
    """The depth of the present frame as it was in the course of its last run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where there was none.
    iteration : int
        After which iteration of every block.
    """

    depth: NDArray[np.float32]
    iteration: int

    @property
    def text(self) -> str:
        """What to call it."""
        return f"as after iteration {self.iteration}"


# How many pixels blocks have, and of how many of them depth is missing; kept up to date box by box.


@dataclass(frozen=True)
class BlockCounts:
    """Pixels of a block, and those of them that lack no depth: it is known, or they are out of the camera's view."""

    pixels: int
    known: int

    @property
    def defect_rate(self) -> float:
        """Share of pixels without raw depth in the depth camera's view, 0-1."""
        return 1.0 - self.known / self.pixels if self.pixels else 0.0


class BlockTally:
    """Counts of all blocks of a label map, int32 (H, W), over a mask of pixels that lack no depth, bool (H, W)."""

    def __init__(self, labels: NDArray[np.int32], known: NDArray[np.bool_]) -> None:
        self._labels = labels
        self._known = known
        self._counts = np.zeros((2, 1), np.int64)
        self.add((slice(0, labels.shape[0]), slice(0, labels.shape[1])))

    def add(self, box: Box) -> None:
        """Count the pixels of a box as they are now."""
        self._count(box, 1)

    def take_out(self, box: Box) -> None:
        """Count the pixels of a box no more."""
        self._count(box, -1)

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels; 0 is no block."""
        pixels, known = self._counts
        present = np.flatnonzero(pixels)
        return {int(label): BlockCounts(int(pixels[label]), int(known[label])) for label in present if label > 0}

    def _count(self, box: Box, sign: int) -> None:
        here = self._labels[box]
        beyond = int(here.max()) + 1 - self._counts.shape[1]
        if beyond > 0:
            self._counts = np.pad(self._counts, ((0, 0), (0, beyond)))
        size = self._counts.shape[1]
        self._counts[0] += sign * np.bincount(here.ravel(), minlength=size)
        self._counts[1] += sign * np.bincount(here[self._known[box]], minlength=size)


# How far off the blocks of a frame are known to be.

TRUTH, HIDDEN_DEPTH = "the truth", "hidden depth"


@dataclass(frozen=True)
class BlockErrors:
    """Errors of the present results against the truth, or of the present values on hidden depth.

    Attributes
    ----------
    source : str
        `TRUTH` or `HIDDEN_DEPTH`; "" where nothing is known.
    rmse : mapping of int to float
        Block label -> root mean square error [m]; blocks of which none is known are left out.
    """

    source: str = ""
    rmse: Mapping[int, float] = field(default_factory=dict)
