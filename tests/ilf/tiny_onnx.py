"""Tiny ONNX networks, written byte by byte: making one with a library would be a dependency for two tests."""

from __future__ import annotations

from pathlib import Path

INTEGER, INTEGERS = 2, 7
FLOAT = 1


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _message(field: int, content: bytes | str) -> bytes:
    raw = content.encode() if isinstance(content, str) else content
    return _varint(field << 3 | 2) + _varint(len(raw)) + raw


def _attribute(name: str, value: int | list[int]) -> bytes:
    if isinstance(value, int):
        return _message(1, name) + _number(3, value) + _number(20, INTEGER)
    return _message(1, name) + b"".join(_number(8, item) for item in value) + _number(20, INTEGERS)


def node(kind: str, inputs: list[str], output: str, **attributes: int | list[int]) -> bytes:
    """One operation of a graph."""
    return (
        b"".join(_message(1, name) for name in inputs)
        + _message(2, output)
        + _message(3, f"make {output}")
        + _message(4, kind)
        + b"".join(_message(5, _attribute(name, value)) for name, value in attributes.items())
    )


def _image(name: str, channels: int) -> bytes:
    dimensions = (_number(1, 1), _number(1, channels), _message(2, "height"), _message(2, "width"))
    shape = b"".join(_message(1, dimension) for dimension in dimensions)
    return _message(1, name) + _message(2, _message(1, _number(1, FLOAT) + _message(2, shape)))


def write_network(
    path: Path, nodes: list[bytes], inputs: dict[str, int] | None = None, outputs: dict[str, int] | None = None
) -> Path:
    """Write a network of these operations; `inputs` and `outputs` name images and their channels."""
    graph = b"".join(_message(1, one) for one in nodes) + _message(2, "tiny")
    graph += b"".join(_message(11, _image(*item)) for item in (inputs or {"image": 3}).items())
    graph += b"".join(_message(12, _image(*item)) for item in (outputs or {"strength": 1}).items())
    path.write_bytes(_number(1, 8) + _message(7, graph) + _message(8, _message(1, "") + _number(2, 17)))
    return path
