"""What the window shows of blocks: rows of the table, colours of the overlay."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gui.panels.block_table import BlockRow
from gui.runs import RunController
from gui.session import BlockCounts, Session
from ilf.completion import BlockResult
from ilf.parameters import Parameters


def block_rows(session: Session, runs: RunController, common: Parameters) -> list[BlockRow]:
    """One row per block that has pixels, or is chosen to be painted."""
    results = session.valid_results()
    counts = {label: BlockCounts(0, 0) for label in session.selected} | session.counts()
    own_run = runs.session is session
    queued = runs.queued if own_run else set()
    rows = []
    for label, count in counts.items():
        info = session.info(label)
        running = own_run and runs.block == label and label not in results
        records = runs.live.get(label, []) if own_run and runs.block == label else []
        result = results.get(label)
        if records:
            state, detail = "running", ""
            iterations, sigma = len(records), records[-1].sigma_i
        elif label in queued or running:
            state, detail, iterations, sigma = "queued", "", 0, math.nan
        elif result is not None:
            outcome = result.outcome
            state, iterations, sigma = str(outcome.status), outcome.iterations, outcome.sigma_i
            detail = _detail(result, session.parameters_of(label, common))
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
            )
        )
    return rows


def colour_table(session: Session) -> NDArray[np.uint8]:
    """RGBA by label for the overlay, chosen labels without pixels included; hidden blocks are transparent."""
    top = max([int(session.labels.max()), *session.selected])
    table = np.zeros((top + 1, 4), np.uint8)
    for label in range(1, top + 1):
        info = session.info(label)
        table[label] = (*info.colour, 255 if info.visible else 0)
    return table


def _detail(result: BlockResult, present: Parameters) -> str:
    outcome = result.outcome
    lines = [outcome.message] if outcome.message else []
    if outcome.iterations:
        lines.append(
            f"{outcome.iterations} iterations in {outcome.stages} pass bands, {outcome.recovered} pixels filled."
        )
    if result.parameters != present:
        lines.append("Run with other parameters than are set now.")
    return "\n".join(lines)
