"""The trained model as ONNX: colour and depth features in, probabilities of lines and coarse depth out."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import torch
from torch import Tensor, nn

from ...depth_features import CHANNELS
from ..onnx_files import write_onnx
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
    """Write the model to an ONNX file (`write_onnx`)."""
    write_onnx(deployable(model), path, {"image": 3, "depth": len(CHANNELS)}, ("jump", "crease", "coarse"))
