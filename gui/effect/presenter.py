"""Says what every edit has done, and shows the state before it while a key is held."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject
from PySide6.QtGui import QAction

from gui.effect.effect_line import EffectLine
from gui.state.commands import Change, DrawnChange
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.views.presenter import ViewsPresenter
from gui.work.latest_question import LatestQuestion
from gui.work.runs import RunController, RunState
from ilf.ebs.edit import LabelPatch
from ilf.number_words import grouped
from ilf.outcomes import Completion
from ilf.run import Effect, Run, edit_effect

_UNKNOWN = "too little known depth near it to judge it by"


@dataclass(frozen=True, eq=False)
class _Question:
    """An edit, the run that the frame is after it, and what was completed before and after."""

    patch: LabelPatch
    forward: bool
    drawn: DrawnChange
    run: Run
    before: Completion | None
    after: Completion | None


class EffectPresenter(QObject):
    """The line that says what the last edit of the present frame has done.

    What it did to the depth is worked out when the touched blocks have been solved again, off the GUI's thread.

    Parameters
    ----------
    live : QAction
        Whether blocks are solved again after edits; without, what an edit did is known after the next run.
    """

    def __init__(
        self, workspace: Workspace, runs: RunController, views: ViewsPresenter, line: EffectLine, live: QAction
    ) -> None:
        super().__init__(line)
        self._workspace = workspace
        self._runs = runs
        self._views = views
        self._line = line
        self._live = live
        self._change: Change | None = None
        self._asked = True
        self._edited = False
        """Whether there is a state before an edit."""
        self._before: Completion | None = None
        """What was completed before the last edit."""
        self._present: Completion | None = None
        """What is completed, as it was when nothing was under way."""
        self._questions = LatestQuestion[_Question, Effect](_find, self)
        self._questions.answered.connect(self._say)
        self._questions.failed.connect(lambda question, error: self._say(question, None, f"not known: {error}"))
        workspace.edited.connect(self._take)
        workspace.session_changed.connect(self._forget)
        workspace.replaced.connect(self._forget)
        workspace.guide_changed.connect(self._forget)
        workspace.distrusted_changed.connect(self._take_distrusted)
        workspace.truth_changed.connect(self._ask_again)
        for changed in (workspace.parameters_changed, workspace.results_changed, runs.state_changed):
            changed.connect(self._go_on)

    @property
    def busy(self) -> bool:
        """Whether an effect is to come."""
        return self._questions.busy

    def look(self, on: bool) -> None:
        """Show the blocks and the depth before the last edit, or after it if it has been undone; or go back."""
        self._line.mark_look(on)
        if not on or not self._edited:
            self._views.show_present()
            return
        labels = self._workspace.session.labels
        if self._change is not None:
            labels = _labels_before(self._change.patch, self._change.forward, labels)
        self._views.show_other(labels, None if self._before is None else self._before.depth)

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, change: Change) -> None:
        self._change, self._asked, self._edited = change, False, True
        self._before = self._present
        self._questions.forget()
        self._line.say(_title(change), Effect(int(np.count_nonzero(change.patch.before != change.patch.after))))
        self._go_on()

    def _take_distrusted(self) -> None:
        """Other depth is distrusted: the state before it can be seen; its effect is that on all blocks."""
        before = self._present
        self._forget()
        self._edited, self._before = True, before
        frame = self._workspace.session.frame
        count = int(np.count_nonzero(np.isfinite(frame.measured) & ~frame.known))
        self._line.say("Distrusted depth", note=f"{grouped(count)} px" if count else "none")

    def _forget(self) -> None:
        self._change, self._before, self._asked, self._edited = None, None, True, False
        self._questions.forget()
        self._line.clear()
        self._note_present()

    def _go_on(self) -> None:
        if self._runs.state is not RunState.IDLE or not self._workspace.has_session:
            return
        self._note_present()
        if self._asked or self._change is None:
            return
        session = self._change.session
        solved = bool(session.results.kept) or not self._live.isChecked()
        if solved and not all(session.is_up_to_date(label) for label in self._there(session)):
            return  # they are still to be solved
        self._asked = True
        run = session.run(self._workspace.parameters)
        change = self._change
        self._questions.ask(_Question(change.patch, change.forward, change.drawn, run, self._before, self._present))

    def _ask_again(self) -> None:
        """There is something else to judge the edit by."""
        self._asked = self._change is None
        self._go_on()

    def _there(self, session: Session) -> frozenset[int]:
        return frozenset() if self._change is None else self._change.blocks & session.counts().keys()

    def _note_present(self) -> None:
        self._present = self._workspace.session.completion() if self._workspace.has_session else None

    def _say(self, question: _Question, effect: Effect | None, note: str = "") -> None:
        change = self._change
        if change is not None and (change.patch, change.forward) == (question.patch, question.forward):
            unknown = effect is not None and effect.held_out is None and effect.by_truth is None
            self._line.say(_title(change), effect, note or (_UNKNOWN if unknown else ""))


def _title(change: Change) -> str:
    return change.text if change.forward else f"Undone: {change.text}"


def _find(question: _Question) -> Effect:
    """Off the GUI's thread."""
    run, patch = question.run, question.patch
    labels = _labels_before(patch, question.forward, run.blocks)
    before = replace(run, blocks=labels, drawn=_drawn_before(question.drawn, question.forward, run))
    there = set(np.unique(labels[patch.box]).tolist()) - {0}
    known = question.before is not None and there <= question.before.results.keys()
    completed = question.before if known else None  # what was edited before and not run since has no result to compare
    return edit_effect(before, run, patch, (completed, question.after))


def _labels_before(patch: LabelPatch, forward: bool, labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """The label map of before a change, which has made it what it is."""
    former = labels.copy()
    (patch.revert if forward else patch.apply)(former)
    return former


def _drawn_before(change: DrawnChange, forward: bool, run: Run) -> NDArray[np.bool_]:
    """The drawn pixels of before a change."""
    box, before, after = change
    former = np.zeros(run.blocks.shape, bool) if run.drawn is None else run.drawn.copy()
    former[box] = before if forward else after
    return former
