"""Networks that check for cancellation between their convolutions, so that inference can be cancelled."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from ...errors import Cancelled
from ..cancellation import check_cancelled
from . import protobuf as wire

CHECK_INPUT = "ilf-asked"
"""Name of the unused input of one number that every check layer takes."""

_OPERATOR = "IlfQuestion"

# fields of the messages of ONNX
_GRAPH = 7
_NODE, _INITIALIZER, _INPUT = 1, 5, 11
_NODE_INPUT, _NODE_OUTPUT, _NODE_NAME, _NODE_OPERATOR, _NODE_DOMAIN = 1, 2, 3, 4, 7
_TENSOR_NAME = 8
_NAME, _TYPE = 1, 2

_ONE_NUMBER = wire.message(1, wire.integer(1, 1) + wire.message(2, wire.message(1, wire.integer(1, 1))))
"""ONNX's type of a tensor of one float."""


class _CancellationCheck:
    """A layer that checks for cancellation and returns its input.

    On cancellation it returns nothing, so that OpenCV ends the inference: an exception would leave OpenCV holding the
    interpreter's lock for good.
    """

    __slots__ = ()
    _SHAPES = ((1,),)

    def __init__(self, params: dict[str, cv2.dnn.DictValue], blobs: Sequence[MatLike]) -> None:
        """Take the arguments that OpenCV passes to layers."""

    def getMemoryShapes(self, inputs: Sequence[Sequence[int]]) -> Sequence[Sequence[int]]:
        return self._SHAPES

    def forward(self, inputs: Sequence[MatLike]) -> Sequence[MatLike]:
        try:
            check_cancelled()
        except Cancelled:
            return ()
        return inputs


cv2.dnn_registerLayer(_OPERATOR, _CancellationCheck)


def with_cancellation_checks(content: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Add a check layer before each convolution of an ONNX network, and one more input, `CHECK_INPUT`, of one number.

    Results are the same, bit for bit, with the same memory: no layer uses the output of a check, so that it keeps no
    OpenCV buffer, which may be of any size, from the next layer.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the network's file.

    Raises
    ------
    ValueError
        If it is not a protocol buffer.
    """
    parts = [bytes(span) for number, _, span in wire.spans(content.data) if number != _GRAPH]
    graph = wire.message(_GRAPH, b"".join(_with_checks(wire.joined(content.data, _GRAPH))))
    return np.frombuffer(b"".join((*parts, graph)), np.uint8)


def first_input(content: NDArray[np.uint8]) -> str:
    """Return the name of a network's first input, "" if it has none; raise ValueError as `with_cancellation_checks`
    does."""
    graph = wire.joined(content.data, _GRAPH)
    constant = {wire.text(tensor, _TENSOR_NAME) for tensor in wire.messages(graph, _INITIALIZER)}
    names = (wire.text(value, _NAME) for value in wire.messages(graph, _INPUT))
    return next((name for name in names if name not in constant), "")


def _with_checks(graph: memoryview) -> Iterator[bytes | memoryview]:
    """Yield the fields of a graph, with check layers inserted."""
    questions = 0
    for number, value, span in wire.spans(graph):
        is_convolution = (
            number == _NODE and isinstance(value, memoryview) and wire.text(value, _NODE_OPERATOR).startswith("Conv")
        )
        if is_convolution:
            yield _check_node(questions)
            questions += 1
        yield span
    yield wire.message(_INPUT, wire.message(_NAME, CHECK_INPUT) + wire.message(_TYPE, _ONE_NUMBER))


def _check_node(number: int) -> bytes:
    texts = {
        _NODE_INPUT: CHECK_INPUT,
        _NODE_OUTPUT: f"{CHECK_INPUT}-{number}",
        _NODE_NAME: f"ilf-question-{number}",
        _NODE_OPERATOR: _OPERATOR,
        _NODE_DOMAIN: "ilf",
    }
    node = b"".join(wire.message(field, text) for field, text in texts.items())
    return wire.message(_NODE, node)
