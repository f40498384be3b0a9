"""Initialisation of a model from an ONNX file of an earlier training."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import numpy_helper
from torch import Tensor, nn


def initialise_from(model: nn.Module, path: Path, *inputs: NDArray[np.float32]) -> None:
    """Copy the weights of a network in an ONNX file into a model, as far as the model has convolutions of their names
    and kernels; weights of inputs that only one of them has are 0 or left out, and outputs that only the model has
    keep theirs.

    The file has normalisation folded into the weights. Each normalisation is set so that it has no effect on a batch,
    and is trained from there.

    Parameters
    ----------
    model : nn.Module
        With a `UNet`, or being one.
    path : Path
    *inputs : ndarray of float32, shape (N, H, W, C)
        A batch: the arguments of the model.
    """
    graph = onnx.load(str(path)).graph
    arrays = {one.name: torch.from_numpy(numpy_helper.to_array(one).astype(np.float32)) for one in graph.initializer}
    stored = [node for node in graph.node if node.op_type == "Cast" and node.input[0] in arrays]  # in half precision
    arrays |= {node.output[0]: arrays[node.input[0]] for node in stored}
    own = {name: module for name, module in model.named_modules() if isinstance(module, nn.Conv2d)}
    biases: dict[str, Tensor] = {}
    for node in graph.node:
        name = _name_in(own, node.name)
        if node.op_type != "Conv" or name is None:
            continue
        weight, bias = (arrays[one] for one in node.input[1:])
        convolution = own[name]
        outputs, both = len(weight), min(weight.shape[1], convolution.weight.shape[1])
        if convolution.weight.shape[2:] != weight.shape[2:] or len(convolution.weight) < outputs:
            continue
        with torch.no_grad():
            convolution.weight[:outputs] = 0
            convolution.weight[:outputs, :both] = weight[:, :both]
            if convolution.bias is not None:
                convolution.bias[:outputs] = bias
            else:
                biases[name] = bias
    _normalise(model, biases, *(torch.from_numpy(one).permute(0, 3, 1, 2) for one in inputs))


def _normalise(model: nn.Module, biases: dict[str, Tensor], *inputs: Tensor) -> None:
    hooks = []
    for name, bias in biases.items():
        norm = _norm_of(model, name)
        with torch.no_grad():
            norm.weight.fill_(1)
            norm.bias.copy_(bias)
            norm.running_mean.zero_()
            norm.running_var.fill_(1 - norm.eps)

        def measure(module: nn.Module, given: object, output: Tensor, norm: nn.BatchNorm2d = norm) -> None:
            mean, variance = output.mean((0, 2, 3)), output.var((0, 2, 3))
            norm.bias += mean
            norm.weight.copy_((variance + norm.eps).sqrt())
            norm.running_mean.copy_(mean)
            norm.running_var.copy_(variance)

        hooks.append(model.get_submodule(name).register_forward_hook(measure))
    was = model.training
    model.eval()
    with torch.no_grad():
        model(*inputs)
    model.train(was)
    for hook in hooks:
        hook.remove()


def _name_in(own: dict[str, nn.Conv2d], node: str) -> str | None:
    """The module of a node: /model/stages.1/stages.1.3/first/Conv -> stages.1.3.first, in the model or below `base`."""
    parts = node.split("/")[2:-1]
    names = [".".join(parts[k:]) for k in range(len(parts))]
    return next((one for name in names for one in (name, f"base.{name}") if one in own), None)


def _norm_of(model: nn.Module, convolution: str) -> nn.BatchNorm2d:
    above, last = convolution.rsplit(".", 1)
    norm = model.get_submodule(f"{above}.1" if last == "0" else f"{above}.{last}_norm")
    assert isinstance(norm, nn.BatchNorm2d)
    return norm
