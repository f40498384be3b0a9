"""ONNX networks that name other files: weights outside the file itself, wherever they lead."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import wire

# message of ONNX -> its fields that hold messages in which there may be tensors, and what these are
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
    """Whether a network takes weights from other files, in subgraphs and functions too.

    Parameters
    ----------
    content : ndarray of uint8
        Of the file.

    Raises
    ------
    ValueError
        If it is no protocol buffer.
    """
    waiting = [("model", content.data)]
    while waiting:
        kind, message = waiting.pop()
        inside = _INSIDE[kind]
        for number, value in wire.fields(message):
            if kind == "tensor" and (number == _EXTERNAL_DATA or (number == _DATA_LOCATION and value)):
                return True
            if number in inside and isinstance(value, memoryview):
                waiting.append((inside[number], value))
    return False
