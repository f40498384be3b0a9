"""The blocks of the current frame: their table with their errors, their commands, and the context menus."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from functools import partial
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QMenu

from ilf._runtime.formatting import counted
from ilf.data.blocks import block_colour
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult
from ilf.evaluation.evaluation import Evaluation, evaluate_blocks

from ...base.commands import command
from ...base.needs import Need, sentence
from ...state.document import Document
from ...state.frame_data import BlockCounts
from ...state.parameters import parameter_labels
from ...state.parts import Part
from ...widgets.docks import PanelGroup
from ...widgets.row_table import TableCells
from ...work.frame_runs import FrameRuns
from ..context import Context
from ..menus import BLOCK_MENU
from ..panel import Panel
from ..views import ViewsFeature
from .commands import BlockCommands
from .table import BlockTable, block_cells

# The rows of the table of blocks.


def block_rows(
    document: Document, runs: FrameRuns, errors: Mapping[int, float] | None = None, errors_are_expected: bool = False
) -> dict[int, TableCells]:
    """Rows of the current frame: one per block that has pixels, or is selected for painting; with their known errors
    [m]."""
    results, queued, own = document.valid_results(), runs.queued, document.blocks.own
    counts = {label: BlockCounts(0, 0) for label in document.selected} | document.counts()
    return {
        label: block_cells(
            document.info(label),
            count,
            *_progress(document, label, results.get(label), label in queued, label in runs.resolving),
            own=", ".join(parameter_labels(own[label])) if label in own else "",
            look=_check_reason(document, label),
            error=(errors or {}).get(label, math.nan),
            error_is_expected=errors_are_expected,
        )
        for label, count in counts.items()
    }


def _progress(
    document: Document, label: int, result: BlockResult | None, queued: bool, anew: bool
) -> tuple[str, str, int, float]:
    """State of a block, and what is said of it; its iterations, and the last deviation [m]. `anew`: it is completed
    again."""
    records = [] if anew else document.results.live.get(label, [])
    if records:
        return "running", "", len(records), records[-1].sigma_i
    if queued:
        return "queued", "", 0, math.nan
    if result is None:
        edited = "edited", "The block has changed since its last run."
        return *(edited if label in document.results.kept else ("ready", "")), 0, math.nan
    outcome, values = result.outcome, document.parameters_of(label)
    outdated = not anew and not result.parameters.same_effect(values)
    state = "values changed" if outdated else str(outcome.status)
    return state, _detail(result, values if outdated else None), outcome.iterations, outcome.sigma_i


def _check_reason(document: Document, label: int) -> str:
    """Why a propagated block needs checking; "" if it does not."""
    if label not in document.state.to_check:
        return ""
    return document.blocks.reasons.get(label, f"propagated from {document.blocks.propagated_from or 'another frame'}")


def _detail(result: BlockResult, wanted: Parameters | None) -> str:
    """Describe the result of a block; `wanted` are the current values if they differ from the result's, else None."""
    outcome = result.outcome
    lines = []
    if wanted is not None:
        waits = wanted.correction and result.parameters.replace(correction=True).same_effect(wanted)
        what = "waits for the learned correction" if waits else "was computed with other values"
        lines.append(f"The result, {outcome.status}, {what}.")
    lines += [outcome.message] if outcome.message else []
    if outcome.iterations:
        lines.append(
            f"{counted(outcome.iterations, 'iteration')} in {counted(outcome.stages, 'stage')}, "
            f"{counted(outcome.recovered, 'pixel')} filled."
        )
    lines += result.notes
    return "\n".join(lines)


def expected_errors(error: NDArray[np.float32], labels: NDArray[np.int32]) -> dict[int, float]:
    """Return the root mean square of the expected error [m], float32 (H, W), NaN = unknown, over each block."""
    known = np.isfinite(error)
    inside = labels[known]
    counts = np.bincount(inside)
    sums = np.bincount(inside, np.square(error[known], dtype=np.float64))
    there = [int(label) for label in np.flatnonzero(counts) if label]
    return {label: float(np.sqrt(sums[label] / counts[label])) for label in there}


HeldOut = Callable[[Document], Mapping[int, float]]
"""Finds the errors [m] of a frame's blocks in a hold-out test, as far as they are valid."""

_EVALUATED = Part.FRAME | Part.LABELS | Part.RESULTS | Part.SOME_RESULTS | Part.GROUND_TRUTH
"""The parts that errors against ground truth depend on."""
_OF_ERRORS = _EVALUATED | Part.PARAMETERS | Part.EXPECTED_ERROR
"""Those that any errors depend on."""
_COLOURS = 1000
"""Upper limit of the start number of shuffled colours."""


class BlocksFeature(Panel):
    """The table of blocks, the commands on the selected ones, and both context menus.

    The errors in the table are those against ground truth; without it, those of a hold-out test that is valid; else the
    expected ones.
    """

    title, icon, group, at_start = "Blocks", "ph.stack", PanelGroup.WORK, True
    parts = Part.FRAME | Part.LABELS | Part.INFOS | Part.SELECTION | Part.PARAMETERS | Part.RESULTS | Part.RUNNING
    parts |= Part.GROUND_TRUTH | Part.EXPECTED_ERROR
    deferred = Part.SOME_RESULTS | Part.RECORDS
    what = "evaluation against ground truth"

    def __init__(self, context: Context) -> None:
        self._errors: tuple[Mapping[int, float], bool] | None = None
        """The known errors of blocks [m], and whether they are the expected ones; None before they are looked up."""
        self._held_out: WeakKeyDictionary[Document, HeldOut] = WeakKeyDictionary()
        self._evaluated: WeakKeyDictionary[Document, Mapping[int, Evaluation]] = WeakKeyDictionary()
        """A frame with ground truth, and the evaluation of its blocks."""
        self._expected: dict[int, float] = {}
        """Expected errors of the blocks, from the expected error `_of`."""
        self._of: NDArray[np.float32] | None = None
        self._results: WeakValueDictionary[int, BlockResult] = WeakValueDictionary()
        """The results that `_expected` belongs to."""
        super().__init__(context)
        context.views.navigation.contextMenuRequested.connect(self._show_menu_at)
        context.loader.busy_changed.connect(self._show_hint)

    def make(self) -> BlockTable:
        self.table = table = BlockTable(self.workspace)
        table.labelsSelected.connect(self.workspace.select)
        menu = self.context.actions.menu
        table.customContextMenuRequested.connect(
            lambda at: self._run(menu("", table, BLOCK_MENU), table.viewport().mapToGlobal(at))
        )
        table.shown.connect(lambda _: self.context.feature(ViewsFeature).zoom_to_blocks())
        return table

    def _show_hint(self) -> None:
        """Say in the empty table what is under way, or what to do."""
        wanted = sentence(Need.FRAME & self.context.missing()) or "Extract blocks from the frame, or paint one"
        self.table.hint = self.context.loader.present or wanted
        self.table.viewport().update()

    def refresh(self, parts: Part) -> None:
        """Update the rows and the selection, and have the results evaluated again if they have changed."""
        table, workspace = self.table, self.workspace
        if (document := workspace.shown) is None:
            table.set_rows({})
            self._show_hint()
            return
        if parts & _EVALUATED:
            self._evaluate(document)
        if self._errors is None or parts & _OF_ERRORS:
            self._errors = self._known_errors(document)
        rows = block_rows(document, self.context.runs.current, *self._errors)
        table.set_rows(rows)
        if not rows:
            self._show_hint()
        if table.chosen() != [label for label in table.labels() if label in document.selected]:
            table.select(document.selected)

    def _evaluate(self, document: Document) -> None:
        """Have the current results evaluated, if there is ground truth."""
        completion = None if document.frame.ground_truth is None else document.completion()
        if completion is None:
            self.requests.forget()
            self._evaluated.clear()
        else:
            frame, labels = document.frame, document.labels.copy()
            self.requests.ask(lambda: evaluate_blocks(frame, completion, labels), partial(self._take, document))

    def _take(self, document: Document, evaluated: Mapping[int, Evaluation]) -> None:
        self._evaluated, self._errors = WeakKeyDictionary({document: evaluated}), None
        self.redraw()

    def take_hold_out(self, document: Document, errors_of: HeldOut) -> None:
        """Show the errors of the last hold-out test of a frame, as long as they are valid."""
        self._held_out[document], self._errors = errors_of, None
        self.redraw()

    def _known_errors(self, document: Document) -> tuple[Mapping[int, float], bool]:
        if document.frame.ground_truth is not None:
            evaluated = self._evaluated.get(document, {})
            return {label: one.rmse for label, one in evaluated.items() if one.pixels}, False
        if document in self._held_out and (held_out := self._held_out[document](document)):
            return held_out, False
        error, results = document.expected_error(), document.valid_results()
        if error is None:  # until it is computed again: of the blocks with unchanged results
            same = {label for label, result in results.items() if self._results.get(label) is result}
            return {label: rmse for label, rmse in self._expected.items() if label in same}, True
        if error is not self._of:
            self._of, self._results = error, WeakValueDictionary(results)
            self._expected = expected_errors(error, document.labels)
        return self._expected, True

    def _show_menu_at(self, place: QPoint, x: float, y: float) -> None:
        """Show the context menu of the views at a screen position, which is x, y in the image."""
        if self.workspace.shown is not None:
            self._run(self.menu_at(x, y), place)

    def menu_at(self, x: float, y: float) -> QMenu:
        """Return the context menu of the views for a position in the image.

        The block there is selected; the block that was selected before can take over that block or a piece of it.
        """
        menu = self.context.actions.menu("", self.views)
        for text, act in self.context.feature(BlockCommands).offers(x, y):
            menu.addAction(text).triggered.connect(lambda _=False, act=act: act())
        self.context.actions.fill(menu, f"| {BLOCK_MENU}")
        return menu

    @staticmethod
    def _run(menu: QMenu, place: QPoint) -> None:
        menu.exec(place)
        menu.deleteLater()

    @command("rename_block", "Rename &block", icon="ph.pencil-simple", keys="F2", needs=Need.SELECTION)
    def rename(self) -> None:
        """Rename the selected block."""
        self.reveal()
        self.context.refresh.now()
        self.table.rename()

    @command("shuffle_colours", "Shuffle colours", icon="ph.shuffle", needs=Need.BLOCKS)
    def shuffle_colours(self) -> None:
        """Assign other colours to the blocks, as one undo step."""
        document = self.workspace.current
        labels = list(document.counts())
        in_use = {document.info(label).colour for label in labels}
        start = random.randrange(1, _COLOURS)
        numbers = random.sample(range(start, start + len(labels)), len(labels))
        more = range(start + len(labels), start + 2 * len(labels))
        unused = [colour for colour in map(block_colour, [*numbers, *more]) if colour not in in_use]
        changes = {label: {"colour": colour} for label, colour in zip(labels, unused, strict=False)}
        self.workspace.current.edit_infos(changes, "Shuffle colours")
