"""Checked access to objects of JSON files written by programs or people: every value is checked when it is read."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, get_args, get_type_hints

import numpy as np

from ..errors import FormatError
from .formatting import as_float
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


@dataclass(frozen=True)
class Section:
    """An object of a JSON file, with clear messages for invalid values."""

    name: str
    values: dict[str, Any]

    def get(self, key: str, *kinds: type) -> Any:
        """Return the value of a key, checked to be of one of these types."""
        if key not in self.values:
            raise FormatError(f"The {self.name} has no {key!r}.")
        return _checked(self.values[key], kinds, f"{key!r} in the {self.name}")

    def items(self, key: str, kind: type) -> list[Any]:
        """Return a list of values of one type."""
        return [_checked(value, (kind,), f"{key!r} in the {self.name}") for value in self.get(key, list)]

    def texts(self, key: str, *kinds: type) -> dict[str, Any]:
        """Return an object whose values are strings, or of these other types."""
        section = self.section(key)
        return {name: section.get(name, str, *kinds) for name in section.values}

    def filename(self, key: str) -> str | None:
        """Return a plain file name, or None for null."""
        name = self.get(key, str, type(None))
        if name is not None and not is_plain(name):
            raise FormatError(f"{key!r} in the {self.name} must be a plain file name, not {name!r:.60}.")
        return name

    def fields(self, kind: type) -> dict[str, Any]:
        """Return values for the fields of a dataclass, each of its declared type."""
        types = get_type_hints(kind)
        found: dict[str, Any] = {}
        for field in dataclasses.fields(kind):
            declared = types[field.name]
            if isinstance(declared, type) and issubclass(declared, StrEnum):
                found[field.name] = self._member(field.name, declared)
            else:
                found[field.name] = self.get(field.name, *(get_args(declared) or (declared,)))
        return found

    def _member(self, key: str, kind: type[StrEnum]) -> StrEnum:
        value = self.get(key, str)
        if value not in list(kind):
            raise FormatError(f"{key!r} in the {self.name} must be {' or '.join(kind)}, not {value!r:.60}.")
        return kind(value)

    def section(self, key: str) -> Section:
        """Return an object inside this one."""
        return Section(key, self.get(key, dict))


def _checked(value: Any, kinds: tuple[type, ...], what: str) -> Any:
    """Return `value` if it is of one of these types: integers pass as float, true and false never as numbers."""
    if float in kinds and type(value) is int:
        value = as_float(value)
    if type(value) in kinds and not (type(value) is float and not math.isfinite(value)):
        return value
    wanted = " or ".join("null" if kind is type(None) else kind.__name__ for kind in kinds)
    raise FormatError(f"{what} must be {wanted}, not {value!r:.60}.")


def is_plain(name: str) -> bool:
    """Whether a name is a file name without any folder."""
    return name not in {"", ".", ".."} and not any(mark in name for mark in "/\\\0")


# Conversion to strict JSON.


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
