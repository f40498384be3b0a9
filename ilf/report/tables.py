"""The tables of a frame: its blocks, how far off it is, the runs that were kept, own values."""

from __future__ import annotations

import math

import numpy as np

from ..confidence import RMS_MEANING, RMS_NAME
from ..judgement import Judgement
from ..number_words import UNKNOWN, grouped, millimetres
from ..outcomes import Status, blocks_by_message
from ..preset_words import in_words, likeness
from ..project.own_values import own_values
from .content import Cell, Column, Table
from .figures import ErrorFigures, Figures
from .subject import Subject

_WORDS = False
RMSE = Column("RMSE [mm]", "Root mean square error: large errors count most")
EXPECTED = Column(f"{RMS_NAME} [mm]", RMS_MEANING)

NOT_RUN, OUTDATED = "not run", "values changed"


def block_table(figures: Figures) -> Table:
    """A row per block."""
    subject, completion = figures.subject, figures.subject.completion
    judged = figures.judged_by
    columns = [
        Column("no."),
        Column("block", number=_WORDS),
        Column("pixels"),
        Column("missing", "Share of its pixels that had no depth"),
        Column("filled", "Pixels that were missing and now have depth"),
        Column("status", number=_WORDS),
        Column("iterations"),
        Column("sigma [mm]", "sigma_i of the last iteration: by how much it still changed the surface"),
        EXPECTED,
    ]
    if judged:
        columns.append(Column(f"RMSE, {judged} [mm]", f"Root mean square error of what was filled, by {judged}"))
    rows = []
    frame, blocks = subject.run.frame, subject.run.blocks
    pixels = np.bincount(blocks.ravel())
    known = np.bincount(blocks[~frame.missing], minlength=pixels.size)
    for label in (np.flatnonzero(pixels[1:]) + 1).tolist():
        result = completion.results.get(label)
        cells = [
            Cell(str(label)),
            Cell(subject.name_of(label), subject.colour_of(label)),
            Cell(grouped(int(pixels[label]))),
            Cell(f"{1 - known[label] / pixels[label]:.1%}"),
        ]
        if result is None:
            cells += [Cell(UNKNOWN), Cell(NOT_RUN), Cell(UNKNOWN), Cell(UNKNOWN), Cell(UNKNOWN)]
        else:
            outcome = result.outcome
            outdated = not result.parameters.same_effect(subject.run.parameters_of(label))
            cells += [
                Cell(grouped(outcome.recovered)),
                Cell(OUTDATED if outdated else str(outcome.status), about=outcome.message),
                Cell(grouped(outcome.iterations)),
                Cell(millimetres(outcome.sigma_i)),
                Cell(millimetres(figures.expected_of(result))),
            ]
        if judged:
            cells.append(Cell(millimetres(figures.by_block.get(label, Judgement()).rmse)))
        rows.append(tuple(cells))
    return Table(tuple(columns), tuple(rows))


def block_remarks(subject: Subject) -> list[str]:
    """What went wrong with single blocks, and what the table's words mean."""
    wrong = [
        outcome
        for outcome in subject.completion.outcomes.values()
        if outcome.status in (Status.NOT_RECOVERABLE, Status.ITERATION_LIMIT)
    ]
    remarks = [f"No. {', '.join(map(str, labels))}: {message}" for message, labels in blocks_by_message(wrong).items()]
    run = subject.run
    if any(
        not result.parameters.same_effect(run.parameters_of(label))
        for label, result in subject.completion.results.items()
    ):
        remarks.append(f"“{OUTDATED}”: the result is of other values than are set now.")
    return remarks


def error_table(errors: tuple[ErrorFigures, ...]) -> Table:
    """A row per judgement."""
    columns = (
        Column("judged", number=_WORDS),
        Column("pixels", "That were compared"),
        RMSE,
        Column("MAE [mm]", "Mean absolute error"),
        Column("median [mm]", "Half of the pixels are closer"),
        Column("95 % [mm]", "95 % of the pixels are at least as close"),
        Column("bias [mm]", "Mean error; positive where the depth is too large"),
        Column("within", "Share whose error is within the expected error; about 68 % is as it should be"),
        Column("filled", "Share of the pixels to be filled that were"),
    )
    rows = tuple(
        (
            Cell(one.name),
            Cell(grouped(one.judgement.pixels)),
            Cell(millimetres(one.judgement.rmse)),
            Cell(millimetres(one.judgement.mae)),
            Cell(millimetres(one.judgement.median)),
            Cell(millimetres(one.p95)),
            Cell(millimetres(one.judgement.bias)),
            Cell(share(one.judgement.within)),
            Cell(share(one.coverage)),
        )
        for one in errors
    )
    return Table(columns, rows)


def own_table(subject: Subject) -> Table | None:
    """Blocks that have values of their own; None if there are none."""
    run = subject.run
    own = {label: own_values(parameters, run.parameters) for label, parameters in sorted(run.own.items())}
    rows = tuple(
        (Cell(str(label)), Cell(subject.name_of(label), subject.colour_of(label)), Cell("; ".join(in_words(values))))
        for label, values in own.items()
        if values
    )
    columns = Column("no."), Column("block", number=_WORDS), Column("values of its own", number=_WORDS)
    return Table(columns, rows) if rows else None


def runs_table(subject: Subject) -> Table:
    """A row per kept run."""
    columns = (
        Column("no."),
        Column("run", number=_WORDS),
        Column("when", number=_WORDS),
        Column("values", number=_WORDS),
        Column("blocks", "Blocks that it has run"),
        Column("iterations"),
        Column("time [s]"),
        Column("filled", "Pixels that its blocks have filled"),
        EXPECTED,
        Column("truth [mm]", "Root mean square error against the truth"),
        Column("hidden [mm]", "Root mean square error on hidden depth"),
        Column("note", number=_WORDS),
    )
    rows = tuple(
        (
            Cell(str(kept.number)),
            Cell(kept.name if kept.how == "finished" else f"{kept.name} ({kept.how})", kept.colour),
            Cell(f"{kept.when:%Y-%m-%d %H:%M}"),
            Cell(likeness(kept.run.parameters).text()),
            Cell(str(len(kept.done))),
            Cell(grouped(kept.iterations)),
            Cell(f"{kept.seconds:.1f}"),
            Cell(grouped(kept.recovered)),
            Cell(_or_unknown(kept.expected_error)),
            Cell(_or_unknown(kept.truth_error)),
            Cell(_or_unknown(kept.hidden_error)),
            Cell(kept.note),
        )
        for kept in subject.kept
    )
    return Table(columns, rows)


def share(value: float | None) -> str:
    """A share in per cent; a dash for none."""
    return UNKNOWN if value is None or not math.isfinite(value) else f"{value:.1%}"


def _or_unknown(metres: float | None) -> str:
    return UNKNOWN if metres is None else millimetres(metres)
