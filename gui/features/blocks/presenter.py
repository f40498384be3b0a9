"""Shows the blocks of the current frame in the table, and applies edits there to the workspace."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from PySide6.QtCore import QObject, QPoint
from PySide6.QtGui import QAction, QColor
from PySide6.QtWidgets import QMenu

from ilf._runtime.formatting import counted
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult
from ilf.drawing.blocks import block_colour
from ilf.project.frame_state import parameter_labels

from ...state.results import BlockCounts
from ...state.session import Session
from ...state.workspace import Workspace
from ...work.runs import RunController
from .model import BlockRow
from .table import BlockTable

# The rows of the table of blocks.


def block_rows(session: Session, runs: RunController) -> list[BlockRow]:
    """Rows of the current frame: one per block that has pixels, or is selected for painting."""
    results = session.valid_results()
    counts = {label: BlockCounts(0, 0) for label in session.selected} | session.counts()
    queued = runs.queued
    rows = []
    for label, count in counts.items():
        info = session.info(label)
        anew = label in runs.resolving
        records = [] if anew else session.results.live.get(label, [])
        result = results.get(label)
        if records:
            state, detail = "running", ""
            iterations, sigma = len(records), records[-1].sigma_i
        elif label in queued:
            state, detail, iterations, sigma = "queued", "", 0, math.nan
        elif result is not None:
            outcome = result.outcome
            values = session.parameters_of(label, session.common)
            outdated = not anew and not result.parameters.same_effect(values)
            state = "values changed" if outdated else str(outcome.status)
            iterations, sigma = outcome.iterations, outcome.sigma_i
            detail = _detail(result, values if outdated else None)
        elif label in session.results.kept:
            state, detail, iterations, sigma = "edited", "The block has changed since its last run.", 0, math.nan
        else:
            state, detail, iterations, sigma = "ready", "", 0, math.nan
        rows.append(
            BlockRow(
                label=label,
                name=info.name,
                colour=info.colour,
                pixels=count.pixels,
                defect_rate=count.defect_rate,
                state=state,
                detail=detail,
                iterations=iterations,
                sigma_i=sigma,
                visible=info.visible,
                locked=info.locked,
                error=session.block_errors.rmse.get(label, math.nan),
                look=_check_reason(session, label),
                own=", ".join(parameter_labels(session.notes.own.get(label, ()))),
            )
        )
    return rows


def _check_reason(session: Session, label: int) -> str:
    """Why a propagated block needs checking; "" if it does not."""
    if label not in session.to_check:
        return ""
    return session.notes.reasons.get(label, f"propagated from {session.notes.propagated_from or 'another frame'}")


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


_COLOURS = 1000
"""Upper limit of the start number of shuffled colours."""


class BlocksPresenter(QObject):
    """Presenter of the table of blocks and its menu.

    Parameters
    ----------
    commands : sequence of QAction or None
        Entries of the context menu; None is a separator.
    """

    def __init__(
        self, workspace: Workspace, runs: RunController, table: BlockTable, commands: Sequence[QAction | None]
    ) -> None:
        super().__init__(table)
        self._workspace = workspace
        self._runs = runs
        self._table = table
        self._commands = commands
        table.selectionChanged.connect(workspace.blocks.select)
        table.renamed.connect(lambda label, name: workspace.blocks.edit_info(label, "Rename block", name=name))
        table.recoloured.connect(self._recolour)
        table.visibilityChanged.connect(workspace.blocks.set_visible)
        table.lockChanged.connect(workspace.blocks.set_lock)
        table.contextMenuRequested.connect(lambda place, _: self.show_menu(place))

    def show(self) -> None:
        """Update the rows and the selection."""
        if self._workspace.has_session:
            session = self._workspace.session
            rows = block_rows(session, self._runs)
            self._table.set_error_source(session.block_errors.source)
            self._table.set_rows(rows)
            if self._table.selected() != [label for label in self._table.labels() if label in session.selected]:
                self._table.select(session.selected)
        else:
            self._table.set_rows([])

    def show_menu(self, place: QPoint) -> None:
        """Show the context menu of the selected blocks."""
        menu = QMenu(self._table)
        for command in self._commands:
            if command is None:
                menu.addSeparator()
            else:
                menu.addAction(command)
        menu.exec(place)
        menu.deleteLater()

    def shuffle_colours(self) -> None:
        """Assign new colours with distinct hues to all blocks, as one undoable step."""
        if not self._workspace.has_session:
            return
        session = self._workspace.session
        labels = list(session.counts())
        in_use = {session.info(label).colour for label in labels}
        start = random.randrange(1, _COLOURS)
        numbers = random.sample(range(start, start + len(labels)), len(labels))
        more = range(start + len(labels), start + 2 * len(labels))
        unused = [colour for colour in map(block_colour, [*numbers, *more]) if colour not in in_use]
        session.undo_stack.beginMacro("Shuffle colours")
        for label, colour in zip(labels, unused, strict=False):
            self._workspace.blocks.edit_info(label, "Recolour block", colour=colour)
        session.undo_stack.endMacro()

    def _recolour(self, label: int, colour: QColor) -> None:
        self._workspace.blocks.edit_info(label, "Recolour block", colour=(colour.red(), colour.green(), colour.blue()))
