"""Initialisation of a model from an ONNX file of an earlier training."""

from __future__ import annotations

from pathlib import Path

import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from .model import SurfaceModel


def initialise_from(model: SurfaceModel, path: Path, image: Tensor, features: Tensor) -> None:
    """Copy the weights of a network in an ONNX file into a model, as far as the model has convolutions of their names
    and sizes; it may have more channels.

    The file has normalisation folded into the weights. Each normalisation is set so that it has no effect on a batch,
    and is trained from there.
    """
    graph = onnx.load(str(path)).graph
    arrays = {one.name: torch.from_numpy(numpy_helper.to_array(one).copy()) for one in graph.initializer}
    convolutions = {name: module for name, module in model.named_modules() if isinstance(module, nn.Conv2d)}
    biases: dict[str, Tensor] = {}
    for node in graph.node:
        name = _module_name(node.name)
        if node.op_type != "Conv" or name not in convolutions:
            continue
        own = convolutions[name]
        weight, bias = (arrays[one] for one in node.input[1:])
        outputs, inputs = weight.shape[:2]
        if own.weight.shape[2:] != weight.shape[2:] or len(own.weight) < outputs or own.weight.shape[1] < inputs:
            continue
        with torch.no_grad():
            own.weight[:outputs].zero_()
            own.weight[:outputs, :inputs] = weight
            if own.bias is not None:
                own.bias[:outputs] = bias
            elif len(own.weight) == outputs:
                biases[name] = bias
    _normalise(model, biases, image, features)


def _normalise(model: SurfaceModel, biases: dict[str, Tensor], image: Tensor, features: Tensor) -> None:
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


def _norm_of(model: SurfaceModel, convolution: str) -> nn.BatchNorm2d:
    above, last = convolution.rsplit(".", 1)
    norm = model.get_submodule(f"{above}.1" if last == "0" else f"{above}.{last}_norm")
    assert isinstance(norm, nn.BatchNorm2d)
    return norm
