"""To begin from a trained depth-edge network rather than from nothing."""

from __future__ import annotations

from pathlib import Path

import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from ...edges.training.depth_edges.model import DepthEdgeModel


def take_over(model: DepthEdgeModel, path: Path, image: Tensor, features: Tensor) -> None:
    """Give a model, which may have more inputs, the weights of a depth-edge network in an ONNX file.

    The file has normalisation folded into the weights. Each normalisation becomes that which its convolution needs to
    have no effect on a batch, and goes on learning from there. Inputs that the file does not know weigh nothing yet.
    """
    graph = onnx.load(str(path)).graph
    arrays = {one.name: torch.from_numpy(numpy_helper.to_array(one).copy()) for one in graph.initializer}
    biases: dict[str, Tensor] = {}
    for node in graph.node:
        if node.op_type != "Conv":
            continue
        name = _module_name(node.name)
        convolution = model.get_submodule(name)
        assert isinstance(convolution, nn.Conv2d)
        weight, bias = (arrays[one] for one in node.input[1:])
        with torch.no_grad():
            convolution.weight.zero_()
            convolution.weight[:, : weight.shape[1]] = weight
            if convolution.bias is not None:
                convolution.bias.copy_(bias)
            else:
                biases[name] = bias
    _normalise(model, biases, image, features)


def _normalise(model: DepthEdgeModel, biases: dict[str, Tensor], image: Tensor, features: Tensor) -> None:
    for name, bias in biases.items():
        norm = _norm_of(model, name)
        with torch.no_grad():
            norm.weight.fill_(1)
            norm.bias.copy_(bias)
            norm.running_mean.zero_()
            norm.running_var.fill_(1 - norm.eps)

    def keep(name: str) -> None:
        def measure(module: nn.Module, inputs: tuple[Tensor, ...], output: Tensor) -> None:
            norm = _norm_of(model, name)
            mean, variance = output.mean((0, 2, 3)), output.var((0, 2, 3))
            norm.bias += mean
            norm.weight.copy_((variance + norm.eps).sqrt())
            norm.running_mean.copy_(mean)
            norm.running_var.copy_(variance)

        hooks.append(model.get_submodule(name).register_forward_hook(measure))

    hooks: list[torch.utils.hooks.RemovableHandle] = []
    for name in biases:
        keep(name)
    was = model.training
    model.eval()
    with torch.no_grad():
        model.levels(image, features)
    model.train(was)
    for hook in hooks:
        hook.remove()


def _module_name(node: str) -> str:
    """/model/stages.1/stages.1.3/first/Conv -> stages.1.3.first"""
    parts = node.split("/")[2:-1]
    return ".".join(parts[1:] if len(parts) > 1 and parts[1].startswith(parts[0]) else parts)


def _norm_of(model: DepthEdgeModel, convolution: str) -> nn.BatchNorm2d:
    above, last = convolution.rsplit(".", 1)
    norm = model.get_submodule(f"{above}.1" if last == "0" else f"{above}.{last}_norm")
    assert isinstance(norm, nn.BatchNorm2d)
    return norm
