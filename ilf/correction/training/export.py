"""The trained model as ONNX: colour and features in, links of cells and weights of pixels out."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn import functional

from ..features import CHANNELS
from .model import CorrectionModel


class _Deployed(nn.Module):
    def __init__(self, model: CorrectionModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        _, _, (right, below, rise_right, rise_below, held, pull), weights = self.model(image, features)
        beyond, beneath = (0, 1), (0, 0, 0, 1)
        links = [
            functional.pad(one[:, None], side)
            for one, side in ((right, beyond), (below, beneath), (rise_right, beyond), (rise_below, beneath))
        ]
        return torch.cat([*links, held[:, None], pull[:, None]], 1), weights


def deployable(model: CorrectionModel) -> nn.Module:
    """The model for inference: (1, 3, H, W) and (1, 10, H, W) to links and weights, as the file has them."""
    return _Deployed(deepcopy(model).cpu()).eval()


def export_onnx(model: CorrectionModel, path: Path) -> None:
    """Write the model to an ONNX file whose height and width are free; normalisation is folded into the weights."""
    names = ("image", "features", "links", "weights")
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
