"""The state of one frame in a project."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np

from ..data.blocks import Blocks, Box
from ..data.frame import RGBDFrame
from ..data.parameters import Parameters
from ..data.presets import preset
from ..data.results import BlockResult, Completion, Status, compose
from ..evaluation.quality.places import IgnoredPlace
from ..run.run import Run
from .project import FrameSummary, Stage
from .run_history import Extrapolation, StoredRun

_LONGER_SIDE, _QUALITY = 240, 80
"""Longer side [px] and JPEG quality of thumbnails."""

Point = tuple[float, float]
"""Image coordinates x, y [px]."""


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
    blocks : Blocks
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
    blocks: Blocks
    common: Parameters = field(default_factory=preset)
    results: Mapping[int, BlockResult] = field(default_factory=dict)
    extrapolation: Extrapolation | None = None
    runs: tuple[StoredRun, ...] = ()
    compared: tuple[int, ...] = ()
    next_number: int = 1
    extrapolate: bool = False
    own_parameters: bool = False
    note: str = ""
    done: bool = False
    to_check: frozenset[int] = frozenset()
    ignored: tuple[IgnoredPlace, ...] = ()
    selected: tuple[int, ...] = ()
    looked: InspectionState = field(default_factory=InspectionState)
    view: Mapping[str, Any] = field(default_factory=dict)

    def with_current_settings(self, note: str, for_all: Parameters | None) -> FrameState:
        """Return the state with settings made since it was stored: the note, and the parameters for all frames (None
        if there are none)."""
        return replace(self, note=note, common=self.common if for_all is None or self.own_parameters else for_all)

    def summary(self, labels: Collection[int]) -> FrameSummary:
        """Return the summary of the frame; `labels` are those in its label map."""
        outcomes = [result.outcome for result in self.results.values()]
        unrecoverable = [outcome for outcome in outcomes if outcome.status is Status.NOT_RECOVERABLE]
        failed = bool(outcomes) and len(unrecoverable) == len(outcomes)
        return FrameSummary(
            Stage.FAILED if failed else Stage.RUN if outcomes else self._stage_before_a_run(labels),
            self.note,
            self.frame.shape,
            self.frame.missing_share,
            len(labels),
            len(outcomes),
            len(self.to_check.intersection(labels)),
            unrecoverable[0].message if failed else "",
            self.own_parameters,
            self.done,
            sum(outcome.status is Status.ITERATION_LIMIT for outcome in outcomes),
        )

    def _stage_before_a_run(self, labels: Collection[int]) -> Stage:
        if not labels:
            return Stage.UNTOUCHED
        if self.blocks.propagated:
            return Stage.PROPAGATED
        return Stage.EDITED if self.blocks.edited or self.blocks.by_hand is not None else Stage.EXTRACTED

    def thumbnail(self) -> bytes:
        """Return the colour image as JPEG with a longer side of at most 240 pixels: without the blocks, so that the
        frame looks the same as one that was never opened.

        Examples
        --------
        >>> import numpy as np
        >>> frame = RGBDFrame(np.zeros((30, 40, 3), np.uint8), np.full((30, 40), 2.0))
        >>> FrameState("a1", frame, Blocks(np.ones((30, 40), np.int32))).thumbnail()[:2]
        b'\\xff\\xd8'
        """
        height, width = self.frame.shape
        scale = min(_LONGER_SIDE / max(height, width), 1.0)
        size = max(round(width * scale), 1), max(round(height * scale), 1)
        small = cv2.resize(self.frame.rgb, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
        return cv2.imencode(".jpg", small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1].tobytes()

    def run(self) -> Run:
        """Return the run of all blocks as they are now."""
        return Run(self.frame, self.blocks.without_absent(), self.common, extrapolate=self.extrapolate)

    def present_run(self) -> Run:
        """Return the run of the present results: the blocks with a result, each with the parameters of its result."""
        own = {label: result.parameters for label, result in self.results.items()}
        blocks = self.blocks.with_parameters(own, self.common)
        return Run(self.frame, blocks, self.common, frozenset(own), self.extrapolation is not None)

    def present_completion(self) -> Completion:
        """Compose the present results, including extrapolated depth."""
        completion = compose(self.present_run(), {label: self.results[label] for label in sorted(self.results)})
        return completion if self.extrapolation is None else self.extrapolation.added_to(completion)
