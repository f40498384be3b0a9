"""What the readout says of an iteration, column by column. No widgets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from gui.curves.readout import Column
from ilf.filter.convergence import IterationRecord
from ilf.filter.edge_aware.record import EdgeAwareRecord
from ilf.filter.pass_band.record import PassBandRecord
from ilf.number_words import length_text

_LENGTH = "0.000 mm"

Numbers = Iterator[tuple[Column, str]]


def readout_columns(records: Sequence[IterationRecord], has: Mapping[str, bool], by_time: bool) -> list[Column]:
    """The columns for some curves' iterations, the most telling first.

    Parameters
    ----------
    records : sequence of IterationRecord
        One of each curve.
    has : mapping of str to bool
        Whether any of the curves has an "error", or a "held_out".
    by_time : bool
        Whether the time matters most.
    """
    return [column for column, _ in _numbers(records[0], has, by_time, len(records) == 1)] if records else []


def readout_texts(records: Sequence[IterationRecord], has: Mapping[str, bool], by_time: bool) -> list[tuple[str, ...]]:
    """The texts in those columns, row by row."""
    return [tuple(text for _, text in _numbers(record, has, by_time, len(records) == 1)) for record in records]


def _numbers(record: IterationRecord, has: Mapping[str, bool], by_time: bool, alone: bool) -> Numbers:
    time = Column("", "000.00 s"), f"{record.seconds:.2f} s"
    yield Column("i", "0000"), f"{record.i}"
    if by_time:
        yield time
    yield Column("σ", _LENGTH), length_text(record.sigma_i)
    if has["error"]:
        yield Column("err", _LENGTH), length_text(record.error)
    if has["held_out"]:
        yield Column("hold-out", _LENGTH), length_text(record.held_out)
    yield Column("L1", "000,000 m"), f"{record.l1:,.4g} m" if record.l1 < 1e4 else f"{record.l1:,.0f} m"
    if alone:
        yield from _own(record)
    yield Column("stage", "000"), f"{record.stage}"
    yield Column("residual", _LENGTH), length_text(record.residual)
    if not by_time:
        yield time


def _own(record: IterationRecord) -> Numbers:
    """What a filter says of its iteration besides what all of them say."""
    if isinstance(record, PassBandRecord):
        yield Column("radii", "000.0 × 000.0"), f"{record.radii[0]:.1f} × {record.radii[1]:.1f}"
    elif isinstance(record, EdgeAwareRecord):
        yield Column("cells", "00 px"), f"{record.cell} px"
        yield Column("round", "0"), f"{record.round or '–'}"
