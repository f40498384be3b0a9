"""Trained models as ONNX files whose height and width are free."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from torch import nn


def write_onnx(model: nn.Module, path: Path, inputs: Mapping[str, int], outputs: tuple[str, ...]) -> None:
    """Write a model for inference; normalisation is folded into the weights.

    Parameters
    ----------
    model : nn.Module
        In the mode of evaluation.
    path : Path
    inputs : mapping of str to int
        Name -> channels, in the order in which the model takes them.
    outputs : tuple of str
        Names of what it gives.
    """
    names = (*inputs, *outputs)
    torch.onnx.export(
        model,
        tuple(torch.zeros(1, channels, 64, 64) for channels in inputs.values()),
        str(path),
        input_names=list(inputs),
        output_names=list(outputs),
        dynamic_axes={name: {2: f"{name} height", 3: f"{name} width"} for name in names},
        opset_version=17,
        dynamo=False,
    )
