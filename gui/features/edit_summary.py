"""Summary of the last edit, and the view of the state before it while a key is held."""

from __future__ import annotations

import html
import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QWidget

from ilf._runtime.formatting import grouped, millimetres
from ilf.data.results import Completion
from ilf.evaluation.edit_summary import EditSummary, summarise_edit
from ilf.run.run import Run
from ilf.segmentation.editing.patches import LabelPatch

from ..base import theme
from ..base.commands import command
from ..state.parts import DrawnChange, Edit, Part
from ..views.view_data import FormerState
from ..widgets.basics import Themed, lay_out
from ..work.frame_runs import RunState
from .context import Context, Feature

# One line under the views with the summary of the last edit.

_EQUAL = 0.05
"""Errors that differ by a smaller share count as equal."""

_MARGIN = 8
_EMPTY = "The effect of your last edit appears here."


class EditSummaryLine(Themed, QWidget):
    """Line that shows the last edit and whether it reduced the error.

    It takes its space before the first edit, so that the images do not move under the pointer.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel(textFormat=Qt.TextFormat.RichText, wordWrap=True)
        self.label.setMinimumSize(1, self.label.fontMetrics().height())
        self.label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        self.label.setToolTip(
            "Effect of the last edit, before and after; green is better and red is worse where it is certain. Ground "
            "truth, if the frame has one: root mean square error of the pixels filled in the edited blocks. Hold-out: "
            "known depth near the edited border is hidden, and the blocks there are completed without it; mean "
            "absolute error, equal where the difference is smaller than its uncertainty (95 %), which follows it. "
            "Expected RMS: an estimate. Hold Z to see the state before the edit."
        )
        self.row = lay_out(QHBoxLayout(self), self.label, margins=(_MARGIN, 2, _MARGIN, 2), stretched=self.label)
        self._content: tuple[str, EditSummary | None, str] | None = None
        self._looks = False
        self._empty = ""
        """What is shown before the first edit."""
        self._take_theme()

    def show_message(self, text: str, effect: EditSummary | None = None, note: str = "") -> None:
        """Show the title of an edit, its effect as far as known, and a note."""
        self._content = text, effect, note
        self._take_theme()

    def mark_before(self, on: bool) -> None:
        """Show whether the views show the state before the edit."""
        self._looks = on
        self._take_theme()

    def clear(self, editable: bool) -> None:
        """Show that there has been no edit; nothing if there is nothing to edit."""
        self._content, self._empty = None, _EMPTY if editable else ""
        self._take_theme()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        line = self.label.fontMetrics().height()
        beside_film_strip = self.height() > 2 * line
        # in one line, the rest is cut at a word
        self.label.setMaximumHeight(self.height() if beside_film_strip else line)
        self.label.setAlignment(Qt.AlignmentFlag.AlignVCenter if beside_film_strip else Qt.AlignmentFlag.AlignTop)

    def _take_theme(self) -> None:
        """Write the text, in the colours of the theme."""
        if self._content is None:
            tone = theme.colours(self.palette()).muted.name()
            self.label.setText(f'<span style="color:{tone}">{self._empty}</span>')
            return
        text, effect, note = self._content
        if self._looks:
            tone = theme.colours(self.palette()).accent.name()
            self.label.setText(f'<span style="color:{tone}"><b>Before the edit: {html.escape(text)}</b></span>')
            return
        parts = [f"<b>{html.escape(text)}</b>"]
        if effect is not None:
            if effect.moved:
                parts.append(f"{grouped(effect.moved)} px moved")
            if effect.filled is not None and effect.filled[0] != effect.filled[1]:
                before, after = effect.filled
                parts.append(f"filled {self._tinted(grouped(before), f'{grouped(after)} px', None)}")
            if effect.by_ground_truth is not None:
                parts.append(f"ground truth {self._change(*effect.by_ground_truth)}")
            if effect.held_out is not None:
                parts.append(f"hold-out {self._change(*effect.held_out, certain=effect.held_out_differs)}")
                if not effect.held_out_differs and math.isfinite(effect.margin):
                    parts[-1] += f" (±{millimetres(effect.margin)} mm)"
            if effect.expected is not None:
                tone = theme.colours(self.palette()).muted.name()
                expected = "\u00a0→\u00a0".join(map(millimetres, effect.expected))
                parts.append(f'<span style="color:{tone}">expected RMS {expected} mm</span>')
        if note:
            parts.append(html.escape(note))
        self.label.setText(" &nbsp;·&nbsp;&nbsp;".join(parts))

    def _change(self, before: float, after: float, certain: bool = True) -> str:
        """Return two errors [m] as text, coloured as better or worse if that is certain."""
        differ = certain and abs(after - before) > _EQUAL * max(before, after)
        better = after < before if differ else None
        return self._tinted(millimetres(before), f"{millimetres(after)} mm", better)

    def _tinted(self, before: str, after: str, better: bool | None) -> str:
        """Return two values as text; `better` is None where they count as equal."""
        colours = theme.colours(self.palette())
        tone = {True: colours.good, False: colours.error, None: colours.text}[better]
        return f'{before}\u00a0→\u00a0<span style="color:{tone.name()}"><b>{after}</b></span>'


_UNKNOWN = "too little known depth nearby to evaluate it"


class EditSummaryFeature(Feature):
    """The line that summarises the last edit of the current frame, and the command that shows the state before it.

    The effect on depth is computed in a worker thread once the edited blocks have been completed again: after the next
    run, if live depth is off.
    """

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = workspace = context.workspace
        self.line = EditSummaryLine()
        context.centre.add_strip(self.line)
        self._change: Edit | None = None
        """The last edit; None for none."""
        self._asked = True
        """Whether its effect is asked for, or not to be."""
        self._before: Completion | None = None
        """Completion before the last edit."""
        self._present: Completion | None = None
        """Completion when no run was in progress."""
        workspace.about_to_change.connect(self._note_present)
        workspace.edited.connect(self._take)
        workspace.on(Part.FRAME | Part.REPLACED, self._forget)
        workspace.on(Part.GROUND_TRUTH, self._ask_again)
        workspace.on(Part.PARAMETERS | Part.RESULTS, self._go_on)
        context.runs.state_changed.connect(self._go_on)
        context.runs.resolved.connect(self._tell_resolved)
        self.line.clear(workspace.has_current)
        edits = Part.STROKE | Part.LABELS | Part.INVALID_MASK | Part.BY_HAND | Part.NEIGHBOURS
        # an edit shows the current state again
        before = context.actions["show_before_edit"]
        context.refresh.add("state before the edit", partial(before.setChecked, False), Part.FRAME | edits)

    @command("show_before_edit", "Show state &before the last edit", icon="ph.eye", checkable=True, held="Z")
    def _show_before(self, on: bool) -> None:
        """Show blocks and depth before the last edit; holding Z does the same.

        If it was undone, they are those after it.
        """
        self.line.mark_before(on)
        change = self._change
        if not on or change is None:
            self.context.views.look_back(None)
            return
        labels = self._workspace.current.labels
        if change.patch is not None:
            labels = _labels_before(change.patch, change.forward, labels)
        self.context.views.look_back(FormerState(labels, None if self._before is None else self._before.depth))

    def _take(self, edit: Edit) -> None:
        """Note an edit at once: results of the blocks before it are gone by the next turn."""
        if not self._workspace.is_shown(edit.document):
            return
        self._change, self._before, self._asked = edit, self._present, False
        self.requests.forget()
        patch = edit.patch
        moved = 0 if patch is None else int(np.count_nonzero(patch.before != patch.after))
        self.line.show_message(_title(edit), EditSummary(moved))
        self._go_on()

    def _forget(self) -> None:
        self._change, self._before, self._present, self._asked = None, None, None, True
        self.requests.forget()
        self.line.clear(self._workspace.has_current)
        self._note_present()

    def _go_on(self) -> None:
        self._note_present()
        if self.context.runs.state is not RunState.IDLE or not self._workspace.has_current:
            return
        change = self._change
        if self._asked or change is None or (change.patch is None and self._before is None):
            return
        document = change.document
        solved = bool(document.results.kept) or not self.context.actions.is_on("live")
        if solved and not all(document.is_up_to_date(label) for label in change.blocks & document.counts().keys()):
            return  # they are not completed yet
        self._asked = True
        run = document.run(document.state.common)
        self.requests.ask(
            partial(_summary, change, run, self._before, self._present),
            partial(self._say, change),
            lambda error: self._say(change, None, f"not evaluated: {error}"),
        )

    def _ask_again(self) -> None:
        """Evaluate the edit again, because the ground truth has changed."""
        self._asked = self._change is None or self._change.patch is None
        self._go_on()

    def _note_present(self) -> None:
        """Note the present completion, unless a run is changing it."""
        if self.context.runs.state is RunState.IDLE:
            self._present = self._workspace.current.completion() if self._workspace.has_current else None

    def _say(self, change: Edit, effect: EditSummary | None, note: str = "") -> None:
        if change is self._change:
            known = effect is None or effect.held_out is not None or effect.by_ground_truth is not None
            self.line.show_message(_title(change), effect, note or ("" if known or change.patch is None else _UNKNOWN))

    def _tell_resolved(self, text: str) -> None:
        if not self.busy:  # after an edit, its summary is shown instead
            self.context.notes.show_briefly(text)


def _title(change: Edit) -> str:
    return change.text if change.forward else f"Undone: {change.text}"


def _summary(edit: Edit, run: Run, before_edit: Completion | None, after: Completion | None) -> EditSummary:
    """Summarise an edit, from the run after it and the completions before and after it; called in a worker thread."""
    patch = edit.patch
    if patch is None:
        return summarise_edit(run, run, None, (before_edit, after))
    labels = _labels_before(patch, edit.forward, run.blocks.labels)
    drawn = run.blocks.drawn if edit.drawn is None else _drawn_before(edit.drawn, edit.forward, run)
    before = replace(run, blocks=replace(run.blocks, labels=labels, drawn=drawn))
    there = set(np.unique(labels[patch.box]).tolist()) - {0}
    known = before_edit is not None and there <= before_edit.results.keys()
    completed = before_edit if known else None  # blocks edited earlier and not run since have no result to compare
    return summarise_edit(before, run, patch, (completed, after))


def _labels_before(patch: LabelPatch, forward: bool, labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the label map before a change, given the map after it."""
    former = labels.copy()
    (patch.revert if forward else patch.apply)(former)
    return former


def _drawn_before(change: DrawnChange, forward: bool, run: Run) -> NDArray[np.bool_]:
    """Return the mask of drawn borders before a change."""
    box, before, after = change
    former = np.zeros(run.frame.shape, bool) if run.blocks.drawn is None else run.blocks.drawn.copy()
    former[box] = before if forward else after
    return former
