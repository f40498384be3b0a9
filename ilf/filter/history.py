"""All records of a block's iterations, in little memory."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

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
        self._columns: dict[str, NDArray[Any]] = {
            field.name: np.array([getattr(record, field.name) for record in records]) for field in fields(self._first)
        }

    @classmethod
    def of_columns(cls, kind: type[IterationRecord], columns: Mapping[str, NDArray[Any]]) -> Self:
        """Inverse of `columns`: records of a kind, one at least, each value from the array of its name.

        Examples
        --------
        >>> record = IterationRecord(1, 1, 0.1, 20.0, 0.01, float("nan"), 0.002)
        >>> history = CompactHistory([record])
        >>> CompactHistory.of_columns(history.kind, history.columns)[0] == record
        True
        """
        made = cls.__new__(cls)
        made._columns = dict(columns)
        made._first = kind(**dict(zip(columns, next(_rows(made._columns)), strict=True)))
        return made

    @property
    def kind(self) -> type[IterationRecord]:
        """What its records are."""
        return type(self._first)

    @property
    def columns(self) -> Mapping[str, NDArray[Any]]:
        """Name of a value -> that of every record, shape (N,), or (N, 2) for pairs; int64, float64 or bool."""
        return self._columns

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
    others = itertools.islice(_rows(columns), 1, None)
    return first, *(type(first)(**dict(zip(columns, row, strict=True))) for row in others)


def _rows(columns: Mapping[str, NDArray[Any]]) -> Iterator[tuple[Any, ...]]:
    values = [
        [tuple(row) for row in column.tolist()] if column.ndim > 1 else column.tolist() for column in columns.values()
    ]
    return zip(*values, strict=True)
