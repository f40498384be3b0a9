"""Importing a user's edge network: any ONNX network from one image to its edges."""

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
from ..._runtime.networks.network import RefusedInputError
from ..._runtime.writing import ensure_folder, write_bytes
from ...errors import FormatError, InputError, told_as
from .detectors import EdgeNetwork, OutputRangeError

if TYPE_CHECKING:
    from onnx import GraphProto, ValueInfoProto

# Input normalisations of networks, as 1 x 1 convolutions of RGB in [0, 1].

_CAFFE_MEAN = (104.00698793, 116.66876762, 122.67891434)
_IMAGENET_MEAN, _IMAGENET_DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)

INPUTS = {
    "rgb": "RGB in 0 to 1",
    "imagenet": "RGB minus the mean of ImageNet, divided by its standard deviation",
    "caffe": "BGR in 0 to 255 minus the mean of Caffe's networks, such as HED",
}


def _normalisation(name: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Weight (3, 3, 1, 1) and bias (3,) of the convolution that converts RGB in [0, 1] to one of `INPUTS` but RGB."""
    if name == "imagenet":
        weight, bias = np.diag(np.reciprocal(_IMAGENET_DEVIATION)), -np.divide(_IMAGENET_MEAN, _IMAGENET_DEVIATION)
    else:
        weight, bias = 255 * np.eye(3)[::-1], -np.asarray(_CAFFE_MEAN)
    return weight.astype(np.float32)[..., None, None], bias.astype(np.float32)


# ONNX networks of other origin: nodes that adapt their input and output.


def _edited(content: NDArray[np.uint8], file: str, edit: Callable[..., None], *how: str) -> NDArray[np.uint8]:
    """The content of an ONNX network after a function of its graph, its image input and `how` has changed these; raises
    FormatError if it is no ONNX file, or has another number of inputs."""
    onnx = optional("onnx", "onnx", "Converting a network")
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
    graph.initializer.extend(map(numpy_helper.from_array, _normalisation(inputs), names))
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
        An ONNX network (.onnx).
    name : str, optional
        Name of the network; made from the file's name if left out.
    inputs : str
        Its input: one of `INPUTS`.
    logits : bool
        Whether it lacks the sigmoid at its end.
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
    if source.suffix.lower() != ".onnx":
        raise FormatError(f"{source} is not an ONNX network (.onnx). Export it from its framework to ONNX.")
    if inputs not in INPUTS:
        raise InputError(f"The input of a network must be one of {', '.join(INPUTS)}, not {inputs!r}.")
    content = _converted(read_file(source).data, source, inputs, logits)
    ensure_folder(target.parent)
    write_bytes(target, content.tobytes())
    return target


def _converted(content: NDArray[np.uint8], source: Path, inputs: str, logits: bool) -> NDArray[np.uint8]:
    """The content of a tested network file of this library's convention."""
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
