"""The stages of the extraction while its parameters change, worked out and drawn off the GUI's thread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.extraction.found_blocks import Found, find
from gui.work.latest_question import LatestQuestion
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
    """Answers the latest question about stages.

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
        self._held: Found | None = None
        self._questions = LatestQuestion[Question, Answer](self._find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: self.failed.emit(error))

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._questions.busy

    def ask(self, question: Question) -> None:
        """Find a picture; `found` follows."""
        self._questions.ask(question)

    def hold(self, found: Found) -> None:
        """Take an extraction that was made elsewhere."""
        self._held = found

    def held(self, frame: RGBDFrame, parameters: BlockParameters) -> Found | None:
        """The extraction of a frame with these parameters, if that is the one held."""
        held = self._held  # it may be let go while another thread looks at it
        return held if held is not None and held.answers(frame, parameters) else None

    def held_parameters(self, frame: RGBDFrame) -> BlockParameters | None:
        """What the extraction that is held was made with, if it is of this frame."""
        return self._held.parameters if self._held is not None and self._held.frame is frame else None

    def turn_to(self, frame: RGBDFrame | None) -> None:
        """Hold no extraction of another frame, and answer no question about one any more."""
        if self._held is not None and self._held.frame is not frame:
            self._held = None
        self._questions.forget()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _find(self, question: Question) -> Answer:
        """Off the GUI's thread."""
        found = self.held(question.frame, question.parameters) or find(question.frame, question.parameters)
        return Answer(question, found, stage_picture(question.stage, question.frame.rgb, found.extraction))

    def _take(self, _: Question, answer: Answer) -> None:
        self.hold(answer.found)
        self.found.emit(answer)
