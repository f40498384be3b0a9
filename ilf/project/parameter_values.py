"""Parameters from a project, which another version may have written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from ..declarations import ParameterSet, Value
from ..errors import ParameterError
from ..parameters import Parameters

Set = TypeVar("Set", bound=ParameterSet)


def parameters_from(kind: type[Set], values: Mapping[str, Any], what: str, problems: list[str]) -> Set:
    """A parameter set; where a name is unknown or a value does not do, the default is taken, and a sentence added.

    Examples
    --------
    >>> problems = []
    >>> parameters_from(Parameters, {"smoothness": 2, "sharpness": 1}, "The parameters", problems).smoothness
    2.0
    >>> problems
    ["The parameters: There is no parameter 'sharpness'. Did you mean smoothness? It is left out."]
    """
    try:
        return kind.from_dict(values)
    except (ParameterError, TypeError):  # one by one, then
        pass
    known = kind.declarations()
    usable = {}
    for name, value in values.items():
        try:
            kind().replace(**{name: value})
        except (ParameterError, TypeError) as error:
            problems.append(f"{what}: {error} {'The default is taken' if name in known else 'It is left out'}.")
            if name in known:
                usable[name] = known[name].default
        else:
            usable[name] = value
    return kind.from_dict(usable)


def own_values_from(values: Mapping[str, Any], what: str, problems: list[str]) -> dict[str, Value]:
    """Own values of a block, but for those that do not do."""
    parameters = Parameters()
    found = {}
    for name, value in values.items():
        try:
            found[name] = parameters.replace(**{name: value}).to_dict()[name]
        except (ParameterError, TypeError) as error:
            problems.append(f"{what}: {error} It is left out.")
    return found
