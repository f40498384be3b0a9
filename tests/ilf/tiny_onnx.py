"""Tiny ONNX networks, written byte by byte: what no library would write, too, and nothing of onnx to install."""

import hashlib
from pathlib import Path

from ilf._runtime.networks import network

_bundled = set(network._bundled())
network._bundled = lambda: _bundled

INTEGER, INTEGERS = 2, 7
FLOAT = 1
_VARINT, _BYTES = 0, 2


def message(field: int, content: bytes | str) -> bytes:
    """Encode a field with a message or a text."""
    raw = content.encode() if isinstance(content, str) else content
    return _as_varint(field << 3 | _BYTES) + _as_varint(len(raw)) + raw


def number(field: int, value: int) -> bytes:
    """Encode a field with a non-negative integer."""
    return _as_varint(field << 3 | _VARINT) + _as_varint(value)


def _as_varint(value: int) -> bytes:
    groups = []
    while value > 0x7F:
        groups.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes((*groups, value))


def _attribute(name: str, value: int | list[int]) -> bytes:
    if isinstance(value, int):
        return message(1, name) + number(3, value) + number(20, INTEGER)
    return message(1, name) + b"".join(number(8, item) for item in value) + number(20, INTEGERS)


def node(kind: str, inputs: list[str], output: str, **attributes: int | list[int]) -> bytes:
    """One operation of a graph."""
    return (
        b"".join(message(1, name) for name in inputs)
        + message(2, output)
        + message(3, f"make {output}")
        + message(4, kind)
        + b"".join(message(5, _attribute(name, value)) for name, value in attributes.items())
    )


def _image(name: str, channels: int) -> bytes:
    dimensions = (number(1, 1), number(1, channels), message(2, "height"), message(2, "width"))
    shape = b"".join(message(1, dimension) for dimension in dimensions)
    return message(1, name) + message(2, message(1, number(1, FLOAT) + message(2, shape)))


def write_network(
    path: Path,
    nodes: list[bytes],
    inputs: dict[str, int] | None = None,
    outputs: dict[str, int] | None = None,
    weights: bytes = b"",
) -> Path:
    """Write a network of these operations, which counts as bundled, so that no child tries it first; `inputs` and
    `outputs` name images and channels, `weights` is a tensor of the graph."""
    graph = b"".join(message(1, one) for one in nodes) + message(2, "tiny")
    graph += message(5, weights) if weights else b""
    graph += b"".join(message(11, _image(*item)) for item in (inputs or {"image": 3}).items())
    graph += b"".join(message(12, _image(*item)) for item in (outputs or {"strength": 1}).items())
    content = number(1, 8) + message(7, graph) + message(8, message(1, "") + number(2, 17))
    path.write_bytes(content)
    _bundled.add(hashlib.sha256(content).hexdigest())
    return path
