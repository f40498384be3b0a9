"""Suggests known depth to distrust: shown first, then taken or left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.errors import IlfError
from ilf.evaluation.quality.invalid_depth import suggest_distrust
from ilf.segmentation.edges.frame_edges import find_edges

from ...state.workspace import Workspace
from ...views.linked_views import LinkedViews
from ...views.pixel_items import boundary_path
from ...work.latest_question import LatestQuestion
from .marks import Marks, ReviewStrip

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Question:
    frame: RGBDFrame
    extraction: BlockParameters


class DistrustPresenter(QObject):
    """Candidates for wrong depth in the present frame, marked in all views until they are taken or left.

    Signals
    -------
    message(str)
        What there is to say beside.
    failed(object)
        The exception that kept candidates from being found, or from being taken.
    """

    message = Signal(str)
    failed = Signal(object)

    def __init__(self, workspace: Workspace, views: LinkedViews, strip: ReviewStrip) -> None:
        super().__init__(strip)
        self._workspace = workspace
        self._strip = strip
        self._views = views
        self._marks = Marks(views)
        self._found: Mask | None = None
        self._questions = LatestQuestion[_Question, Mask](_find, self)
        self._questions.answered.connect(self._take_answer)
        self._questions.failed.connect(self._fail)
        workspace.session_changed.connect(self.leave)
        workspace.distrusted_changed.connect(self.leave)

    @property
    def busy(self) -> bool:
        """Whether candidates are being looked for."""
        return self._questions.busy

    @property
    def candidates(self) -> Mask | None:
        """Pixels that are suggested, bool (H, W); None while there is nothing to decide."""
        return self._found

    def suggest(self) -> None:
        """Look for candidates in the present frame."""
        if self._workspace.has_session:
            session = self._workspace.session
            self._questions.ask(_Question(session.frame, session.notes.extraction or BlockParameters()))

    def take(self) -> None:
        """Distrust the candidates."""
        if self._found is None:
            return
        found, before = self._found, self._workspace.session.frame.distrusted
        try:
            self._workspace.set_distrusted(found if before is None else before | found, "Distrust what is suggested")
        except IlfError as error:
            self.leave()
            self.failed.emit(error)

    def leave(self) -> None:
        """Forget the candidates."""
        self._questions.forget()
        self._found = None
        self._marks.clear()
        self._strip.hide()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _take_answer(self, question: _Question, found: Mask) -> None:
        if not self._workspace.has_session or question.frame is not self._workspace.session.frame:
            return
        pixels = int(np.count_nonzero(found))
        if not pixels:
            self.leave()
            self.message.emit("No known depth looks wrong: there are no flying pixels, speckles or things of glass.")
            return
        self._found = found
        self._views.fit()
        self._marks.show(boundary_path(found))
        self._strip.say(f"{pixels:,} px of known depth look wrong: flying pixels, speckles or glass.")

    def _fail(self, question: _Question, error: Exception) -> None:
        self.leave()
        self.failed.emit(error)


def _find(question: _Question) -> Mask:
    """Off the GUI's thread."""
    return suggest_distrust(question.frame, find_edges(question.frame, question.extraction).strength)
