"""All records of a block's iterations, in little memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import lru_cache
from typing import overload

import numpy as np

from .convergence import IterationRecord

_AT_HAND = 32
"""Histories whose records stay as they are when they have been looked at: plots ask for the same again and again."""


class CompactHistory(Sequence[IterationRecord]):
    """Records in arrays, a quarter of their size or less; each is made anew when it is looked at, but for the first:
    by that very record, what belongs to the iteration can be told from what belongs to a like one.

    Parameters
    ----------
    records : sequence of IterationRecord
        All of one filter, one at least.

    Examples
    --------
    >>> records = [IterationRecord(i, 1, 0.1 / i, 20.0, 0.01, float("nan"), 0.002 * i) for i in (1, 2, 3)]
    >>> history = CompactHistory(records)
    >>> len(history), history[-1] == records[-1], list(history) == records
    (3, True, True)
    """

    def __init__(self, records: Sequence[IterationRecord]) -> None:
        self._first = records[0]
        self._columns = {
            field.name: np.array([getattr(record, field.name) for record in records]) for field in fields(self._first)
        }

    def __len__(self) -> int:
        return len(self._columns["i"])

    @overload
    def __getitem__(self, place: int) -> IterationRecord: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[IterationRecord, ...]: ...
    def __getitem__(self, place: int | slice) -> IterationRecord | tuple[IterationRecord, ...]:
        return self._first if place == 0 else self.records()[place]

    def __repr__(self) -> str:
        return repr(self.records())

    def records(self) -> tuple[IterationRecord, ...]:
        """All records."""
        return _records(self)


@lru_cache(maxsize=_AT_HAND)
def _records(history: CompactHistory) -> tuple[IterationRecord, ...]:
    first, columns = history._first, history._columns
    values = [
        [tuple(row) for row in column.tolist()] if column.ndim > 1 else column.tolist() for column in columns.values()
    ]
    others = list(zip(*values, strict=True))[1:]
    return first, *(type(first)(**dict(zip(columns, row, strict=True))) for row in others)
