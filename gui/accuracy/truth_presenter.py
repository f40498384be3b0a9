"""Errors against the frame's truth: judged off the GUI's thread, for the panel and for the table of blocks."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal

from gui.accuracy.accuracy_panel import NO_FRAME, AccuracyPanel
from gui.accuracy.judged_results import Answer, Entry, Judge, Question
from gui.accuracy.rows import truth_rows
from gui.accuracy.truth_dialog import described
from gui.desk import Desk
from gui.state.session import Session
from gui.work.latest_question import LatestQuestion
from ilf.blocks import Box
from ilf.frame import RGBDFrame

_NO_TRUTH = "No truth: load one, or test on hidden depth."
_NO_RESULT = "Run the filter: there is nothing to judge yet."
_JUDGING = "Judging…"


class TruthPresenter(QObject):
    """The page of the truth.

    Signals
    -------
    judged()
        The blocks' errors are other ones.
    """

    judged = Signal()

    def __init__(self, desk: Desk, panel: AccuracyPanel) -> None:
        super().__init__(panel)
        self._desk = desk
        self._panel = panel
        self._questions = LatestQuestion[Question, Answer](Judge(), self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: desk.notes.report("Judging against the truth", error))
        self._answered: Session | None = None
        self._told: RGBDFrame | None = None
        """The frame that it has been said of where its truth comes from."""
        self.blocks: dict[int, float] = {}
        """Label -> RMSE [m] of the present results."""

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._questions.busy

    def show(self) -> None:
        """Judge what there is now, if there is a truth to judge by."""
        workspace = self._desk.workspace
        session = workspace.session if workspace.has_session else None
        if session is not self._answered:
            self._forget()
        if session is None:
            self._told = None
            self._panel.say_source(NO_FRAME)
            self._panel.show_truth([], "")
            return
        frame, completion = session.frame, session.completion()
        self._say_source(session)
        if frame.truth is None or completion is None:
            self._forget()
            self._panel.show_truth([], _NO_TRUTH if frame.truth is None else _NO_RESULT)
            return
        entries = [Entry("Present", completion, frame)]
        areas = self._areas(session)
        if self._panel.isVisible():
            for kept in session.compared:
                entries.append(Entry(kept.name, kept.completion, kept.run.frame, kept.colour))
        else:
            areas = {}
        running = session in self._desk.runs.running
        question = Question(
            session, frame.truth, tuple(entries), session.labels.copy(), areas, self._panel.every, not running
        )
        if not self._panel.truth_table.rows:
            self._panel.show_truth([], _JUDGING)
        self._answered = session
        self._questions.ask(question)

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _areas(self, session: Session) -> dict[str, tuple[int, ...] | Box | None]:
        areas: dict[str, tuple[int, ...] | Box | None] = {"Frame": None}
        chosen = tuple(label for label in session.selected if label in session.counts())
        if chosen:
            areas[session.info(chosen[0]).name if len(chosen) == 1 else f"{len(chosen)} blocks"] = chosen
        if session.region is not None:
            areas["Rectangle"] = session.region
        return areas

    def _say_source(self, session: Session) -> None:
        frame = session.frame
        if frame is not self._told:
            self._told = frame
            file = None if frame.inputs is None else frame.inputs.truth
            name = "given" if file is None else Path(file.path).name
            text = f"{session.name} has no truth." if frame.truth is None else f"Truth: {name}. {described(frame)}"
            self._panel.say_source(text, "" if file is None else file.path)

    def _take(self, question: Question, answer: Answer) -> None:
        if question.session is not self._answered:
            return
        self.blocks = {label: judged.rmse for label, judged in answer.blocks.items() if judged.pixels}
        if answer.areas:
            self._panel.show_truth(truth_rows(answer, question.entries), "")
        self.judged.emit()

    def _forget(self) -> None:
        self._answered = None
        self._questions.forget()
        if self.blocks:
            self.blocks = {}
            self.judged.emit()
        self._panel.show_truth([], "")
