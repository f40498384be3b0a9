"""A compact U-Net that works at half of the picture's size or less: the trunk of all networks trained here."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

WIDTHS = (24, 32, 48, 64, 96)
"""Channels of the stages, at 1/2 to 1/32 of the picture's size."""

BLOCKS = (0, 1, 2, 2, 3)
"""Residual blocks of each stage."""

UP_WIDTHS = (24, 32, 32, 48)
"""Channels of the decoder, at 1/2 to 1/16."""

INITIAL_LOGIT = -3.0
"""Initial logit of lines."""


class ResidualBlock(nn.Module):
    """x + BN(conv(ReLU(BN(conv(x))))), then ReLU."""

    def __init__(self, channels: int, dilation: int = 1) -> None:
        super().__init__()
        self.first = _convolution(channels, channels, dilation)
        self.first_norm = nn.BatchNorm2d(channels)
        self.second = _convolution(channels, channels, dilation)
        self.second_norm = nn.BatchNorm2d(channels)

    def forward(self, x: Tensor) -> Tensor:
        y = functional.relu(self.first_norm(self.first(x)))
        return functional.relu(x + self.second_norm(self.second(y)))


def _convolution(inputs: int, outputs: int, dilation: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=dilation, dilation=dilation, bias=False)


def _stage(inputs: int, channels: int, blocks: int, kernel: int, dilation: int) -> nn.Sequential:
    entry = nn.Conv2d(inputs, channels, kernel, stride=2, padding=kernel // 2 - 1, bias=False)
    rest = (ResidualBlock(channels, dilation) for _ in range(blocks))
    return nn.Sequential(entry, nn.BatchNorm2d(channels), nn.ReLU(), *rest)


class UNet(nn.Module):
    """Trunk from the channels of a picture to features at 1/2 and 1/4 of its size.

    Parameters
    ----------
    inputs : int
        Channels of the picture.
    """

    def __init__(self, inputs: int) -> None:
        super().__init__()
        last = len(WIDTHS) - 1
        entries = (inputs, *WIDTHS[:-1])
        self.stages = nn.ModuleList(
            # The first convolution covers every pixel of the full size: 6 x 6 around each 2 x 2.
            _stage(before, width, blocks, 4 if k else 6, 2 if k == last else 1)
            for k, (before, width, blocks) in enumerate(zip(entries, WIDTHS, BLOCKS, strict=True))
        )
        self.across = nn.ModuleList(nn.Conv2d(*pair, 1) for pair in zip(WIDTHS, UP_WIDTHS, strict=False))
        self.up = nn.ModuleList(
            nn.Conv2d(*pair, 1) for pair in zip((*UP_WIDTHS[1:], WIDTHS[-1]), UP_WIDTHS, strict=True)
        )
        self.refine = nn.ModuleList(ResidualBlock(width) for width in UP_WIDTHS)

    def levels(self, *channels: Tensor) -> tuple[Tensor, Tensor]:
        """Features at 1/2 and 1/4 of the size, from the image, (N, 3, H, W), RGB in [0, 1], and further channels; H and
        W multiples of 32."""
        image, *features = channels
        x = torch.cat([(image - 0.45) * 4, *features], 1)
        finer = []
        for stage in self.stages:
            x = stage(x)
            finer.append(x)
        for k in reversed(range(len(UP_WIDTHS))):
            above = functional.interpolate(self.up[k](x), scale_factor=2.0, mode="bilinear", align_corners=False)
            x = self.refine[k](functional.relu(above + self.across[k](finer[k])))
            if k == 1:
                quarter = x
        return x, quarter


def lines_head(kinds: int) -> nn.Conv2d:
    """The last convolution to logits of lines, four pixels of each kind for every pixel at 1/2."""
    head = nn.Conv2d(UP_WIDTHS[0], kinds * 4, 3, padding=1)
    assert head.bias is not None
    nn.init.constant_(head.bias, INITIAL_LOGIT)
    return head
