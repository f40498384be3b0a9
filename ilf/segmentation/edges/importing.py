"""Importing a user's edge network: HED's weights, or any ONNX network from one image to its edges."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_file
from ..._runtime.installation import optional
from ..._runtime.networks.models import name_from, new_model_path
from ..._runtime.networks.session import RefusedInputError
from ..._runtime.writing import ensure_folder, write_bytes
from ...errors import FormatError, InputError, told_as
from . import hed
from .detectors import EdgeNetwork, OutputRangeError

if TYPE_CHECKING:
    from onnx import GraphProto, ValueInfoProto

# ONNX networks of other origin: nodes that adapt their input and output.


def _edited(content: NDArray[np.uint8], file: str, edit: Callable[..., None], *how: str) -> NDArray[np.uint8]:
    """The content of an ONNX network after a function of its graph, its image input and `how` has changed these; raises
    FormatError if it is no ONNX file, or has another number of inputs."""
    onnx = optional(*hed.ONNX_PACKAGE)
    from google.protobuf.message import DecodeError

    damaged = f"{file} is not an intact ONNX file ({{error}}). Export or copy it again."
    with told_as(FormatError, damaged, DecodeError):
        model = onnx.load_from_string(content.tobytes())
    constants = {item.name for item in model.graph.initializer}  # old files list them as inputs
    images = [item for item in model.graph.input if item.name not in constants]
    if len(images) != 1 or not model.graph.output:
        raise FormatError(f"{file} has {len(images)} inputs, not one image. Export it with the image as only input.")
    edit(model.graph, images[0], *how)
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
    for side, name in zip(image.type.tensor_type.shape.dim[2:], ("height", "width"), strict=False):
        side.dim_param = name
    # sizes of results follow from it
    del graph.value_info[:]
    for output in graph.output:
        output.type.tensor_type.ClearField("shape")


# Importing a file as an edge network of the user.

_ONNX, _CAFFE, _KERAS = _SUFFIXES = (".onnx", ".caffemodel", ".h5")
_PLAIN_RGB = "rgb"

_OTHER_FILE = "Select a file with HED's weights, or convert the network to ONNX."


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
    if missing := [name for name in hed.LAYERS if name not in layers]:
        raise FormatError(f"{source.name} contains no weights of HED: the layer {missing[0]} is missing. {_OTHER_FILE}")
    content = np.frombuffer(hed.hed_network(layers, caffe), np.uint8)
    try:
        EdgeNetwork.read(content, source)
    except FormatError as error:
        raise FormatError(f"{source.name} contains no weights of HED: its layers do not fit. {_OTHER_FILE}") from error
    return content


def _from_onnx(content: NDArray[np.uint8], source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    if inputs != _PLAIN_RGB:
        content = _edited(content, source.name, _add_normalisation, inputs)
    try:
        return _tried(content, source, logits)
    except RefusedInputError:  # it may have been exported with one size, but work with others
        content = _edited(content, source.name, _free_size)
    try:
        return _tried(content, source, logits)
    except OutputRangeError:
        raise
    except FormatError as error:
        told = f"{source.name} does not take RGB images of any size. Export it with free height and width."
        raise FormatError(told) from error


def _tried(content: NDArray[np.uint8], source: Path, logits: bool) -> NDArray[np.uint8]:
    """The content of a network that works, with a sigmoid added after `logits`."""
    try:
        EdgeNetwork.read(content, source)
    except OutputRangeError:
        if not logits:
            raise
        content = _edited(content, source.name, _add_sigmoid)
        EdgeNetwork.read(content, source)
        return content
    if logits:
        raise InputError(f"The output of {source.name} is already within 0 to 1. Add it without --logits.")
    return content
