"""Weights in the ONNX file of a network: in half precision, or a mean of those of two trainings."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

LARGE = 1000


def halve_weights(path: Path) -> None:
    """Store the large weights of an ONNX file as float16, and convert them to float32 when the file is loaded."""
    model = onnx.load(str(path))
    graph = model.graph
    for weights in [one for one in graph.initializer if np.prod(one.dims) > LARGE]:
        stored = numpy_helper.from_array(numpy_helper.to_array(weights).astype(np.float16), f"{weights.name}_half")
        graph.initializer.remove(weights)
        graph.initializer.append(stored)
        graph.node.insert(0, helper.make_node("Cast", [stored.name], [weights.name], to=TensorProto.FLOAT))
    onnx.save(model, str(path))


def mix_weights(path: Path, other: Path, share: float) -> None:
    """Replace the weights of the convolutions in an ONNX file by a mean, of which another training has a share."""
    model, given = onnx.load(str(path)), onnx.load(str(other))
    own, theirs = (dict(_convolved(one.graph)) for one in (model, given))
    for name, weights in own.items():
        mean = (1 - share) * numpy_helper.to_array(weights) + share * numpy_helper.to_array(theirs[name])
        weights.CopyFrom(numpy_helper.from_array(mean.astype(np.float32), weights.name))
    onnx.save(model, str(path))


def _convolved(graph: onnx.GraphProto) -> Iterator[tuple[tuple[str, int], TensorProto]]:
    """Weights and biases of convolutions, by the name of each and the place among its inputs."""
    weights = {one.name: one for one in graph.initializer}
    for node in graph.node:
        if node.op_type == "Conv":
            yield from (((node.name, k), weights[name]) for k, name in enumerate(node.input) if name in weights)
