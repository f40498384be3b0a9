"""What runs have given for one frame, and how the run under way stands: the one place that holds it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Block, drawn_of
from ilf.filter.convergence import IterationRecord
from ilf.filter.stepper import edge_parameters
from ilf.frame import RGBDFrame
from ilf.guide import Guide
from ilf.outcomes import BlockResult, Completion
from ilf.parameters import BlockParameters, Parameters

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
