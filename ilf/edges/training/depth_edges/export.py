"""The trained model as ONNX: colour and depth features in, probabilities of lines and coarse depth out."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import torch
from torch import Tensor, nn

from ...depth_features import CHANNELS
from .model import DepthEdgeModel


class _Deployed(nn.Module):
    def __init__(self, model: DepthEdgeModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, depth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        lines, coarse = self.model(image, depth)
        jump, crease = torch.sigmoid(lines).split(1, 1)
        return jump, crease, coarse


def deployable(model: DepthEdgeModel) -> nn.Module:
    """The model for inference: (1, 3, H, W) and (1, 6, H, W) to jump, crease and coarse, as the file has them."""
    return _Deployed(deepcopy(model).cpu()).eval()


def export_onnx(model: DepthEdgeModel, path: Path) -> None:
    """Write the model to an ONNX file whose height and width are free; normalisation is folded into the weights."""
    names = ("image", "depth", "jump", "crease", "coarse")
    torch.onnx.export(
        deployable(model),
        (torch.zeros(1, 3, 64, 64), torch.zeros(1, len(CHANNELS), 64, 64)),
        str(path),
        input_names=names[:2],
        output_names=names[2:],
        dynamic_axes={name: {2: f"{name} height", 3: f"{name} width"} for name in names},
        opset_version=17,
        dynamo=False,
    )
