"""Summary of the last edit, and the view of the state before it while a key is held."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QResizeEvent
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

    def __init__(self, text: Callable[[theme.Colours], str]) -> None:
        super().__init__()
        self._text = text
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
        self.draw()

    def draw(self) -> None:
        """Write the text, in the colours of the theme."""
        self.label.setText(self._text(theme.colours(self.palette())))

    def _take_theme(self) -> None:
        self.draw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        line = self.label.fontMetrics().height()
        beside_film_strip = self.height() > 2 * line
        # in one line, the rest is cut at a word
        self.label.setMaximumHeight(self.height() if beside_film_strip else line)
        self.label.setAlignment(Qt.AlignmentFlag.AlignVCenter if beside_film_strip else Qt.AlignmentFlag.AlignTop)


def summary_html(title: str, effect: EditSummary | None, note: str, colours: theme.Colours) -> str:
    """Return the title of an edit, its effect as far as known, and a note, as rich text."""
    parts = [f"<b>{html.escape(title)}</b>"]
    if effect is not None:
        if effect.moved:
            parts.append(f"{grouped(effect.moved)} px moved")
        if effect.filled is not None and effect.filled[0] != effect.filled[1]:
            before, after = effect.filled
            parts.append(f"filled {_tinted(grouped(before), f'{grouped(after)} px', colours.text)}")
        if effect.by_ground_truth is not None:
            parts.append(f"ground truth {_change(*effect.by_ground_truth, colours)}")
        if effect.held_out is not None:
            parts.append(f"hold-out {_change(*effect.held_out, colours, certain=effect.held_out_differs)}")
            if not effect.held_out_differs and math.isfinite(effect.margin):
                parts[-1] += f" (±{millimetres(effect.margin)} mm)"
        if effect.expected is not None:
            expected = "\u00a0→\u00a0".join(map(millimetres, effect.expected))
            parts.append(_in_tone(colours.muted, f"expected RMS {expected} mm"))
    if note:
        parts.append(html.escape(note))
    return "&nbsp;&nbsp;·&nbsp; ".join(parts)


def _in_tone(tone: QColor, text: str) -> str:
    return f'<span style="color:{tone.name()}">{text}</span>'


def _change(before: float, after: float, colours: theme.Colours, certain: bool = True) -> str:
    """Return two errors [m] as text, coloured as better or worse if that is certain."""
    differ = certain and abs(after - before) > _EQUAL * max(before, after)
    tone = (colours.good if after < before else colours.error) if differ else colours.text
    return _tinted(millimetres(before), f"{millimetres(after)} mm", tone)


def _tinted(before: str, after: str, tone: QColor) -> str:
    """Return two values as text, the second in a tone."""
    return f"{before}\u00a0→\u00a0{_in_tone(tone, f'<b>{after}</b>')}"


_UNKNOWN = "too little known depth nearby to evaluate it"


class EditSummaryFeature(Feature):
    """The line that summarises the last edit of the current frame, and the command that shows the state before it.

    The effect on depth is computed in a worker thread once the edited blocks have been completed again: after the next
    run, if live depth is off.
    """

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._change: Edit | None = None
        """The last edit; None for none."""
        self._effect: EditSummary | None = None
        """Its effect as far as known."""
        self._note = ""
        """What is said of the effect."""
        self.line = EditSummaryLine(self._text)
        context.centre.add_strip(self.line)
        self._asked = True
        """Whether its effect is asked for, or not to be."""
        self._before: Completion | None = None
        """Completion before the last edit."""
        self._present: Completion | None = None
        """Completion when no run was in progress."""
        self.workspace.about_to_change.connect(self._note_present)
        self.workspace.edited.connect(self._take)
        self.workspace.on(Part.FRAME | Part.REPLACED, self._forget)
        self.workspace.on(Part.GROUND_TRUTH, self._ask_again)
        self.workspace.on(Part.PARAMETERS | Part.RESULTS, self._go_on)
        context.runs.state_changed.connect(self._go_on)
        edits = Part.STROKE | Part.LABELS | Part.INVALID_MASK | Part.BY_HAND | Part.NEIGHBOURS
        # an edit shows the current state again
        before = context.actions["show_before_edit"]
        context.refresh.add("state before the edit", partial(before.setChecked, False), Part.FRAME | edits)

    def _why_no(self) -> str:
        return "" if self._change is not None else "Edit a block first."

    @command(
        "show_before_edit", "Show state &before the last edit", icon="ph.eye", checkable=True, held="Z", why_off=_why_no
    )
    def _show_before(self, on: bool) -> None:
        """Show blocks and depth before the last edit; holding Z does the same.

        If it was undone, they are those after it.
        """
        self.line.draw()
        change = self._change
        if not on or change is None:
            self.views.look_back(None)
            return
        labels = self.workspace.current.labels
        if change.patch is not None:
            labels = _labels_before(change.patch, change.forward, labels)
        self.views.look_back(FormerState(labels, None if self._before is None else self._before.depth))

    def _take(self, edit: Edit) -> None:
        """Note an edit at once: results of the blocks before it are gone by the next turn."""
        if edit.document is not self.workspace.shown:
            return
        self._change, self._before, self._asked, self._note = edit, self._present, False, ""
        self.requests.forget()
        patch = edit.patch
        self._effect = EditSummary(0 if patch is None else int(np.count_nonzero(patch.before != patch.after)))
        self.line.draw()
        self._go_on()

    def _forget(self) -> None:
        self._change, self._before, self._present, self._asked = None, None, None, True
        self.requests.cancel()
        self.line.draw()
        self._note_present()

    def _go_on(self) -> None:
        self._note_present()
        if self.context.runs.state is not RunState.IDLE or self.workspace.shown is None:
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
            self._present = self.workspace.shown.completion() if self.workspace.shown is not None else None

    def _say(self, change: Edit, effect: EditSummary | None, note: str = "") -> None:
        if change is self._change:
            known = effect is None or effect.held_out is not None or effect.by_ground_truth is not None
            self._effect, self._note = effect, note or ("" if known or change.patch is None else _UNKNOWN)
            self.line.draw()

    def _text(self, colours: theme.Colours) -> str:
        """What the line says: the last edit with its effect, or that the views show the state before it."""
        if self._change is None:
            return _in_tone(colours.muted, _EMPTY if self.workspace.shown is not None else "")
        title = self._change.text if self._change.forward else f"Undone: {self._change.text}"
        if self.context.actions.is_on("show_before_edit"):
            return _in_tone(colours.accent, f"<b>Before the edit: {html.escape(title)}</b>")
        return summary_html(title, self._effect, self._note, colours)


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
