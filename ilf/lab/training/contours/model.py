"""The contour network: lines and an embedding from colour alone."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from ..unet import UP_WIDTHS, UNet, lines_head

LINES = ("jump", "crease", "border")
"""The lines that the network learns, in this order; borders are jumps and lines between objects."""

EMBEDDING = 8
"""Channels of the embedding."""


class ContourModel(UNet):
    """Network from colour to logits of lines and an embedding.

    The image is (N, 3, H, W), RGB in [0, 1], H and W multiples of 32. `forward` gives the logits of jump, crease and
    border, (N, 3, H, W), and the embedding, (N, 8, H/4, W/4), in which pixels of one object lie near each other.
    """

    def __init__(self) -> None:
        super().__init__(3)
        self.lines = lines_head(len(LINES))
        self.embedding = nn.Conv2d(UP_WIDTHS[1], EMBEDDING, 3, padding=1)

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor]:
        half, quarter = self.levels(image)
        return functional.pixel_shuffle(self.lines(half), 2), self.embedding(quarter)
