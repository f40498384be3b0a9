"""The stages of the extraction while its parameters change, worked out and drawn off the GUI's thread."""

from __future__ import annotations

import time
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.views.stages import stage_picture
from gui.worker import Worker
from ilf.ebs import Extraction, extract
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
    """The picture, as `stage_picture` gives it, and the extraction that it shows, with the seconds that took."""

    question: Question
    extraction: Extraction
    seconds: float
    picture: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class _Held:
    frame: RGBDFrame
    parameters: BlockParameters
    extraction: Extraction
    seconds: float


class ExtractionPreview(QObject):
    """Answers the latest question; questions that come while it is busy replace the one that waits.

    The last extraction is held, so that its other stages cost only their pictures.

    Signals
    -------
    found(object)
        An Answer; during a drag, also to questions that have been overtaken since, but never about another frame
        than that turned to.
    failed(object)
        The exception that kept a question from being answered. It is not tried again before another has been.
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
        self._hopeless: Question | None = None
        self._held: _Held | None = None

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._worker.busy

    def ask(self, question: Question) -> None:
        """Find a picture; `found` follows."""
        if question == self._hopeless:
            return
        self._next = None if question == self._present else question
        if not self._worker.busy:
            self._start()

    def hold(self, frame: RGBDFrame, parameters: BlockParameters, extraction: Extraction, seconds: float) -> None:
        """Take an extraction that was made elsewhere."""
        self._held = _Held(frame, parameters, extraction, seconds)

    def held(self, frame: RGBDFrame, parameters: BlockParameters) -> Extraction | None:
        """The extraction of a frame with these parameters, if that is the one held."""
        held = self._held
        fits = held is not None and held.frame is frame and held.parameters == parameters
        return held.extraction if held is not None and fits else None

    def held_parameters(self, frame: RGBDFrame) -> BlockParameters | None:
        """What the extraction that is held was made with, if it is of this frame."""
        return self._held.parameters if self._held is not None and self._held.frame is frame else None

    def turn_to(self, frame: RGBDFrame | None) -> None:
        """Hold no extraction of another frame, and answer no question about one any more."""
        if self._held is not None and self._held.frame is not frame:
            self._held = None
        self._next = self._present = self._hopeless = None

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._next = None
        return self._worker.shutdown()

    def _start(self) -> None:
        self._present, self._next = self._next, None
        if self._present is None:
            return
        question, held = self._present, self._held
        if held is not None and (held.frame is not question.frame or held.parameters != question.parameters):
            held = None

        def job() -> Generator[None, None, Answer]:
            yield None
            frame = question.frame
            begun = time.perf_counter()
            extraction = held.extraction if held is not None else extract(frame, question.parameters)
            seconds = held.seconds if held is not None else time.perf_counter() - begun
            return Answer(question, extraction, seconds, stage_picture(question.stage, frame.rgb, extraction))

        self._worker.start(job)

    def _answer(self, answer: Answer) -> None:
        question, wanted = answer.question, self._present is not None
        if wanted:
            self._hopeless = None
            self.hold(question.frame, question.parameters, answer.extraction, answer.seconds)
        self._start()
        if wanted:
            self.found.emit(answer)

    def _fail(self, error: Exception) -> None:
        question = self._present
        if question is not None:
            self._hopeless = question
        self._start()
        if question is not None:
            self.failed.emit(error)
