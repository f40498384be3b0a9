"""The trained model as ONNX: plain convolutions, RGB in [0, 1] in, boundary strength in [0, 1] out."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path

import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from .model import DifferenceConvolution, EdgeModel, ResidualBlock


class _Deployed(nn.Module):
    def __init__(self, model: EdgeModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor) -> Tensor:
        return torch.sigmoid(self.model(image)[-1])


def deployable(model: EdgeModel) -> nn.Module:
    """The model for inference: difference convolutions made plain, normalisation folded into the weights.

    Returns
    -------
    nn.Module
        (1, 3, H, W) RGB in [0, 1], sides multiples of 16, to (1, 1, H, W) in [0, 1].
    """
    model = deepcopy(model).cpu().eval()
    for stage in model.stages:
        assert isinstance(stage, nn.Sequential)
        stage[0], stage[1] = fuse_conv_bn_eval(stage[0], stage[1]), nn.Identity()
        for block in stage:
            if isinstance(block, ResidualBlock):
                block.first, block.first_norm = fuse_conv_bn_eval(_plain(block.first), block.first_norm), nn.Identity()
                block.second = fuse_conv_bn_eval(block.second, block.second_norm)
                block.second_norm = nn.Identity()
    return _Deployed(model).eval()


def _plain(convolution: DifferenceConvolution) -> nn.Conv2d:
    same = nn.Conv2d(
        convolution.in_channels,
        convolution.out_channels,
        3,
        padding=convolution.padding,
        dilation=convolution.dilation,
        bias=False,
    )
    same.weight = nn.Parameter(convolution.kernel().detach())
    return same.eval()


def export_onnx(model: EdgeModel, path: Path) -> None:
    """Write the model to an ONNX file whose height and width are free."""
    torch.onnx.export(
        deployable(model),
        (torch.zeros(1, 3, 64, 64),),
        str(path),
        input_names=["image"],
        output_names=["strength"],
        dynamic_axes={"image": {2: "height", 3: "width"}, "strength": {2: "height", 3: "width"}},
        opset_version=17,
        dynamo=False,
    )
