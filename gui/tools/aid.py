"""What the tools know of a frame beside its blocks: edges to snap to, and the regions of the extraction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.editing.snapping import Similar, Snapper

from ..state.session import Session
from ..work.found_blocks import Found, find
from ..work.latest_question import LatestQuestion


@dataclass(frozen=True, eq=False)
class Aid:
    """What is known of a frame.

    Attributes
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    regions : ndarray of int32, shape (H, W)
        The regions that the extraction merges to blocks.
    snapper : Snapper
        Moves drawn lines onto edges.
    """

    frame: RGBDFrame
    strength: NDArray[np.float32]
    regions: NDArray[np.int32]
    snapper: Snapper


@dataclass(frozen=True, eq=False)
class _Question:
    session: Session
    frame: RGBDFrame
    parameters: BlockParameters
    found: Found | None


class AidSource(QObject):
    """Works out the aid of one session's frame at a time, off the GUI's thread.

    Depth that is distrusted later does not make another aid: where the line was drawn to, it was drawn.

    Signals
    -------
    found()
        The aid that was asked for last is there.
    failed(object)
        The exception that kept it from being found.
    """

    found = Signal()
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._session: Session | None = None
        self._aid: Aid | None = None
        self._extraction: Found | None = None
        self._questions = LatestQuestion[_Question, Aid](_find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: self.failed.emit(error))

    def of(self, session: Session, parameters: BlockParameters) -> Aid | None:
        """The aid of a session's frame; None as long as it is being worked out.

        With `parameters` the frame is extracted for it, if no extraction of it is held.
        """
        if session is not self._session:
            self._session, self._aid = session, None
            held = self._extraction if self._extraction and self._extraction.frame is session.frame else None
            self._questions.ask(_Question(session, session.frame, parameters, held))
        return self._aid

    def hold(self, extraction: Found) -> None:
        """An extraction has been made; the aid of its frame need not make another."""
        self._extraction = extraction
        if self._aid is not None and self._aid.frame is extraction.frame:
            self._session = self._aid = None

    def turn_to(self, session: Session | None) -> None:
        """Let go what is known of other frames than that of this session."""
        if self._extraction is not None and (session is None or self._extraction.frame is not session.frame):
            self._extraction = None
        if session is not self._session:
            self._session = self._aid = None
            self._questions.forget()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, question: _Question, aid: Aid) -> None:
        if question.session is self._session:
            self._aid = aid
            self.found.emit()


def _find(question: _Question) -> Aid:
    """Off the GUI's thread."""
    extraction = (question.found or find(question.frame, question.parameters)).extraction
    return aid_of(question.frame, extraction.strength, extraction.contracted)


def aid_of(frame: RGBDFrame, strength: NDArray[np.float32], regions: NDArray[np.int32]) -> Aid:
    """The aid of a frame whose edges and regions are known."""
    Similar(frame, strength, 0, 0)  # what it works out for all of the frame is remembered with it
    return Aid(frame, strength, regions, Snapper(frame, strength))
