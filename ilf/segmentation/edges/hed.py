"""Conversion of HED's weights to an ONNX network of this library's convention."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import helper, numpy_helper

from .hed_weights import CONVOLUTIONS, FUSION, SCORES, UPSAMPLINGS, Layer, normalisation

# HED as an ONNX file.

_CAFFE_PADDING = 35
_OPSET = 17
_IR_VERSION = 8


def hed_network(layers: Mapping[str, Layer], caffe: bool) -> bytes:
    """Build the network as an ONNX file: RGB in [0, 1] with sides that are multiples of 16, to strength in [0, 1].

    Parameters
    ----------
    layers : mapping of str to Layer
        As checked by `check_layers`.
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
        self._nodes: list[onnx.NodeProto] = []
        self._constants: list[onnx.TensorProto] = []

    def add(self, kind: str, *inputs: str, **attributes: Any) -> str:
        output = f"v{len(self._nodes)}"
        self._nodes.append(helper.make_node(kind, inputs, [output], name=f"{kind}_{output}", **attributes))
        return output

    def constant(self, values: NDArray[Any]) -> str:
        name = f"c{len(self._constants)}"
        self._constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def convolution(self, x: str, layer: Layer, kind: str = "Conv", **attributes: Any) -> str:
        weight, bias = (self.constant(values) for values in layer)
        return self.add(kind, x, weight, bias, kernel_shape=layer.weight.shape[2:], **attributes)

    def file(self, image: str, strength: str) -> bytes:
        graph = helper.make_graph(self._nodes, "HED", [_picture(image, 3)], [_picture(strength, 1)], self._constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR_VERSION)
        return model.SerializeToString()


def _picture(name: str, channels: int) -> onnx.ValueInfoProto:
    return helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, [1, channels, "height", "width"])
