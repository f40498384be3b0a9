"""Networks that ask between their convolutions whether the work goes on: a look at a frame can be stopped."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from ...errors import Cancelled
from ..cancellation import check_stopped
from . import protobuf as wire

ASKED = "ilf-asked"
"""Name of the input of one number that every question takes, and that says nothing."""

_OPERATOR = "IlfQuestion"

# fields of the messages of ONNX
_GRAPH = 7
_NODE, _INITIALIZER, _INPUT = 1, 5, 11
_NODE_INPUT, _NODE_OUTPUT, _NODE_NAME, _NODE_OPERATOR, _NODE_DOMAIN = 1, 2, 3, 4, 7
_TENSOR_NAME = 8
_NAME, _TYPE = 1, 2

_ONE_NUMBER = wire.message(1, wire.integer(1, 1) + wire.message(2, wire.message(1, wire.integer(1, 1))))
"""ONNX's type of a tensor of one float."""


class _Question:
    """A layer that stands between others and gives what it takes.

    To stop, it gives nothing at all, which OpenCV ends the look for: an exception would leave OpenCV with the
    interpreter's lock held, for good.
    """

    __slots__ = ()
    _SHAPES = ((1,),)

    def __init__(self, params: dict[str, cv2.dnn.DictValue], blobs: Sequence[MatLike]) -> None:
        """As OpenCV makes layers."""

    def getMemoryShapes(self, inputs: Sequence[Sequence[int]]) -> Sequence[Sequence[int]]:
        return self._SHAPES

    def forward(self, inputs: Sequence[MatLike]) -> Sequence[MatLike]:
        try:
            check_stopped()
        except Cancelled:
            return ()
        return inputs


cv2.dnn_registerLayer(_OPERATOR, _Question)


def with_questions(content: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An ONNX network with a question before each convolution, and one more input, `ASKED`, of one number.

    It gives the same, bit for bit, in the same memory: nobody takes what a question gives, so that it keeps none of
    OpenCV's buffers, which are of any size, from the next layer.

    Parameters
    ----------
    content : ndarray of uint8
        Of the network's file.

    Raises
    ------
    ValueError
        If it is no protocol buffer.
    """
    parts = [bytes(span) for number, _, span in wire.spans(content.data) if number != _GRAPH]
    graph = wire.message(_GRAPH, b"".join(_asking(wire.joined(content.data, _GRAPH))))
    return np.frombuffer(b"".join((*parts, graph)), np.uint8)


def first_input(content: NDArray[np.uint8]) -> str:
    """Name of a network's first input, "" if it has none; raises ValueError as `with_questions` does."""
    graph = wire.joined(content.data, _GRAPH)
    constant = {wire.text(tensor, _TENSOR_NAME) for tensor in wire.messages(graph, _INITIALIZER)}
    names = (wire.text(value, _NAME) for value in wire.messages(graph, _INPUT))
    return next((name for name in names if name not in constant), "")


def _asking(graph: memoryview) -> Iterator[bytes | memoryview]:
    """The fields of a graph, with questions."""
    questions = 0
    for number, value, span in wire.spans(graph):
        is_convolution = (
            number == _NODE and isinstance(value, memoryview) and wire.text(value, _NODE_OPERATOR).startswith("Conv")
        )
        if is_convolution:
            yield _question(questions)
            questions += 1
        yield span
    yield wire.message(_INPUT, wire.message(_NAME, ASKED) + wire.message(_TYPE, _ONE_NUMBER))


def _question(number: int) -> bytes:
    texts = {
        _NODE_INPUT: ASKED,
        _NODE_OUTPUT: f"{ASKED}-{number}",
        _NODE_NAME: f"ilf-question-{number}",
        _NODE_OPERATOR: _OPERATOR,
        _NODE_DOMAIN: "ilf",
    }
    node = b"".join(wire.message(field, text) for field, text in texts.items())
    return wire.message(_NODE, node)
