"""What a project holds of one frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.blocks import Box
from ..data.declarations import Value
from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters, Parameters, preset
from ..data.results import BlockResult
from ..run.run import Run
from .run_history import Guess, KeptRun

# Values of the filter's parameters that blocks have of their own, in place of the common ones.

OwnValues = Mapping[str, Value]
"""Parameter -> value."""


def own_values(parameters: Parameters, common: Parameters) -> OwnValues:
    """The values that a block with such parameters has in place of the common ones."""
    ours, values = parameters.to_dict(), common.to_dict()
    return {name: value for name, value in ours.items() if value != values[name]}


def differing(one: OwnValues, other: OwnValues) -> set[str]:
    """Names whose values differ, or that only one has."""
    return {name for name in {*one, *other} if name not in one or name not in other or one[name] != other[name]}


def parameter_labels(names: Iterable[str]) -> list[str]:
    """What parameters are called in the window."""
    declarations = Parameters.declarations()
    return [declarations[name].label for name in declarations if name in set(names)]


# What is known of a frame's blocks beside their pixels.


@dataclass(frozen=True)
class BlockInfo:
    """What a user can say about a block, beside its pixels."""

    name: str
    colour: tuple[int, int, int]
    visible: bool = True
    locked: bool = False


@dataclass(eq=False)
class BlockNotes:
    """What is known of a label map beside its pixels; replaced as a whole when the map is.

    Attributes
    ----------
    infos : dict
        Block label -> BlockInfo. Kept for labels that are gone, so that undo brings names back.
    own : dict
        Block label -> values of its own, parameter by parameter, in place of those of all blocks.
    drawn : ndarray of bool or None
        Pixels of blocks whose border was drawn by hand; None if there are none.
    extraction : BlockParameters or None
        What the blocks were extracted with.
    network : str or None
        SHA-256 of the edge network that had a part in it.
    extracted : ndarray of int32 or None
        The map as that extraction left it; None if it was changed afterwards in ways that are not known.
    kept : frozenset of int
        Blocks that stayed as they were at that extraction, and do not come from it.
    handmade : frozenset of int
        Those of them that had been made by hand.
    carried_from : str
        Name of the frame from which the blocks were carried here; "" if they were not. `extracted` is the map as they
        came then.
    reasons : dict
        Block label -> why it needed a look when it came, a sentence.
    """

    infos: dict[int, BlockInfo] = field(default_factory=dict)
    own: dict[int, OwnValues] = field(default_factory=dict)
    drawn: NDArray[np.bool_] | None = None
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()
    carried_from: str = ""
    reasons: dict[int, str] = field(default_factory=dict)


Point = tuple[float, float]
"""Image coordinates x, y [px]."""

_STRIP = 64
"""Rows that are compared at a time: the first difference is enough."""


@dataclass(frozen=True, eq=False)
class Looked:
    """Where the user has looked closely: it stays with the frame, and is no result.

    Attributes
    ----------
    line : (Point, Point) or None
        Ends of the profile line.
    region : Box or None
        The chosen rectangle (rows, columns).
    chains : tuple of tuple of Point
        Points that are measured between.
    reference : int
        Block over whose plane heights are measured; 0 for the image's upright.
    """

    line: tuple[Point, Point] | None = None
    region: Box | None = None
    chains: tuple[tuple[Point, ...], ...] = ()
    reference: int = 0


@dataclass(frozen=True, eq=False)
class FrameState:
    """A frame, its blocks, what is known of them, its parameters and what runs have given. Nobody changes it.

    Attributes
    ----------
    id : str
        Tells it from the other frames of its project, and stays with it.
    frame : RGBDFrame
        With its inputs, distrusted depth, truth and guide.
    labels : ndarray of int32, shape (H, W)
        The label map, 0 = no block.
    notes : BlockNotes
        Names, colours, locks, visibility, own values, drawn borders, what was extracted and what was made by hand.
    common : Parameters
        Of all blocks that have no values of their own.
    results : mapping of int to BlockResult
        Block label -> the present result, of blocks as they are now.
    guess : Guess or None
        What the guess of the rest has added to them.
    runs : tuple of KeptRun
        In the order in which they were kept.
    compared : tuple of int
        Numbers of the kept runs that are shown beside the present result.
    next_number : int
        Of the next run that is kept.
    dense : bool
        Whether what is still missing after a run is to be guessed.
    own_parameters : bool
        Whether `common` is this frame's own where the project has parameters for all frames.
    note : str
        What the user says of the frame.
    to_check : frozenset of int
        Blocks that came from another frame and have not been looked at yet, though they should be.
    selected : tuple of int
        The chosen blocks.
    looked : Looked
    view : mapping
        How it was looked at, in values that JSON has: no part of the work.
    """

    id: str
    frame: RGBDFrame
    labels: NDArray[np.int32]
    notes: BlockNotes = field(default_factory=BlockNotes)
    common: Parameters = field(default_factory=preset)
    results: Mapping[int, BlockResult] = field(default_factory=dict)
    guess: Guess | None = None
    runs: tuple[KeptRun, ...] = ()
    compared: tuple[int, ...] = ()
    next_number: int = 1
    dense: bool = False
    own_parameters: bool = False
    note: str = ""
    to_check: frozenset[int] = frozenset()
    selected: tuple[int, ...] = ()
    looked: Looked = field(default_factory=Looked)
    view: Mapping[str, Any] = field(default_factory=dict)

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from what the extraction gave."""
        return is_edited(self.notes, self.labels)

    def as_set(self, note: str, for_all: Parameters | None) -> FrameState:
        """The state with what may have been set since it was stored: the note, and the parameters of all frames, None
        where there are none."""
        return replace(self, note=note, common=self.common if for_all is None or self.own_parameters else for_all)

    def run(self) -> Run:
        """What a run of all blocks as they are now is made of."""
        notes = self.notes
        there = set(np.flatnonzero(np.bincount(self.labels.ravel()))) - {0}
        return Run(
            self.frame,
            self.labels,
            self.common,
            {label: self.common.replace(**own) for label, own in notes.own.items() if label in there},
            dense=self.dense,
            extraction=notes.extraction,
            edited=self.edited,
            network=notes.network,
            drawn=notes.drawn,
        )


def is_edited(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    """Whether a label map differs from what its extraction gave."""
    return bool(notes.kept) or not _as_extracted(notes, labels)


def is_carried(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    """Whether a label map is as it was carried from another frame: nobody has edited it since."""
    return bool(notes.carried_from) and _as_extracted(notes, labels)


def _as_extracted(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    extracted = notes.extracted
    if extracted is None:
        return False
    strips = (slice(top, top + _STRIP) for top in range(0, labels.shape[0], _STRIP))
    return all(np.array_equal(extracted[strip], labels[strip]) for strip in strips)
