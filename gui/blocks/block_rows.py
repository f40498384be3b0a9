"""What the window shows of blocks: the rows of their table."""

from __future__ import annotations

import math

from gui.blocks.block_table import BlockRow
from gui.state.session import Session
from gui.state.tally import BlockCounts
from gui.work.runs import RunController
from ilf.outcomes import BlockResult
from ilf.parameters import Parameters
from ilf.project.own_values import parameter_labels


def block_rows(session: Session, runs: RunController) -> list[BlockRow]:
    """Of the present frame, one row per block that has pixels, or is chosen to be painted."""
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
            state, detail, iterations, sigma = "edited", "The block has changed since it was run.", 0, math.nan
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
                look=_look(session, label),
                own=", ".join(parameter_labels(session.notes.own.get(label, ()))),
            )
        )
    return rows


def _look(session: Session, label: int) -> str:
    """Why a block that came from another frame needs a look; "" if it does not."""
    if label not in session.to_check:
        return ""
    return session.notes.reasons.get(label, f"it comes from {session.notes.carried_from or 'another frame'}")


def _detail(result: BlockResult, wanted: Parameters | None) -> str:
    """What became of a block, whose result is of other values than those that are wanted, unless these are None."""
    outcome = result.outcome
    lines = []
    if wanted is not None:
        waits = wanted.correction and result.parameters.replace(correction=True).same_effect(wanted)
        what = "waits for the learned correction" if waits else "is of other values than are set now"
        lines.append(f"The result, {outcome.status}, {what}.")
    lines += [outcome.message] if outcome.message else []
    if outcome.iterations:
        lines.append(f"{outcome.iterations} iterations in {outcome.stages} stages, {outcome.recovered} pixels filled.")
    lines += result.notes
    return "\n".join(lines)
