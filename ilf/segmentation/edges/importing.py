"""Importing a user's edge network: HED's weights, or any ONNX network from one image to its edges."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_file
from ..._runtime.installation import optional
from ..._runtime.networks import protobuf as wire
from ..._runtime.networks.models import name_from, new_model_path
from ..._runtime.writing import ensure_folder, write_bytes
from ...errors import FormatError, InputError, told_as
from . import hed
from .detectors import EdgeNetwork, OutputRangeError

if TYPE_CHECKING:
    from onnx import GraphProto, ValueInfoProto

# ONNX networks of other origin: reading their inputs, and adding nodes to adapt input and output.

_GRAPH = 7
_INITIALISERS, _INITIALISER_NAME = 5, 8
_OUTPUTS = 12
_INPUTS, _NAME, _TYPE, _TENSOR, _SHAPE, _DIMENSION, _SIZE = 11, 1, 2, 1, 2, 1, 1


def _fixed_size(content: NDArray[np.uint8], file: str) -> str:
    """The image size that an ONNX network requires, "" if it is free; does not need the package onnx.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    FormatError
        If it is not an ONNX file, or the network has another number of inputs.
    """
    with _intact(file, ValueError):
        graphs = wire.messages(content.data, _GRAPH)
        inputs = {name: shape for graph in graphs for name, shape in _inputs(graph).items()}
        outputs = [found for graph in graphs for found in wire.messages(graph, _OUTPUTS)]
    if not inputs or not outputs:
        raise FormatError(f"{file} is not an ONNX network: it has no input or no output. Export or copy it again.")
    if len(inputs) > 1:
        raise FormatError(f"{file} has {len(inputs)} inputs, not one image. Export it with the image as only input.")
    (shape,) = inputs.values()
    height, width = shape[2:] if len(shape) == 4 else (None, None)
    return f"{width} x {height}" if height and width else ""


def _edited(content: NDArray[np.uint8], file: str, edit: Callable[..., None], *how: str) -> NDArray[np.uint8]:
    """The content of an ONNX network whose graph and image input are edited; raises FormatError if it is no ONNX file.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the file.
    file : str
        Its name, for the message.
    edit : callable
        Is called with the graph, its image input and `how`, and changes them.
    """
    onnx = optional(*hed.ONNX_PACKAGE)
    from google.protobuf.message import DecodeError

    with _intact(file, DecodeError):
        model = onnx.load_from_string(content.tobytes())
    constants = {item.name for item in model.graph.initializer}
    edit(model.graph, next(item for item in model.graph.input if item.name not in constants), *how)
    return np.frombuffer(model.SerializeToString(), np.uint8)


def _add_normalisation(graph: GraphProto, image: ValueInfoProto, inputs: str) -> None:
    """Add a node before the input, one of `INPUTS`, so that the network accepts RGB in [0, 1]."""
    from onnx import helper, numpy_helper

    names = ("ilf_weight", "ilf_bias")
    graph.initializer.extend(map(numpy_helper.from_array, hed.normalisation(inputs), names))
    graph.node.insert(0, helper.make_node("Conv", ["ilf_image", *names], [image.name], kernel_shape=[1, 1]))
    image.name = "ilf_image"


def _add_sigmoid(graph: GraphProto, image: ValueInfoProto) -> None:
    """Add a sigmoid after the last output, which becomes the only one."""
    from onnx import helper

    last = graph.output[-1]
    graph.node.append(helper.make_node("Sigmoid", [last.name], ["ilf_strength"]))
    last.name = "ilf_strength"
    del graph.output[:-1]


def _free_size(graph: GraphProto, image: ValueInfoProto) -> None:
    """Let the network take images of any size, whatever size it was exported with."""
    for side, name in zip(image.type.tensor_type.shape.dim[2:], ("height", "width"), strict=True):
        side.dim_param = name
    # sizes of results follow from it
    del graph.value_info[:]
    for output in graph.output:
        output.type.tensor_type.ClearField("shape")


def _intact(file: str, problem: type[Exception]) -> AbstractContextManager[None]:
    """Within the block, an error of this type says that a file is damaged."""
    return told_as(FormatError, f"{file} is not an intact ONNX file ({{error}}). Export or copy it again.", problem)


def _inputs(graph: memoryview) -> dict[str, tuple[int | None, ...]]:
    """The inputs of a graph with their shapes (None where a size is free), without initialisers, which old files list
    as inputs."""
    constants = {wire.text(tensor, _INITIALISER_NAME) for tensor in wire.messages(graph, _INITIALISERS)}
    found = {wire.text(item, _NAME): _shape(item) for item in wire.messages(graph, _INPUTS)}
    return {name: shape for name, shape in found.items() if name not in constants}


def _shape(item: memoryview) -> tuple[int | None, ...]:
    for number in (_TYPE, _TENSOR, _SHAPE):
        inner = wire.messages(item, number)
        if not inner:
            return ()
        item = inner[-1]
    sizes = [wire.integers(dimension, _SIZE) for dimension in wire.messages(item, _DIMENSION)]
    return tuple(size[-1] if size and size[-1] > 0 else None for size in sizes)


# Importing a file as an edge network of the user.

_ONNX, _CAFFE, _KERAS = _SUFFIXES = (".onnx", ".caffemodel", ".h5")
_PLAIN_RGB = "rgb"


def add_model(
    file: str | os.PathLike[str],
    name: str | None = None,
    *,
    inputs: str = "rgb",
    logits: bool = False,
    replace: bool = False,
) -> Path:
    """Convert a file to an edge network as described by `EdgeNetwork`, test it, and add it to the user's networks.

    Parameters
    ----------
    file : str or path
        An ONNX network (.onnx), or weights of HED from Caffe (.caffemodel) or Keras (.h5).
    name : str, optional
        Name of the network; made from the file's name if left out.
    inputs : str
        Input of an ONNX network: one of `INPUTS`.
    logits : bool
        Whether an ONNX network lacks the sigmoid at its end.
    replace : bool
        Whether it may replace one of the user's networks of the same name.

    Returns
    -------
    Path
        The ONNX file. Nothing is written unless the network works.

    Raises
    ------
    InputError
        If there is no such file, the name cannot be used, or a package that the conversion needs is missing.
    FormatError
        If the file is not an edge network.
    ExportError
        If it cannot be written.
    """
    source = Path(file)
    target = new_model_path(name_from(source) if name is None else name, replace)
    content = _converted(source, inputs, logits)
    ensure_folder(target.parent)
    write_bytes(target, content.tobytes())
    return target


def _converted(source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    """The content of a tested network file of this library's convention."""
    suffix = source.suffix.lower()
    if suffix not in _SUFFIXES:
        raise FormatError(f"{source} has an unknown format. Select a file of type {', '.join(_SUFFIXES)}.")
    if inputs not in hed.INPUTS:
        raise InputError(f"The input of a network must be one of {', '.join(hed.INPUTS)}, not {inputs!r}.")
    content = read_file(source).data
    if suffix == _ONNX:
        return _from_onnx(content, source, inputs, logits)
    if inputs != _PLAIN_RGB or logits:
        raise InputError(f"--input and --logits are for ONNX networks only: leave them out for {source.name}.")
    return _from_hed(content, source, caffe=suffix == _CAFFE)


def _from_hed(content: NDArray[np.uint8], source: Path, caffe: bool) -> NDArray[np.uint8]:
    layers = (hed.read_caffemodel if caffe else hed.read_keras_weights)(content, source.name)
    hed.check_layers(layers, source.name)
    content = np.frombuffer(hed.hed_network(layers, caffe), np.uint8)
    EdgeNetwork.read(content, source)
    return content


def _from_onnx(content: NDArray[np.uint8], source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    fixed_size = _fixed_size(content, source.name)
    if fixed_size:
        content = _edited(content, source.name, _free_size)
    if inputs != _PLAIN_RGB:
        content = _edited(content, source.name, _add_normalisation, inputs)
    try:
        if logits:
            _check_lacks_sigmoid(content, source)
            content = _edited(content, source.name, _add_sigmoid)
        EdgeNetwork.read(content, source)
    except FormatError as error:
        if fixed_size and not isinstance(error, OutputRangeError):
            told = f"{source.name} accepts only images of {fixed_size}. Export it with free height and width."
            raise FormatError(told) from error
        raise
    return content


def _check_lacks_sigmoid(content: NDArray[np.uint8], source: Path) -> None:
    """Raise InputError if a network ends with a sigmoid although `logits` is set."""
    try:
        EdgeNetwork.read(content, source)
    except OutputRangeError:
        return
    raise InputError(f"The output of {source.name} is already within 0 to 1. Add it without --logits.")
