"""The depth-edge network: lines of jumps and creases, and a coarse depth, from colour and known depth."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ....segmentation.edges.depth_edges import CHANNELS
from ..unet import INITIAL_LOGIT, UP_WIDTHS, UNet, lines_head


class DepthEdgeModel(UNet):
    """Network from colour and depth features to logits of lines and a coarse depth.

    The image is (N, 3, H, W), RGB in [0, 1], the features are (N, 6, H, W), H and W multiples of 32. `forward` gives
    the logits of jump and crease, (N, 2, H, W), and the coarse depth, (N, 2, H/4, W/4): the log depth minus the filled
    one of the features, and the log of its mean error.

    Parameters
    ----------
    inputs : int
        Channels of image and features.
    """

    def __init__(self, inputs: int = 3 + len(CHANNELS)) -> None:
        super().__init__(inputs)
        self.lines = lines_head(2)
        self.coarse = nn.Conv2d(UP_WIDTHS[1], 2, 3, padding=1)
        with torch.no_grad():
            # of the log error: 5 %
            self.coarse.bias.copy_(torch.tensor((0.0, INITIAL_LOGIT)))

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
        return self.heads(*self.levels(image, features))

    def heads(self, half: Tensor, quarter: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of lines, and coarse depth, from the output of `levels`."""
        return functional.pixel_shuffle(self.lines(half), 2), self.coarse(quarter)
