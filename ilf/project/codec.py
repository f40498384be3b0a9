"""The codec of states: any value of the data types as JSON, with its arrays beside it.

No field is listed by its name: a new field of a data type is written and read as its type hint says. What cannot be
plain has a hook: arrays, parameters, iteration records, and, in a frame's state, frames and results (`state_codec`).
"""

from __future__ import annotations

import dataclasses
import datetime
import hashlib
import io
import json
import math
import typing
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Set
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

from .._runtime.arrays import frozen
from .._runtime.files import parse_json, zip_member
from .._runtime.schema import converted
from ..data.declarations import ParameterSet
from ..data.results import EdgeAwareRecord, IterationRecord, PassBandRecord
from ..errors import FormatError, IlfError

UNREADABLE = (
    IlfError,
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    RecursionError,
    RuntimeError,
    TypeError,
    ValueError,
    zipfile.BadZipFile,
    zlib.error,
)
"""Exceptions of reading damaged or foreign data."""

Write = Callable[[Any], Any]
"""A hook: makes JSON of a value."""
Read = Callable[[Any, Any], Any]
"""A hook: makes a value of JSON and the type that is stated for it."""

_RECORDS = {kind.__name__: kind for kind in (IterationRecord, EdgeAwareRecord, PassBandRecord)}
_NOT_FINITE = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


@cache
def stored_fields(kind: type) -> Mapping[str, Any]:
    """Return the stored fields of a dataclass or named tuple, with their types."""
    hints = typing.get_type_hints(kind, include_extras=True)
    if not dataclasses.is_dataclass(kind):
        return {name: hints[name] for name in kind._fields}  # type: ignore[attr-defined]
    return {
        field.name: hints[field.name]
        for field in dataclasses.fields(kind)
        if field.init and not field.name.startswith("_") and field.metadata.get("stored", True)
    }


def to_plain(value: Any, hooks: Mapping[type, Write]) -> Any:
    """Convert a value to JSON values.

    Parameters
    ----------
    value : object
        Of data types, mappings, sequences, sets, arrays and plain values.
    hooks : mapping of type to callable
        For values of these types and of types derived from them.
    """
    if value is None or isinstance(value, bool | int | str):
        return value.value if isinstance(value, Enum) else value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, np.generic):
        return to_plain(value.item(), hooks)
    for kind, hook in hooks.items():
        if isinstance(value, kind):
            return hook(value)
    if isinstance(value, ParameterSet):
        return value.to_dict()
    if isinstance(value, slice):
        return [int(value.start), int(value.stop)]
    if isinstance(value, datetime.datetime):
        return value.isoformat()
    if isinstance(value, Mapping):
        return {str(key): to_plain(part, hooks) for key, part in value.items()}
    if isinstance(value, Set):
        return {"set": [to_plain(part, hooks) for part in sorted(value)]}
    if dataclasses.is_dataclass(value) or hasattr(value, "_fields"):
        record: Any = type(value)
        return {name: to_plain(getattr(value, name), hooks) for name in stored_fields(record)}
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        if value and isinstance(value[0], IterationRecord):
            return {type(value[0]).__name__: to_plain(_columns(value), hooks)}
        return [to_plain(part, hooks) for part in value]
    raise TypeError(f"a {type(value).__name__} cannot be stored")


def from_plain(data: Any, kind: Any, hooks: Mapping[type, Read]) -> Any:
    """Inverse of `to_plain` for a value of a stated type; the hooks are those of exactly these types.

    Raises
    ------
    FormatError
        If anything is missing, unknown or of another type.
    """
    kind = _behind_alias(kind)
    origin, args = get_origin(kind) or kind, get_args(kind)
    if origin in hooks:
        return hooks[origin](data, kind)
    if origin is Any:
        return data
    if origin in (Union, UnionType):
        return _one_of(data, args, hooks)
    if kind == Sequence[IterationRecord]:
        return _history(data, hooks)
    if isinstance(origin, type):
        if issubclass(origin, ParameterSet):
            return origin.from_dict(_as(data, dict))
        if dataclasses.is_dataclass(origin) or hasattr(origin, "_fields"):
            return _record(data, origin, hooks)
        if origin is slice:
            return slice(*converted(data, tuple[int, int], "state"))
        if issubclass(origin, Mapping):
            return {_key(key, args[0]): from_plain(part, args[1], hooks) for key, part in _as(data, dict).items()}
        if issubclass(origin, Set) or (origin is Collection and isinstance(data, dict)):
            return frozenset(from_plain(part, args[0], hooks) for part in _as(_as(data, dict)["set"], list))
        if issubclass(origin, tuple) and args[1:] != (...,):
            if len(_as(data, list)) != len(args):
                raise FormatError(f"There are {len(data)} values instead of {len(args)}.")
            return tuple(from_plain(part, of, hooks) for part, of in zip(data, args, strict=True))
        if issubclass(origin, Collection) and not issubclass(origin, str):
            return tuple(from_plain(part, args[0], hooks) for part in _as(data, list))
    if origin is float and isinstance(data, str) and data in _NOT_FINITE:
        return _NOT_FINITE[data]
    return converted(data, kind, "state")


def _behind_alias(kind: Any) -> Any:
    """The type that an alias stands for, as `NDArray[X]` is one since NumPy 2.5; any other type is itself."""
    stands_for = getattr(get_origin(kind), "__value__", None)
    return kind if stands_for is None else stands_for[get_args(kind)]


def _record(data: Any, kind: type, hooks: Mapping[type, Read]) -> Any:
    stated = stored_fields(kind)
    if _as(data, dict).keys() != stated.keys():
        raise FormatError(f"Of a {kind.__name__}, {', '.join(sorted(data.keys() ^ stated.keys())):.80} do not fit.")
    return kind(**{name: from_plain(data[name], of, hooks) for name, of in stated.items()})


def _one_of(data: Any, kinds: Iterable[Any], hooks: Mapping[type, Read]) -> Any:
    """Read a value of one of several types; plain values as they are."""
    if data is None or type(data) in kinds:
        if type(data) in kinds:
            return data
        raise FormatError("A value is missing.")
    problem: Exception = FormatError("A value has another type.")
    for kind in kinds:
        if kind is not NoneType:
            try:
                return from_plain(data, kind, hooks)
            except UNREADABLE as error:
                problem = error
    raise problem


def _columns(records: Sequence[IterationRecord]) -> dict[str, NDArray[Any]]:
    """Name of a value -> values of all records."""
    kind: type = type(records[0])
    return {name: np.array([getattr(record, name) for record in records]) for name in stored_fields(kind)}


def _history(data: Any, hooks: Mapping[type, Read]) -> Sequence[IterationRecord]:
    if data == []:
        return ()
    ((name, stored),) = _as(data, dict).items()
    columns = {key: from_plain(part, NDArray[Any], hooks) for key, part in _as(stored, dict).items()}
    kind, lengths = _RECORDS[name], {len(column) for column in columns.values()}
    if columns.keys() != stored_fields(kind).keys() or len(lengths) != 1 or 0 in lengths:
        raise FormatError("The records of iterations do not fit each other.")
    values = [map(tuple, column.tolist()) if column.ndim > 1 else column.tolist() for column in columns.values()]
    return tuple(kind(**dict(zip(columns, row, strict=True))) for row in zip(*values, strict=True))


def _key(key: str, kind: Any) -> Any:
    return int(key) if (get_args(kind)[0] if get_origin(kind) is Annotated else kind) is int else key


def _as(data: Any, kind: type) -> Any:
    if not isinstance(data, kind):
        raise FormatError(f"There is a {type(data).__name__} instead of a {kind.__name__}.")
    return data


# Parts: a value with its arrays as a zip; small arrays stand in the JSON.

ARRAYS = "arrays/"
MAX_UNPACKED = 2**29
"""Maximum size of the arrays of a part [bytes]."""
_VALUES = "values.json"
_INLINE = 64
"""Number of values up to which an array stands in the JSON."""
_DTYPES = ("bool", "uint8", "uint16", "uint32", "int32", "int64", "float32", "float64")
_FAST = 1


def inline(array: NDArray[Any]) -> Any | None:
    """Return a small array as JSON; None for another one."""
    if not 0 < array.size <= _INLINE:
        return None
    return [array.dtype.name, to_plain(array.tolist(), {})]


def pack(value: Any) -> tuple[str, bytes]:
    """Encode a value with its arrays as a part; return its name, which contains the hash of its content, and this."""
    columns: dict[str, list[NDArray[Any]]] = {}

    def add(array: NDArray[Any]) -> Any:
        if (small := inline(array)) is not None:
            return small
        stored = _narrow(array)
        before = columns.setdefault(stored.dtype.name, [])
        before.append(np.ascontiguousarray(stored))
        return [array.dtype.name, stored.dtype.name, sum(one.size for one in before[:-1]), list(array.shape)]

    values = json.dumps(to_plain(value, {np.ndarray: add}), separators=(",", ":"))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=_FAST) as packed:
        packed.writestr(_entry(_VALUES), values, compresslevel=_FAST)
        for dtype, arrays in columns.items():
            flat = np.concatenate([array.reshape(-1) for array in arrays]).view(np.uint8)
            packed.writestr(_entry(dtype), flat.data, compresslevel=_FAST)
    content = buffer.getvalue()
    return _name_of(content), content


def _name_of(content: bytes) -> str:
    return f"{ARRAYS}{hashlib.sha256(content).hexdigest()}.zip"


def check_content(name: str, content: bytes) -> None:
    """Raise FormatError if the content of a part does not match the hash in its name."""
    if _name_of(content) != name:
        raise FormatError(f"The part {name[:24]}... is damaged: its content does not match its name.")


def _narrow(array: NDArray[Any]) -> NDArray[Any]:
    """Return numbers of a label map or the like, which are small, in a smaller type that holds them."""
    if array.dtype.kind != "i" or array.min(initial=0) < 0:
        return array
    kind = np.min_scalar_type(array.max(initial=0))
    return array.astype(kind) if np.can_cast(kind, array.dtype, "safe") else array


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name)  # with a fixed date, so that equal values have equal content
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def unpack(name: str, content: bytes, kind: Any) -> Any:
    """Inverse of `pack` for a value of a stated type; arrays are read-only.

    Raises
    ------
    FormatError
        If the part is damaged, or contains something else; or another of `UNREADABLE`.
    """
    check_content(name, content)
    with zipfile.ZipFile(io.BytesIO(content)) as packed:
        if sum(entry.file_size for entry in packed.infolist()) > MAX_UNPACKED:
            raise FormatError(f"The part {name[:24]}... is too large.")
        read = {entry.filename: zip_member(packed, entry, MAX_UNPACKED) for entry in packed.infolist()}

    def array(data: Any, hint: Any) -> NDArray[Any]:
        if len(data) == 2:
            return small_array(data, hint)
        dtype, stored, start, shape = converted(data, tuple[str, str, int, tuple[int, ...]], "array")
        if start < 0 or min(shape, default=0) < 0:
            raise FormatError("An array is not valid.")
        flat = np.frombuffer(read[stored], _dtype(stored))
        if start + math.prod(shape) > flat.size:
            raise FormatError("An array is truncated.")
        return _of_type(flat[start : start + math.prod(shape)].reshape(shape), _dtype(dtype), hint)

    return from_plain(parse_json(read[_VALUES], "The part"), kind, {np.ndarray: array})


def small_array(data: Any, hint: Any) -> NDArray[Any]:
    """Inverse of `inline`."""
    dtype, values = data
    return _of_type(np.array(values, _dtype(dtype)), _dtype(dtype), hint)


def _dtype(name: str) -> np.dtype[Any]:
    if name not in _DTYPES:
        raise FormatError("An array has an unknown type.")
    return np.dtype(name)


def _of_type(array: NDArray[Any], dtype: np.dtype[Any], hint: Any) -> NDArray[Any]:
    """Return a read-only copy of the type that it had, which must be the stated one."""
    stated = get_args(get_args(hint)[1])[0]
    if stated is not Any and dtype != np.dtype(stated):
        raise FormatError(f"There are values of {dtype} instead of {np.dtype(stated)}.")
    return frozen(array.astype(dtype))
