"""The trained model as ONNX: colour and features in, links of cells and the logits of pixels' weights out."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...edges.training.onnx_files import write_onnx
from ..features import CHANNELS
from .model import CorrectionModel


class _Deployed(nn.Module):
    def __init__(self, model: CorrectionModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        _, _, (right, below, rise_right, rise_below, held, pull), logits = self.model(image, features)
        beyond, beneath = (0, 1), (0, 0, 0, 1)
        links = [
            functional.pad(one[:, None], side)
            for one, side in ((right, beyond), (below, beneath), (rise_right, beyond), (rise_below, beneath))
        ]
        return torch.cat([*links, held[:, None], pull[:, None]], 1), logits


def deployable(model: CorrectionModel) -> nn.Module:
    """The model for inference: (1, 3, H, W) and (1, 10, H, W) to links and logits, as the file has them."""
    return _Deployed(deepcopy(model).cpu()).eval()


def export_onnx(model: CorrectionModel, path: Path) -> None:
    """Write the model to an ONNX file (`write_onnx`)."""
    write_onnx(deployable(model), path, {"image": 3, "features": len(CHANNELS)}, ("links", "logits"))
