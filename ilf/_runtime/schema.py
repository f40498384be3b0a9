"""Values of JSON files, written by programs or people, as declared types: every value is checked when it is read."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import operator
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np

from ..errors import FormatError
from .installation import __version__


def check_schema(data: Mapping[str, Any], schema: int, what: str) -> None:
    """Raise FormatError unless a file has the supported schema.

    Parameters
    ----------
    data : mapping
        The object in the file; its `schema` is the number of the schema, its `version` that of the writing program.
    schema : int
        The supported number.
    what : str
        The kind of file, for the message.

    Examples
    --------
    >>> check_schema({"schema": 1}, 1, "preset")
    """
    found = data.get("schema")
    if type(found) is not int or found != schema:
        version = f" ({data['version']!s:.20})" if "version" in data else ""
        raise FormatError(
            f"The {what} has schema {json.dumps(plain(found)):.40}; ILF Studio {__version__} reads schema {schema} "
            f"only. Open it with the version that wrote it{version}."
        )


T = TypeVar("T")

PlainName = Annotated[str, msgspec.Meta(pattern=r"\A(?!\.{1,2}\Z)[^/\\\0]+\Z")]
"""A file name without any folder; see `is_plain`."""

_KINDS = {
    "float": "a number", "int": "an integer", "str": "text", "bool": "true or false", "array": "a list",
    "object": "an object",
}  # fmt: skip
"""Kind in messages of msgspec -> words for users."""

_KIND = re.compile(rf"\b({'|'.join(_KINDS)})\b")
_EXPECTED = re.compile(r"Expected (?P<wanted>.+?)(, got (?P<found>.+))?")


def converted(value: object, kind: type[T], what: str, place: str = "", *, strict: bool = True) -> T:
    """Convert a value of a JSON file to the type that declares it. Unknown keys are ignored.

    Parameters
    ----------
    value : object
        As parsed.
    kind : type
        Any type that msgspec supports; nothing in a bare `dict` or `list` is checked. Dataclasses need a value for
        every field, even for those with a default, unless it is NaN or their metadata say that they are optional;
        fields of a `msgspec.Struct` with a default are optional.
    what : str
        What the value is, or contains it at `place`, for the message.
    place : str
    strict : bool
        False accepts numbers and truth values that are written as text.

    Raises
    ------
    FormatError
        If a value is missing, of another type or not finite, or refused by the dataclass.

    Examples
    --------
    >>> converted([1, 2], tuple[float, float], "point")
    (1.0, 2.0)
    >>> converted({"at": [1, "2"]}, dict[str, tuple[float, float]], "plan")
    Traceback (most recent call last):
    ilf.errors.FormatError: '[...][1]' in the plan must be a number, not text.
    """
    try:
        made = msgspec.convert(value, kind, strict=strict, str_keys=True)
        if kind not in (dict, list):
            _check_complete(value, made, place, what)
    except msgspec.ValidationError as error:
        raise FormatError(_sentence(str(error), what, place)) from error
    except (RecursionError, UnicodeError) as error:
        raise FormatError(f"The {what} cannot be read ({error}).") from error
    return made


def _check_complete(value: object, made: object, place: str, what: str) -> None:
    """Raise FormatError if a field of a dataclass has no value, or a number is not finite."""
    parts: Iterable[tuple[str, object, object]] = ()
    if isinstance(value, dict) and dataclasses.is_dataclass(made):
        for field in dataclasses.fields(made):
            is_optional = field.default != field.default or field.metadata.get("optional", False)
            if field.name not in value and not is_optional:
                raise FormatError(f"The {what} has no {f'{place}.{field.name}'.lstrip('.')!r}.")
        names = [field.name for field in dataclasses.fields(made) if field.name in value]
        parts = ((f"{place}.{name}", value[name], getattr(made, name)) for name in names)
    elif isinstance(value, dict) and isinstance(made, msgspec.Struct):
        names = [name for name in made.__struct_fields__ if name in value]
        parts = ((f"{place}.{name}", value[name], getattr(made, name)) for name in names)
    elif isinstance(value, dict) and isinstance(made, dict):
        pairs = zip(value.items(), made.values(), strict=False)
        parts = ((f"{place}.{name}", part, made_part) for (name, part), made_part in pairs)
    elif isinstance(value, list) and isinstance(made, list | tuple):
        parts = ((f"{place}[{i}]", *pair) for i, pair in enumerate(zip(value, made, strict=False)))
    elif isinstance(made, float) and isinstance(value, float) and not math.isfinite(value):
        raise FormatError(f"{place.lstrip('.')!r} in the {what} must be a finite number, not {value}.")
    for where, part, made_part in parts:
        _check_complete(part, made_part, where, what)


def _sentence(message: str, what: str, outer: str) -> str:
    """Turn a message of msgspec, which ends with a path such as `$.a[2].b`, into a sentence."""
    problem, _, path = message.partition(" - at `")
    problem, place = problem.replace("`", ""), f"{outer}{path.rpartition('$')[2].rstrip('`')}".lstrip(".")
    subject = f"{place!r} in the {what}" if place else f"The {what}"
    if path.startswith("key"):
        subject = f"A name in {subject[0].lower()}{subject[1:]}"
    if missing := re.fullmatch(r"Object missing required field (.+)", problem):
        return f"The {what} has no {f'{place}.{missing[1]}'.lstrip('.')!r}."
    if not (expected := _EXPECTED.fullmatch(problem)):
        return f"{subject} is not valid: {problem.rstrip('.')}."
    wanted = "a plain file name" if "matching regex" in problem else expected["wanted"].replace(" | ", " or ")
    told = f"{wanted}{', not ' + expected['found'] if expected['found'] else ''}"
    return f"{subject} must be {_KIND.sub(lambda kind: _KINDS[kind[0]], told)}."


@dataclass(frozen=True)
class Section:
    """An object of a JSON file whose values are converted one by one, so that a damaged one costs only itself."""

    name: str
    values: dict[str, Any]

    def get(self, key: str, *kinds: Any) -> Any:
        """Return the value of a key, `converted` to one of these types."""
        if key not in self.values:
            raise FormatError(f"The {self.name} has no {key!r}.")
        kind: Any = functools.reduce(operator.or_, kinds)
        return converted(self.values[key], kind, self.name, key)

    def section(self, key: str) -> Section:
        """Return an object inside this one."""
        return Section(key, self.get(key, dict))


def is_plain(name: str) -> bool:
    """Whether a name is a file name without any folder."""
    return name not in {"", ".", ".."} and not any(mark in name for mark in "/\\\0")


# Conversion to strict JSON.

PROGRAM = "ilf-studio"


def json_file(schema: int, content: Mapping[str, Any]) -> bytes:
    """Return a JSON file of this program, with null for NaN: its schema, and the content."""
    return f"{json.dumps(plain({'program': PROGRAM, 'schema': schema, **content}), indent=2)}\n".encode()


def strict_json(value: object) -> bytes:
    """Return JSON without whitespace, with null for NaN."""
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False).encode()
    except (TypeError, ValueError):
        return json.dumps(plain(value), separators=(",", ":"), allow_nan=False).encode()


def plain(value: object) -> Any:
    """Convert a value to the nearest JSON value: null for non-finite numbers, text for unsupported types.

    Examples
    --------
    >>> plain({1: (2, float("nan")), "at": b"x"})
    {'1': [2, None], 'at': "b'x'"}
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, Sequence | set | frozenset) and not isinstance(value, bytes | bytearray):
        return [plain(part) for part in value]
    return plain(value.item()) if isinstance(value, np.generic) else str(value)
