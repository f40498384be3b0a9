"""The contour network of BSDS500: random crops of its images, evaluated on held-out images.

Five VGG-like stages, one side output each, fused; after HED (Xie and Tu 2015), but compact.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from ilf.segmentation.edges.detectors import MULTIPLE

from .bsds500_images import Example, consensus, random_sample
from .trainer import Arrays, Recipe

BATCH = 4
CROP = 320

WIDTHS = (16, 32, 64, 96, 96)
BLOCKS = (1, 1, 2, 2, 2)
LATERAL = 16


class DifferenceConvolution(nn.Conv2d):
    """3x3 convolution of the differences to the central pixel (Su et al. 2021), as one plain convolution.

    sum_k w_k (x_k - x_centre) is a convolution whose central weight is the negated sum of the others.
    """

    def kernel(self) -> Tensor:
        """The weights of the plain convolution."""
        centre = functional.pad(self.weight.sum((2, 3), keepdim=True), (1, 1, 1, 1))
        return self.weight - centre

    def forward(self, x: Tensor) -> Tensor:
        return functional.conv2d(x, self.kernel(), None, self.stride, self.padding, self.dilation)


class ResidualBlock(nn.Module):
    """x + BN(conv(ReLU(BN(difference convolution of x)))), then ReLU."""

    def __init__(self, channels: int, dilation: int) -> None:
        super().__init__()
        self.first = DifferenceConvolution(channels, channels, 3, padding=dilation, dilation=dilation, bias=False)
        self.first_norm = nn.BatchNorm2d(channels)
        self.second = nn.Conv2d(channels, channels, 3, padding=dilation, dilation=dilation, bias=False)
        self.second_norm = nn.BatchNorm2d(channels)

    def forward(self, x: Tensor) -> Tensor:
        y = functional.relu(self.first_norm(self.first(x)))
        return functional.relu(x + self.second_norm(self.second(y)))


def _stage(inputs: int, channels: int, blocks: int, dilation: int) -> nn.Sequential:
    entry = nn.Conv2d(inputs, channels, 3, padding=1, bias=False)
    norm = nn.BatchNorm2d(channels)
    return nn.Sequential(entry, norm, nn.ReLU(), *(ResidualBlock(channels, dilation) for _ in range(blocks)))


class EdgeModel(nn.Module):
    """Network from colour to boundary logits.

    The image is (N, 3, H, W), RGB in [0, 1], H and W multiples of 16. `forward` gives the five side outputs, finest
    first, and the fused one last, each (N, 1, H, W), before the sigmoid.
    """

    def __init__(self) -> None:
        super().__init__()
        last = len(WIDTHS) - 1
        self.stages = nn.ModuleList(
            _stage(inputs, channels, blocks, 2 if k == last else 1)
            for k, (inputs, channels, blocks) in enumerate(zip((3, *WIDTHS[:-1]), WIDTHS, BLOCKS, strict=True))
        )
        self.laterals = nn.ModuleList(nn.Conv2d(channels, LATERAL, 1) for channels in WIDTHS)
        self.refine = nn.ModuleList(nn.Conv2d(LATERAL, LATERAL, 3, padding=1) for _ in WIDTHS)
        self.sides = nn.ModuleList(nn.Conv2d(LATERAL, 1, 1) for _ in WIDTHS)
        self.fuse = nn.Conv2d(len(WIDTHS), 1, 1)
        nn.init.constant_(self.fuse.weight, 1 / len(WIDTHS))
        nn.init.zeros_(self.fuse.bias)

    def forward(self, image: Tensor) -> list[Tensor]:
        x = (image - 0.45) * 4
        features = []
        for k, stage in enumerate(self.stages):
            x = stage(functional.max_pool2d(x, 2) if k else x)
            features.append(self.laterals[k](x))
        sides: list[Tensor] = []
        above = None
        for k in reversed(range(len(features))):
            level = features[k] if above is None else features[k] + _enlarge(above, 2)
            above = functional.relu(self.refine[k](level))
            sides.insert(0, _enlarge(self.sides[k](above), 2**k))
        return [*sides, self.fuse(torch.cat(sides, 1))]


def _enlarge(x: Tensor, factor: int) -> Tensor:
    if factor == 1:
        return x
    return functional.interpolate(x, scale_factor=float(factor), mode="bilinear", align_corners=False)


def edge_loss(outputs: list[Tensor], share: Tensor) -> Tensor:
    """Class-balanced cross-entropy of all outputs: the fused one twice, each side 0.6 times.

    Parameters
    ----------
    outputs : list of Tensor, shape (N, 1, H, W)
        Logits, the fused one last.
    share : Tensor, shape (N, 1, H, W)
        Share of the annotators who marked a boundary. Above 0.3 counts as boundary, 0 as none, the rest is ignored.
    """
    positive = share > 0.3
    negative = share == 0
    # Balanced per image, so that images with many boundaries do not dominate those with few.
    positives = positive.sum((1, 2, 3), keepdim=True).float()
    negatives = negative.sum((1, 2, 3), keepdim=True).float()
    total = (positives + negatives).clamp(min=1)
    weight = positive * (negatives / total) + negative * (1.1 * positives / total)
    target = positive.float()
    losses = [
        functional.binary_cross_entropy_with_logits(one.float(), target, weight, reduction="sum") for one in outputs
    ]
    return (2 * losses[-1] + 0.6 * torch.stack(losses[:-1]).sum()) / share.numel()


class _Deployed(nn.Module):
    """The model as plain convolutions with normalisation folded in, and boundary strength in [0, 1] as output."""

    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model = deepcopy(model).eval()
        for stage in self.model.stages:
            stage[0], stage[1] = fuse_conv_bn_eval(stage[0], stage[1]), nn.Identity()
            for block in stage:
                if isinstance(block, ResidualBlock):
                    block.first = fuse_conv_bn_eval(_plain(block.first), block.first_norm)
                    block.second = fuse_conv_bn_eval(block.second, block.second_norm)
                    block.first_norm = block.second_norm = nn.Identity()

    def forward(self, image: Tensor) -> Tensor:
        return torch.sigmoid(self.model(image)[-1])


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


class Bsds500Recipe(Recipe):
    """Recipe of the contour network of BSDS500.

    Parameters
    ----------
    learnt, held_out : list of Example
    """

    seed = 20
    peak_rate = 2e-3
    file_name = "bsds500.onnx"
    inputs: ClassVar = {"image": 3}
    outputs = ("strength",)

    def __init__(self, learnt: list[Example], held_out: list[Example]) -> None:
        self.learnt = learnt
        self.others = held_out

    def new_model(self) -> nn.Module:
        return EdgeModel()

    def batch(self, rng: np.random.Generator) -> Arrays:
        chosen = rng.integers(len(self.learnt), size=BATCH)
        images, shares = zip(*(random_sample(self.learnt[k], CROP, rng) for k in chosen), strict=True)
        return np.stack(images), np.stack(shares)[..., None]

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, share = batch
        return edge_loss(model(image), share)

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        losses = []
        for example in self.others:
            height, width = example.rgb.shape[:2]
            padding = [(MULTIPLE, MULTIPLE + -side % MULTIPLE) for side in (height, width)]
            padded = np.pad(example.rgb, (*padding, (0, 0)), mode="reflect")
            share = consensus(example.segmentations)[None, ..., None]
            image, ground_truth = tensors((np.asarray(padded[None] / 255, np.float32), share))
            window = ..., slice(MULTIPLE, MULTIPLE + height), slice(MULTIPLE, MULTIPLE + width)
            losses.append(float(edge_loss([one[window] for one in model(image)], ground_truth)))
        return {"held-out loss": float(np.mean(losses))}

    def deployed(self, model: nn.Module) -> nn.Module:
        return _Deployed(model)
