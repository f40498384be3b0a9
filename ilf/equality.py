"""Equality of records that may hold NaN."""

from __future__ import annotations

import dataclasses
from typing import Any


class NanEqual:
    """Base of dataclasses, made with eq=False, in which NaN, the lack of a number, equals NaN."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return _values(self) == _values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(_values(self))


def _values(record: Any) -> tuple[object, ...]:
    """A record's values, None for NaN."""
    values = (getattr(record, field.name) for field in dataclasses.fields(record))
    return tuple(None if value != value else value for value in values)
