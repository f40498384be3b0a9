"""The stages of the extraction while its parameters change, worked out and drawn off the GUI's thread."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.extraction.found_blocks import Found, find
from gui.work.worker import Worker
from ilf.drawing.stages import stage_picture
from ilf.frame import RGBDFrame
from ilf.parameters import BlockParameters


@dataclass(frozen=True)
class Question:
    """Which picture is wanted."""

    frame: RGBDFrame
    parameters: BlockParameters
    stage: str


@dataclass(frozen=True, eq=False)
class Answer:
    """The picture, as `stage_picture` gives it, and what it shows."""

    question: Question
    found: Found
    picture: NDArray[np.uint8]


class ExtractionPreview(QObject):
    """Answers the latest question; questions that come while it is busy replace the one that waits.

    The last extraction is held, so that its other stages cost only their pictures.

    Signals
    -------
    found(object)
        An Answer; during a drag, also to questions that have been overtaken since, but never about another frame
        than that turned to.
    failed(object)
        The exception that kept a question from being answered.
    """

    found = Signal(object)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker = Worker(self)
        self._worker.finished.connect(self._answer)
        self._worker.failed.connect(self._fail)
        self._next: Question | None = None
        self._present: Question | None = None
        self._held: Found | None = None

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._worker.busy

    def ask(self, question: Question) -> None:
        """Find a picture; `found` follows."""
        self._next = None if question == self._present else question
        if not self._worker.busy:
            self._start()

    def hold(self, found: Found) -> None:
        """Take an extraction that was made elsewhere."""
        self._held = found

    def held(self, frame: RGBDFrame, parameters: BlockParameters) -> Found | None:
        """The extraction of a frame with these parameters, if that is the one held."""
        return self._held if self._held is not None and self._held.answers(frame, parameters) else None

    def held_parameters(self, frame: RGBDFrame) -> BlockParameters | None:
        """What the extraction that is held was made with, if it is of this frame."""
        return self._held.parameters if self._held is not None and self._held.frame is frame else None

    def turn_to(self, frame: RGBDFrame | None) -> None:
        """Hold no extraction of another frame, and answer no question about one any more."""
        if self._held is not None and self._held.frame is not frame:
            self._held = None
        self._next = self._present = None

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._next = None
        return self._worker.shutdown()

    def _start(self) -> None:
        self._present, self._next = self._next, None
        if self._present is None:
            return
        question = self._present
        held = self.held(question.frame, question.parameters)

        def job() -> Generator[None, None, Answer]:
            yield None
            found = held or find(question.frame, question.parameters)
            return Answer(question, found, stage_picture(question.stage, question.frame.rgb, found.extraction))

        self._worker.start(job)

    def _answer(self, answer: Answer) -> None:
        wanted = self._present is not None
        if wanted:
            self.hold(answer.found)
        self._start()
        if wanted:
            self.found.emit(answer)

    def _fail(self, error: Exception) -> None:
        wanted = self._present is not None
        self._start()
        if wanted:
            self.failed.emit(error)
