"""What a project holds of one frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..blocks import Box
from ..frame import RGBDFrame
from ..outcomes import BlockResult
from ..parameters import Parameters, preset
from ..run import Run
from .block_notes import BlockNotes
from .kept_run import Guess, KeptRun

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
