"""Values of the filter's parameters that blocks have of their own, in place of the common ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ..declarations import Value
from ..parameters import Parameters

OwnValues = Mapping[str, Value]
"""Parameter -> value."""


def own_values(parameters: Parameters, common: Parameters) -> OwnValues:
    """The values that a block with such parameters has in place of the common ones."""
    ours, values = parameters.to_dict(), common.to_dict()
    return {name: value for name, value in ours.items() if value != values[name]}


def differing(one: OwnValues, other: OwnValues) -> set[str]:
    """Names whose values differ, or that only one has."""
    return {name for name in {*one, *other} if name not in one or name not in other or one[name] != other[name]}


def parameter_labels(names: Iterable[str]) -> list[str]:
    """What parameters are called in the window."""
    declarations = Parameters.declarations()
    return [declarations[name].label for name in declarations if name in set(names)]
