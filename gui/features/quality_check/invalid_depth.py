"""Suggests known depth to mark as invalid: shown first, then accepted or rejected."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.errors import IlfError
from ilf.evaluation.quality.invalid_depth import suggest_invalid
from ilf.segmentation.edges.frame_edges import find_edges

from ...base.commands import Command
from ...base.needs import Need
from ...views.pixel_items import boundary_path
from ...work.latest_request import LatestRequest
from ..context import Context, Feature
from .marks import PlaceMarks, ReviewStrip

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Request:
    frame: RGBDFrame
    extraction: BlockParameters


class InvalidDepthFeature(Feature):
    """Candidates for invalid depth in the current frame, marked in all views until they are accepted or rejected."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = workspace = context.workspace
        self._views = views = context.views
        actions = context.actions
        actions.add(
            (
                Command(
                    "suggest_invalid",
                    "Su&ggest invalid depth",
                    "Find known depth that is probably wrong (flying pixels, speckles, glass), to accept or reject",
                    icon="ph.warning",
                    handler=self.suggest,
                    needs=Need.FRAME,
                ),
                Command(
                    "mark_suggested",
                    "Mark &invalid",
                    "Mark the suggested depth as invalid: it is missing",
                    icon="ph.check",
                    handler=self.take,
                ),
                Command(
                    "ignore_suggested",
                    "Reject",
                    "Keep the suggested depth as valid",
                    icon="ph.x",
                    handler=self.leave,
                ),
            )
        )
        self.strip = ReviewStrip([actions["mark_suggested"], actions["ignore_suggested"]])
        context.centre.add_strip(self.strip)
        self._marks = PlaceMarks(views)
        self._found: Mask | None = None
        self._questions = LatestRequest[_Request, Mask](_find, self)
        self._questions.answered.connect(self._take_answer)
        self._questions.failed.connect(self._fail)
        workspace.frames.session_changed.connect(self.leave)
        for changed in (workspace.blocks.invalid_mask_changed, workspace.blocks.neighbours_changed):
            changed.connect(self.leave)

    @property
    def busy(self) -> bool:
        """Whether the search for candidates is in progress."""
        return self._questions.busy

    @property
    def candidates(self) -> Mask | None:
        """Suggested pixels, bool (H, W); None while there are none."""
        return self._found

    def suggest(self) -> None:
        """Search for candidates in the current frame."""
        if self._workspace.has_current:
            document = self._workspace.current
            self._questions.ask(_Request(document.frame, document.blocks.extraction or BlockParameters()))

    def take(self) -> None:
        """Mark the candidates as invalid."""
        if self._found is None:
            return
        found, before = self._found, self._workspace.current.frame.invalid_mask
        try:
            self._workspace.current.set_invalid_mask(
                found if before is None else before | found, "Mark suggested depth as invalid"
            )
        except IlfError as error:
            self.leave()
            self.context.notes.report("Suggesting invalid depth", error)

    def leave(self) -> None:
        """Reject the candidates."""
        self._questions.forget()
        self._found = None
        self._marks.clear()
        self.strip.hide()

    def _take_answer(self, question: _Request, found: Mask) -> None:
        if not self._workspace.has_current or question.frame is not self._workspace.current.frame:
            return
        pixels = int(np.count_nonzero(found))
        if not pixels:
            self.leave()
            self.context.notes.show_message("No invalid depth found: no flying pixels, speckles or glass.")
            return
        self._found = found
        self._views.fit()
        self._marks.show(boundary_path(found))
        self.strip.show_message(
            f"{counted(pixels, 'pixel')} of known depth may be invalid: flying pixels, speckles or glass."
        )

    def _fail(self, question: _Request, error: Exception) -> None:
        self.leave()
        self.context.notes.report("Suggesting invalid depth", error)


def _find(question: _Request) -> Mask:
    """Compute the candidates; called in a worker thread."""
    return suggest_invalid(question.frame, find_edges(question.frame, question.extraction).strength)
