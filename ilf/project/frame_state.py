"""The state of one frame in a project."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.blocks import BlockInfo, OwnValues
from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.label_map import Box
from ..data.parameters import BlockParameters, Parameters
from ..data.presets import preset
from ..data.results import BlockResult
from ..evaluation.quality.ignored import IgnoredPlace
from ..run.run import Run
from .run_history import Extrapolation, StoredRun


@dataclass(eq=False)
class BlockNotes:
    """Data of a label map beside its pixels; replaced together with the map.

    Attributes
    ----------
    infos : dict
        Block label -> BlockInfo. Entries of removed labels are kept, so that undo restores their names.
    own : dict
        Block label -> own parameters: values that replace the common ones.
    drawn : ndarray of bool or None
        Block pixels along borders drawn by hand; None if there are none.
    extraction : BlockParameters or None
        Parameters that the blocks were extracted with.
    network : str or None
        SHA-256 of the edge network used for the extraction.
    extracted : ndarray of int32 or None
        The map directly after the extraction; None if it was changed afterwards in an unknown way.
    kept : frozenset of int
        Blocks that the extraction left unchanged, so that they do not come from it.
    handmade : frozenset of int
        Those of `kept` that were made by hand.
    propagated_from : str
        Name of the frame from which the blocks were propagated; "" if they were not. `extracted` is then the
        propagated map.
    reasons : dict
        Block label -> why the propagated block has to be checked, one sentence.
    """

    infos: dict[int, BlockInfo] = field(default_factory=dict)
    own: dict[int, OwnValues] = field(default_factory=dict)
    drawn: NDArray[np.bool_] | None = None
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()
    propagated_from: str = ""
    reasons: dict[int, str] = field(default_factory=dict)


Point = tuple[float, float]
"""Image coordinates x, y [px]."""

_STRIP = 64
"""Rows compared at a time; the comparison stops at the first difference."""


@dataclass(frozen=True, eq=False)
class InspectionState:
    """The user's inspections of a frame; stored with the frame, but not part of its results.

    Attributes
    ----------
    line : (Point, Point) or None
        Ends of the profile line.
    region : Box or None
        The selected rectangle (rows, columns).
    measurements : tuple of (Point, Point)
        Ends of measured distances.
    """

    line: tuple[Point, Point] | None = None
    region: Box | None = None
    measurements: tuple[tuple[Point, Point], ...] = ()


@dataclass(frozen=True, eq=False)
class FrameState:
    """A frame with its blocks, parameters and results. Immutable.

    Attributes
    ----------
    id : str
        Permanent id, unique in the project.
    frame : RGBDFrame
        With its inputs, invalid mask, ground truth and guide.
    labels : ndarray of int32, shape (H, W)
        The label map, 0 = no block.
    notes : BlockNotes
        Names, colours, locks, visibility, own parameters, drawn borders, extracted map and handmade blocks.
    common : Parameters
        Parameters of all blocks without parameters of their own.
    results : mapping of int to BlockResult
        Block label -> the present result of the block as it is now.
    extrapolation : Extrapolation or None
        Depth that the extrapolation has added to the results.
    runs : tuple of StoredRun
        Run history, oldest first.
    compared : tuple of int
        Numbers of the stored runs that are shown beside the present result.
    next_number : int
        Number of the next stored run.
    by_hand : DepthByHand or None
    extrapolate : bool
        Whether to extrapolate the depth that is still missing after a run.
    own_parameters : bool
        Whether `common` belongs to this frame alone while the project's parameters apply to all frames.
    note : str
        The user's note on the frame.
    done : bool
        Whether the user has marked the frame as done.
    to_check : frozenset of int
        Propagated blocks that have to be checked and have not been checked yet.
    ignored : tuple of IgnoredPlace
        Flagged places that the user ignores.
    selected : tuple of int
        The selected blocks.
    looked : InspectionState
    view : mapping
        State of the view, as JSON values; not part of the work.
    """

    id: str
    frame: RGBDFrame
    labels: NDArray[np.int32]
    notes: BlockNotes = field(default_factory=BlockNotes)
    common: Parameters = field(default_factory=preset)
    results: Mapping[int, BlockResult] = field(default_factory=dict)
    extrapolation: Extrapolation | None = None
    runs: tuple[StoredRun, ...] = ()
    compared: tuple[int, ...] = ()
    next_number: int = 1
    by_hand: DepthByHand | None = None
    extrapolate: bool = False
    own_parameters: bool = False
    note: str = ""
    done: bool = False
    to_check: frozenset[int] = frozenset()
    ignored: tuple[IgnoredPlace, ...] = ()
    selected: tuple[int, ...] = ()
    looked: InspectionState = field(default_factory=InspectionState)
    view: Mapping[str, Any] = field(default_factory=dict)

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from the extracted ones."""
        return is_edited(self.notes, self.labels)

    def with_current_settings(self, note: str, for_all: Parameters | None) -> FrameState:
        """Return the state with settings made since it was stored: the note, and the parameters for all frames (None
        if there are none)."""
        return replace(self, note=note, common=self.common if for_all is None or self.own_parameters else for_all)

    def run(self) -> Run:
        """Return the run of all blocks as they are now."""
        notes = self.notes
        there = set(np.flatnonzero(np.bincount(self.labels.ravel()))) - {0}
        return Run(
            self.frame,
            self.labels,
            self.common,
            {label: self.common.replace(**own) for label, own in notes.own.items() if label in there},
            extrapolate=self.extrapolate,
            extraction=notes.extraction,
            edited=self.edited,
            network=notes.network,
            drawn=notes.drawn,
            by_hand=self.by_hand,
        )


def is_edited(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    """Return whether a label map differs from the extracted one."""
    return bool(notes.kept) or not _as_extracted(notes, labels)


def is_propagated(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    """Return whether a label map was propagated from another frame and has not been edited since."""
    return bool(notes.propagated_from) and _as_extracted(notes, labels)


def _as_extracted(notes: BlockNotes, labels: NDArray[np.int32]) -> bool:
    extracted = notes.extracted
    if extracted is None:
        return False
    strips = (slice(top, top + _STRIP) for top in range(0, labels.shape[0], _STRIP))
    return all(np.array_equal(extracted[strip], labels[strip]) for strip in strips)
