"""The panel *Convergence*: records of blocks and of compared runs as curves, and a slider over earlier iterations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import length_text
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult, IterationRecord, Status
from ilf.evaluation.evaluation import evaluate
from ilf.run.key_frames import Track, depth_at_key_frames

from ..state.document import Document
from ..state.parts import Part
from ..state.results import ViewedIteration
from ..views.curves.curve import Curve
from ..views.curves.panel import EMPTY_TEXT, CurvesPanel
from ..widgets.docks import PanelGroup
from ..work.frame_runs import RunState
from .panel import Panel

MAX_CURVES = 8

_ACTIVE_STATES = (RunState.RUNNING, RunState.RESOLVING)


class CurvesFeature(Panel):
    """The curves of the selected blocks, and of the same blocks in compared runs, with a slider over iterations.

    While they have no curves, it shows the running block; without a selection, the block with the most iterations.

    Iteration i of the slider shows every block after its own iteration i, or its final depth if it ended sooner; blocks
    without key frames show their current depth. Starting or resuming a run, an edit and another frame reset the slider
    to its end.
    """

    title = "Convergence"
    icon = "ph.chart-line"
    shows = "curves of the filter"
    group = PanelGroup.INSPECTION
    parts = Part.FRAME | Part.LABELS | Part.INFOS | Part.SELECTION | Part.PARAMETERS | Part.RESULTS | Part.COMPARED
    deferred = Part.SOME_RESULTS | Part.RECORDS  # drawing at each batch would slow the run down
    what = "earlier iteration"
    widget: CurvesPanel

    def make(self) -> CurvesPanel:
        panel = CurvesPanel()
        self._state = self.context.runs.state
        self._bar = bar = panel.scrub_bar
        bar.set_hint("View earlier iterations: the views show the depth after iteration i of every block.")
        bar.moved.connect(lambda _: self._show_iteration())
        self.workspace.about_to_change.connect(bar.go_to_end)
        self.context.runs.state_changed.connect(self._follow_run)
        edits = Part.LABELS | Part.STROKE | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS
        self.context.refresh.add("current iteration", bar.go_to_end, edits)
        self.context.refresh.add("earlier iteration", self._show_again, Part.RESULTS | Part.PARAMETERS, self.deferred)
        return panel

    def refresh(self, parts: Part) -> None:
        """Draw the curves; those already shown are extended. Update the range of the slider."""
        document = self.workspace.shown
        draw_curves(self.widget, document)
        last = 0 if document is None else max((len(records) for records, _ in _tracks(document)), default=0)
        self._bar.set_range(last)

    def _follow_run(self) -> None:
        before, self._state = self._state, self.context.runs.state
        if self._state in _ACTIVE_STATES and before not in _ACTIVE_STATES:
            self._bar.go_to_end()

    def _show_again(self) -> None:
        if not self._bar.at_end or self.workspace.viewed_iteration is not None:
            self._show_iteration()

    def _show_iteration(self) -> None:
        """Show the depth at the slider's iteration."""
        document, iteration = self.workspace.shown, self._bar.position
        if self._bar.at_end or document is None:
            self.requests.forget()
            self.widget.look_at(None)
            self.workspace.view_iteration(None)
            return
        self.widget.look_at(iteration)
        present = document.current_depth()
        base = (document.frame.depth if present is None else present).copy()
        blocks = [(track, track.at(iteration)) for records, track in _tracks(document) if iteration < len(records)]

        def show(depth: NDArray[np.float32]) -> None:
            if document is self.workspace.shown and not self._bar.at_end:
                self.workspace.view_iteration(ViewedIteration(depth, iteration))

        self.requests.ask(lambda: depth_at_key_frames(base, blocks), show)


def draw_curves(panel: CurvesPanel, document: Document | None) -> None:
    """Draw the curves of a frame, or say why there are none."""
    labels = [] if document is None else _shown_labels(document)
    if document is None or not labels:
        panel.set_hint()
        panel.show_curves([])
        return
    panel.set_hint(_hint(document, labels[0]))
    curves = [_block_curve(document, label) for label in labels]
    panel.show_curves([*curves, *_compared_curves(document, labels)][:MAX_CURVES])


def _shown_labels(document: Document) -> list[int]:
    """The blocks whose curves are shown; if there are none, the block whose reason is shown."""
    with_records = [label for label in document.selected if document.records_of(label)]
    if with_records:
        return with_records
    if document.results.running:
        return document.results.running[-1:]
    if document.selected:
        return document.selected[:1]
    lengths = {label: len(result.history) for label, result in document.valid_results().items()}
    longest = max(lengths, key=lambda label: lengths[label], default=0)
    return [longest] if lengths.get(longest) else []


def _block_curve(document: Document, label: int) -> Curve:
    info = document.info(label)
    parameters = document.parameters_of(label)
    metres = _criterion(parameters)
    limit, live = "", label in document.results.live
    remarks = ["own"] if "s_criteria" in document.blocks.own.get(label, {}) else []
    result = document.valid_results().get(label)
    if result is not None and not live and result.outcome.status is Status.ITERATION_LIMIT:
        limit = result.outcome.message
    if result is not None and result.history and not live:
        then = _criterion(result.parameters)
        if then is not None and then != metres:
            remarks.append(f"run used {length_text(then)}")
    return Curve(
        info.name,
        info.colour,
        document.records_of(label),
        s_criteria=metres,
        remark=", ".join(remarks),
        limit=limit,
        corrected=math.nan if result is None else _corrected_error(result, document.frame),
    )


def _compared_curves(document: Document, labels: Sequence[int]) -> list[Curve]:
    """Curves of the same blocks in the compared runs, run by run."""
    curves = []
    for kept in document.compared:
        for label in labels:
            result = kept.results.get(label)
            if result is not None and result.history:
                name = kept.name if len(labels) == 1 else f"{kept.name}: {document.info(label).name}"
                corrected = _corrected_error(result, kept.run.frame)
                curves.append(Curve(name, kept.colour, result.history, dashed=True, corrected=corrected))
    return curves


def _corrected_error(result: BlockResult, frame: RGBDFrame) -> float:
    """Error [m] as in `IterationRecord.error`, after the learned correction; NaN without one."""
    if not result.correction or frame.ground_truth is None:
        return math.nan
    box, mask = result.block.box, result.block.mask
    return evaluate(result.depth, frame.ground_truth[box][mask], ~frame.known[box][mask]).rmse


def _hint(document: Document, label: int) -> str:
    """The reason why a block has no curves."""
    result = document.valid_results().get(label)
    if result is None or result.history:
        return EMPTY_TEXT
    return result.outcome.message or EMPTY_TEXT


def _criterion(parameters: Parameters) -> float | None:
    """The stop criterion [m]; None if a run does not use it, as in the linear schedule."""
    used = parameters.filter == "edge-aware" or parameters.schedule == "staged"
    return parameters.s_criteria if used else None


def _tracks(document: Document) -> list[tuple[Sequence[IterationRecord], Track]]:
    """Records and key frames of all blocks that have key frames."""
    found = []
    for label in document.counts():
        records = document.records_of(label)
        track = document.key_frames.track(records)
        if track is not None:
            found.append((records, track))
    return found
