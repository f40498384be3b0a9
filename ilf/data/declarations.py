"""Declarations of parameters and options: name, range, unit, default, help and source of each in one place.

The form in the window, the flags of the command line, validation and every saved file use these
declarations; nothing about a parameter is defined anywhere else.
"""

from __future__ import annotations

import copy
import dataclasses
import inspect
import math
import textwrap
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import Any, Self, TypeVar

from .._runtime.formatting import as_float
from ..errors import ParameterError, did_you_mean

Value = bool | int | float | str

_LONGEST_TEXT = 100


@dataclass(frozen=True)
class Declaration:
    """Declaration of one parameter.

    Attributes
    ----------
    name : str
        Name in code.
    flag : str
        Name on the command line; "" for none.
    default : bool, int, float, str or tuple of str
        Its type is the parameter's type; of an `or_none`, a choice.
    label, help : str
        Texts for users; `help` is one or two sentences.
    group : str
        Heading of its group in forms.
    unit : str
        "" for none.
    minimum, maximum : float or None
        Inclusive range of a number.
    step : float
        Step of a spin box.
    choices : mapping
        The allowed values of a text parameter, of any of which a tuple consists; with what forms show for them.
    or_none : bool
        Whether None is allowed, too, for none of the choices.
    offers : callable or None
        Returns the values available at present, for a text parameter without `choices`. Other values are accepted,
        too: a value from another computer's file may be unavailable here, which is reported when it is used.
    special : str
        Meaning of the minimum if it is not a quantity ("auto").
    source : str
        Its origin: an equation or section of the paper, or the released code.
    scale : str
        "linear", or "log" for a slider with a logarithmic scale.
    basic : bool
        Whether it is among the few parameters that forms show first.
    when : tuple
        (name, value, ...) of another parameter, which must have one of these values for this one to have any effect;
        empty for always.
    needs : tuple of str
        What must be there for it, by names of its form in the window.
    """

    name: str
    flag: str
    default: Any
    label: str
    help: str
    group: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    step: float = 1.0
    choices: Mapping[str, Any] = field(default_factory=dict)
    or_none: bool = False
    offers: Callable[[], tuple[str, ...]] | None = None
    special: str = ""
    source: str = ""
    scale: str = "linear"
    basic: bool = False
    when: tuple[str, *tuple[Value, ...]] | tuple[()] = ()
    needs: tuple[str, ...] = ()

    @property
    def kind(self) -> type:
        """bool, int, float, str or tuple."""
        return str if self.or_none else type(self.default)

    def to_text(self, value: Any) -> str:
        """Format a value with its unit.

        Examples
        --------
        >>> from ilf.data.parameters import Parameters
        >>> noise = Parameters.declarations()["noise"]
        >>> noise.to_text(0.0), noise.to_text(0.004)
        ('auto', '0.004 m')
        """
        if self.special and value == self.minimum:
            return self.special
        number = f"{value:g}" if isinstance(value, float) else to_text(value)
        return f"{number} {self.unit}".strip()

    def checked(self, value: object) -> Any:
        """Return `value` in the parameter's type; raise ParameterError if it is of another type or out of range."""
        choices = tuple(self.choices)  # in which what no mapping takes can be looked up, too
        if self.kind is tuple:
            if isinstance(value, str) or not isinstance(value, Collection) or any(one not in choices for one in value):
                raise self._refusal(f"a list, any of {', '.join(choices)}", value)
            return tuple(dict.fromkeys(value))
        if self.or_none and value is None:
            return None
        if choices:
            if value not in choices:
                raise self._refusal(f"one of {', '.join(choices)}", value)
            return str(value)
        if self.kind is str:
            if not isinstance(value, str) or not 1 <= len(value) <= _LONGEST_TEXT:
                raise self._refusal(f"a text of 1 to {_LONGEST_TEXT} characters", value)
            return value
        if self.kind is bool:
            if not isinstance(value, bool):
                raise self._refusal("true or false", value)
            return value
        if isinstance(value, bool) or not hasattr(value, "__float__"):
            raise self._refusal("a number", value)
        number = as_float(value)
        if not math.isfinite(number) or (self.kind is int and number != int(number)):
            raise self._refusal("an integer" if self.kind is int else "a finite number", value)
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        if not low <= number <= high:
            between = f"{low:g} and {high:g} {self.unit}".rstrip()
            raise ParameterError(f"{self.name} must lie between {between}, not {number:g}.")
        return int(number) if self.kind is int else number

    def _refusal(self, wanted: str, value: object) -> ParameterError:
        return ParameterError(f"{self.name} must be {wanted}, not {value!r:.60}.")


def declare(default: Any, label: str, help: str, group: str, *, optional: bool = False, **details: Any) -> Any:
    """Return a dataclass field with what declares it as metadata; one that is `optional` may lack in files."""
    declared = {"default": default, "label": label, "help": help, "group": group, **details}
    if isinstance(choices := details.get("choices"), tuple):
        declared["choices"] = dict(zip(choices, choices, strict=True))
    return dataclasses.field(default=default, metadata={"declared": declared, "optional": optional})


@dataclass(frozen=True)
class ParameterSet:
    """Base of the parameter dataclasses: immutable plain data, checked on creation."""

    def __post_init__(self) -> None:
        for name, declaration in self.declarations().items():
            object.__setattr__(self, name, declaration.checked(getattr(self, name)))

    @classmethod
    @cache  # which forms and checks use often
    def declarations(cls) -> Mapping[str, Declaration]:
        """Return name -> Declaration, in the order of the form."""
        declared = {item.name: item.metadata["declared"] for item in dataclasses.fields(cls)}
        flags = {name: f"--{name.replace('_', '-')}" for name in declared}
        made = {name: Declaration(name, **{"flag": flags[name], **facts}) for name, facts in declared.items()}
        return MappingProxyType(made)

    def has_effect(self, name: str) -> bool:
        """Whether a parameter has any effect with the present values of the others."""
        return not self._unmet(name)

    def without_effect(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return a sentence for each of these parameters that has no effect with the present values, with the reason.

        Examples
        --------
        >>> from ilf.data.parameters import Parameters
        >>> Parameters(filter="edge-aware").without_effect(["padding", "smoothness"])
        ('padding has no effect with filter edge-aware; it belongs to filter ideal.',)
        """
        sentences = []
        for name in names:
            if condition := self._unmet(name):
                other, *values = condition
                present, wanted = to_text(getattr(self, other)), " or ".join(map(to_text, values))
                sentences.append(f"{name} has no effect with {other} {present}; it belongs to {other} {wanted}.")
        return tuple(sentences)

    def differences_from(self, other: Self) -> dict[str, Value]:
        """Return name -> value of the parameters whose values differ from another set.

        Examples
        --------
        >>> from ilf.data.parameters import Parameters
        >>> Parameters(smoothness=3).differences_from(Parameters())
        {'smoothness': 3.0}
        """
        others = other.to_dict()
        return {name: value for name, value in self.to_dict().items() if value != others[name]}

    def same_effect(self, other: Self) -> bool:
        """Whether two sets differ only in values that have no effect."""
        mine, others = vars(self), vars(other)
        return mine == others or all(
            mine[name] == others[name] or not self.has_effect(name) for name in self.declarations()
        )

    def _unmet(self, name: str) -> tuple[str, *tuple[Value, ...]] | tuple[()]:
        """Return the outermost unmet condition for a parameter to have any effect; empty if all are met."""
        known = self.declarations()
        unmet: tuple[str, *tuple[Value, ...]] | tuple[()] = ()
        condition = known[name].when
        while condition:
            other, *values = condition
            if getattr(self, other) not in values:
                unmet = condition
            condition = known[other].when
        return unmet

    def changed(self, /, **changes: object) -> Self:
        """Return a copy with values selected by the user, each of which must therefore have an effect.

        Raises
        ------
        ParameterError
            As `replace` does, and for parameters that have no effect with the resulting values.
        """
        result = self.replace(**changes)
        if sentences := result.without_effect(changes):
            raise ParameterError(" ".join(sentences))
        return result

    def replace(self, /, **changes: object) -> Self:
        """Return a copy with other values, whether or not they have any effect.

        Raises
        ------
        ParameterError
            For an unknown name (with the nearest known one) or a value out of range.
        """
        known = self.declarations()
        check_names(changes, known)
        made = copy.copy(self)
        for name, value in changes.items():
            object.__setattr__(made, name, known[name].checked(value))
        return made

    def to_dict(self) -> dict[str, Value]:
        """Return name -> value, ready for JSON."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, object]) -> Self:
        """Create a set from the result of `to_dict`; raise ParameterError as `replace` does, and for missing names."""
        if missing := [name for name in cls.declarations() if name not in values]:
            raise ParameterError(f"There is no value for {', '.join(missing)}.")
        return cls().replace(**values)


def check_names(given: Iterable[str], known: Collection[str]) -> None:
    """Raise ParameterError for the first unknown name, with the nearest known one.

    Examples
    --------
    >>> check_names(["granularty"], ["granularity", "dilation"])
    Traceback (most recent call last):
    ilf.errors.ParameterError: There is no parameter 'granularty'. Did you mean granularity?
    """
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known) or f" Known: {', '.join(known)}."
            raise ParameterError(f"There is no parameter {name!r}.{hint}")


Kind = TypeVar("Kind", bound=type[ParameterSet])


def with_documented_parameters(kind: Kind) -> Kind:
    """Add all declared parameters to the docstring of a parameter dataclass. Use it as a decorator above `dataclass`.

    Examples
    --------
    >>> from ilf.data.parameters import BlockParameters
    >>> print(BlockParameters.__doc__.split("depth_jump : ")[1].splitlines()[0])
    float, 0.001 to 5 m, default 0.04 m
    """
    text, heading, examples = inspect.cleandoc(kind.__doc__ or "").partition("\n\nExamples\n")
    lines = [text, "", "Parameters", "----------"]
    for declaration in kind.declarations().values():
        lines.append(f"{declaration.name} : {_range_and_default(declaration)}")
        lines += textwrap.wrap(declaration.help, 110, initial_indent="    ", subsequent_indent="    ")
    kind.__doc__ = "\n".join(lines) + heading + examples
    return kind


def _range_and_default(declaration: Declaration) -> str:
    default = declaration.default
    if declaration.choices:
        choices = f"{{{', '.join(map(repr, declaration.choices))}}}"
        several, none = "tuple of " * (declaration.kind is tuple), " or None" * declaration.or_none
        return f"{several}{choices}{none}, default {default!r}"
    if declaration.minimum is None or declaration.maximum is None:
        return f"{declaration.kind.__name__}, default {default!r}"
    special = f" ({declaration.minimum:g}: {declaration.special})" if declaration.special else ""
    between = f"{declaration.minimum:g} to {declaration.maximum:g} {declaration.unit}".rstrip()
    return f"{declaration.kind.__name__}, {between}{special}, default {declaration.to_text(default)}"


def to_text(value: object) -> str:
    """Format a value as text."""
    if value is None or isinstance(value, tuple):
        return ",".join(value or ()) or "none"
    return {True: "on", False: "off"}[value] if isinstance(value, bool) else str(value)
