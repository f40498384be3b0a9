"""Protocol buffers without a schema: the fields of a message as stored in the file."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5
_FIXED_SIZES = {_FIXED64: 8, _FIXED32: 4}

Field = int | memoryview


def fields(message: memoryview) -> Iterator[tuple[int, Field]]:
    """Yield the fields of a message.

    Parameters
    ----------
    message : memoryview of bytes

    Yields
    ------
    number : int
        Number of the field.
    value : int or memoryview
        An int for a varint; otherwise bytes, for strings, messages and fixed-size numbers.

    Raises
    ------
    ValueError
        If the message is truncated or invalid.
    """
    at = 0
    while at < len(message):
        key, at = _varint(message, at)
        number, kind = key >> 3, key & 7
        if kind == _VARINT:
            value, at = _varint(message, at)
            yield number, value
            continue
        if kind == _BYTES:
            size, at = _varint(message, at)
        elif kind in _FIXED_SIZES:
            size = _FIXED_SIZES[kind]
        else:
            raise ValueError("no protocol buffer")
        if number == 0 or at + size > len(message):
            raise ValueError("truncated")
        yield number, message[at : at + size]
        at += size


def values(message: memoryview, number: int) -> list[Field]:
    """Return the values of one field, which may be repeated; raise ValueError as `fields` does."""
    return [value for found, value in fields(message) if found == number]


def messages(message: memoryview, number: int) -> list[memoryview]:
    """Return the values of a field of messages or strings."""
    return [value for value in values(message, number) if isinstance(value, memoryview)]


def text(message: memoryview, number: int) -> str:
    """Return the text in a field, "" if the field is missing."""
    found = messages(message, number)
    return found[-1].tobytes().decode("utf-8", "replace") if found else ""


def integers(message: memoryview, number: int) -> list[int]:
    """Return the integers of a repeated field, packed or not."""
    found: list[int] = []
    for value in values(message, number):
        if isinstance(value, int):
            found.append(value)
            continue
        at = 0
        while at < len(value):
            one, at = _varint(value, at)
            found.append(one)
    return found


def _varint(message: memoryview, at: int) -> tuple[int, int]:
    """Return a varint and its end."""
    value = shift = 0
    while at < len(message) and shift < 70:
        byte = message[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value, at
        shift += 7
    raise ValueError("truncated")


# ONNX networks with external data: weights stored in other files.

# ONNX message -> its fields whose messages may contain tensors, and the kinds of these messages
_INSIDE = {
    "model": {7: "graph", 20: "training", 25: "function"},
    "training": {1: "graph", 2: "graph"},
    "function": {7: "node", 11: "attribute"},
    "graph": {1: "node", 5: "tensor", 15: "sparse tensor"},
    "node": {5: "attribute"},
    "attribute": {5: "tensor", 6: "graph", 10: "tensor", 11: "graph", 22: "sparse tensor", 23: "sparse tensor"},
    "sparse tensor": {1: "tensor", 2: "tensor"},
    "tensor": {},
}
_EXTERNAL_DATA, _DATA_LOCATION = 13, 14


def has_external_data(content: NDArray[np.uint8]) -> bool:
    """Whether a network reads weights from other files, including subgraphs and functions.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the file.

    Raises
    ------
    ValueError
        If it is not a protocol buffer.
    """
    waiting = [("model", content.data)]
    while waiting:
        kind, message = waiting.pop()
        inside = _INSIDE[kind]
        for number, value in fields(message):
            if kind == "tensor" and (number == _EXTERNAL_DATA or (number == _DATA_LOCATION and value)):
                return True
            if number in inside and isinstance(value, memoryview):
                waiting.append((inside[number], value))
    return False
