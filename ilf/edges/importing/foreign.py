"""ONNX networks of other origin: what they take, and nodes around them for what they take and give otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from .. import wire
from .normalisation import normalisation

if TYPE_CHECKING:
    from onnx import ModelProto

_GRAPH = 7
_INITIALISERS, _INITIALISER_NAME = 5, 8
_OUTPUTS = 12
_INPUTS, _NAME, _TYPE, _TENSOR, _SHAPE, _DIMENSION, _SIZE = 11, 1, 2, 1, 2, 1, 1


class Input(NamedTuple):
    """An input that a network declares."""

    name: str
    shape: tuple[int | None, ...]
    """None where the size is free."""

    @property
    def fixed_size(self) -> str:
        """Size of the one kind of image that it takes, "" if that is free."""
        height, width = self.shape[2:] if len(self.shape) == 4 else (None, None)
        return f"{width} x {height}" if height and width else ""


def image_input(content: NDArray[np.uint8], file: str) -> Input:
    """The one input of an ONNX network; needs no package for ONNX.

    Parameters
    ----------
    content : ndarray of uint8
        Of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    FormatError
        If it is no ONNX file, or the network has another number of inputs.
    """
    try:
        graphs = wire.messages(content.data, _GRAPH)
        inputs = [found for graph in graphs for found in _inputs(graph)]
        outputs = [found for graph in graphs for found in wire.messages(graph, _OUTPUTS)]
    except ValueError as error:
        raise _not_intact(file, error) from error
    if not inputs or not outputs:
        raise FormatError(f"{file} is no ONNX network: it has no input or no output. Export or copy it again.")
    if len(inputs) > 1:
        names = ", ".join(one.name for one in inputs)
        raise FormatError(
            f"{file} is no edge network as needed here: it takes {len(inputs)} inputs ({names}), not one image. "
            "Export it with the image as its only input."
        )
    return inputs[0]


def with_input(content: NDArray[np.uint8], file: str, inputs: str) -> NDArray[np.uint8]:
    """An ONNX network of one input with a node before it, so that it takes RGB in [0, 1].

    Parameters
    ----------
    content : ndarray of uint8
        Of the file.
    file : str
        Its name, for the message.
    inputs : str
        What the network takes: one of `INPUTS`.

    Returns
    -------
    ndarray of uint8
        The content of the new file.

    Raises
    ------
    FormatError
        If it is no ONNX file.
    """
    from onnx import helper, numpy_helper

    model = _loaded(content, file)
    graph = model.graph
    constants = {item.name for item in graph.initializer}
    image = next(item for item in graph.input if item.name not in constants)
    names = ("ilf_weight", "ilf_bias")
    graph.initializer.extend(map(numpy_helper.from_array, normalisation(inputs), names))
    graph.node.insert(0, helper.make_node("Conv", ["ilf_image", *names], [image.name], kernel_shape=[1, 1]))
    image.name = "ilf_image"
    return np.frombuffer(model.SerializeToString(), np.uint8)


def with_sigmoid(content: NDArray[np.uint8], file: str) -> NDArray[np.uint8]:
    """An ONNX network with a sigmoid after its last output, which becomes the only one; otherwise as `with_input`."""
    from onnx import helper

    model = _loaded(content, file)
    graph = model.graph
    last = graph.output[-1]
    graph.node.append(helper.make_node("Sigmoid", [last.name], ["ilf_strength"]))
    last.name = "ilf_strength"
    del graph.output[:-1]
    return np.frombuffer(model.SerializeToString(), np.uint8)


def _loaded(content: NDArray[np.uint8], file: str) -> ModelProto:
    import onnx
    from google.protobuf.message import DecodeError

    try:
        return onnx.load_from_string(content.tobytes())
    except DecodeError as error:
        raise _not_intact(file, error) from error


def _not_intact(file: str, error: Exception) -> FormatError:
    return FormatError(f"{file} is no intact ONNX file ({error}). Export or copy it again.")


def _inputs(graph: memoryview) -> list[Input]:
    """Without those that only give the weights their names, as files of old do."""
    constants = {wire.text(tensor, _INITIALISER_NAME) for tensor in wire.messages(graph, _INITIALISERS)}
    found = [Input(wire.text(item, _NAME), _shape(item)) for item in wire.messages(graph, _INPUTS)]
    return [one for one in found if one.name not in constants]


def _shape(item: memoryview) -> tuple[int | None, ...]:
    for number in (_TYPE, _TENSOR, _SHAPE):
        inner = wire.messages(item, number)
        if not inner:
            return ()
        item = inner[-1]
    sizes = [wire.integers(dimension, _SIZE) for dimension in wire.messages(item, _DIMENSION)]
    return tuple(size[-1] if size and size[-1] > 0 else None for size in sizes)
