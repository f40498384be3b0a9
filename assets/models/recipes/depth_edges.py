"""The depth-edge network: lines of jumps and creases, and a coarse depth, from colour and known depth.

It learns from generated pictures, to which new ones may be added during training.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ilf.segmentation.edges.detectors import DEPTH_CHANNELS

from .lines import LineScore
from .pictures import PictureFolder, random_sample, read_picture, sample_of, with_hidden_depth
from .stored_weights import halve_weights
from .trainer import Arrays, Recipe
from .unet import INITIAL_LOGIT, UP_WIDTHS, UNet, lines_head

BATCH = 4

COARSE = 4
"""Size in pixels of one value of the network's coarse depth."""

LOG_SPREADS = (-7.0, 3.0)
"""Minimum and maximum log of the expected error of the coarse depth."""

POSITIVE_WEIGHT = 3.0
"""Weight of a pixel on a line; other pixels have 1."""

BESIDE_WEIGHT = 0.25
"""Weight of a pixel beside a line."""

KNOWN_WEIGHT = 0.4
"""Weight of pixels with known depth, where the known depth shows edges; pixels with missing depth have 1."""

CREASE_SHARE, COARSE_SHARE = 0.5, 0.1
"""Weights of creases and of the coarse depth in the loss; jumps have 1."""

FAR_FROM_KNOWN = np.log1p(3) / 4
"""The feature "distance" at 3 px from known depth; up to there the known depth itself shows jumps."""


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

    def __init__(self, inputs: int = 3 + len(DEPTH_CHANNELS)) -> None:
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


def line_loss(logits: Tensor, lines: Tensor, features: Tensor) -> Tensor:
    """Weighted cross-entropy of jumps and creases, each (N, H, W) in logits and lines of shape (N, 2, H, W)."""
    near = functional.max_pool2d(lines, 3, stride=1, padding=1) > 0
    weights = torch.where(lines > 0, POSITIVE_WEIGHT, torch.where(near, BESIDE_WEIGHT, 1.0))
    weights = weights * _where_missing(features)
    shares = torch.tensor((1.0, CREASE_SHARE), device=lines.device).view(1, 2, 1, 1)
    loss = functional.binary_cross_entropy_with_logits(logits.float(), lines, weights * shares, reduction="sum")
    return loss / weights[:, 0].sum()


def coarse_loss(coarse: Tensor, log_depth: Tensor, features: Tensor) -> Tensor:
    """Negative log likelihood of a Laplace distribution around the coarse depth.

    Parameters
    ----------
    coarse : Tensor, shape (N, 2, H/4, W/4)
        Log depth minus the filled one, and the log of its mean error.
    log_depth : Tensor, shape (N, 1, H, W)
        True log depth in the unit of the features, NaN where there is none.
    features : Tensor, shape (N, 6, H, W)
    """
    offset = at_quarter(log_depth - features[:, DEPTH_CHANNELS.index("filled")][:, None])
    weights = at_quarter(_where_missing(features)) * torch.isfinite(offset)
    middle, spread = coarse.float().split(1, 1)
    spread = spread.clamp(*LOG_SPREADS)
    loss = (torch.nan_to_num(offset) - middle).abs() * torch.exp(-spread) + spread
    return (loss * weights).sum() / weights.sum().clamp(min=1)


def at_quarter(values: Tensor) -> Tensor:
    """Take one pixel of each 4 x 4, not their mean, which could lie between two surfaces."""
    return values[..., COARSE // 2 :: COARSE, COARSE // 2 :: COARSE]


def _where_missing(features: Tensor) -> Tensor:
    known = features[:, DEPTH_CHANNELS.index("known")][:, None]
    return 1 - (1 - KNOWN_WEIGHT) * known


class _Deployed(nn.Module):
    """The model with probabilities of jumps and creases as outputs."""

    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, depth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        lines, coarse = self.model(image, depth)
        jump, crease = torch.sigmoid(lines).split(1, 1)
        return jump, crease, coarse


class DepthEdgeRecipe(Recipe):
    """Recipe of the depth-edge network.

    Parameters
    ----------
    folder : PictureFolder
    """

    seed = 20
    peak_rate = 2e-3
    file_name = "depth-edges.onnx"
    inputs: ClassVar = {"image": 3, "depth": len(DEPTH_CHANNELS)}
    outputs = ("jump", "crease", "coarse")

    def __init__(self, folder: PictureFolder) -> None:
        self.folder = folder

    def new_model(self) -> nn.Module:
        return DepthEdgeModel()

    def finish(self, path: Path) -> None:
        halve_weights(path)

    def batch(self, rng: np.random.Generator) -> Arrays:
        self.folder.refresh()
        chosen = rng.integers(len(self.folder.learnt), size=BATCH)
        samples = [random_sample(read_picture(self.folder.learnt[k]), rng) for k in chosen]
        return tuple(np.stack(arrays) for arrays in zip(*samples, strict=True))

    def loss(self, model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
        image, features, lines, log_depth = batch
        logits, coarse = model(image, features)
        return line_loss(logits, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features)

    def held_out(self, model: nn.Module, tensors: Callable[[Arrays], tuple[Tensor, ...]]) -> dict[str, float]:
        losses, jumps, creases, errors, fills = [], LineScore(), LineScore(), [], []
        for k, picture in enumerate(map(read_picture, self.folder.held_out)):
            depth = with_hidden_depth(picture, np.random.default_rng((self.seed, k)))
            sample = sample_of(picture, np.asarray(picture.rgb / 255, np.float32), depth)
            image, features, lines, log_depth = tensors(tuple(one[None] for one in sample))
            logits, coarse = model(image, features)
            losses.append(
                float(line_loss(logits, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features))
            )
            far = sample[1][..., DEPTH_CHANNELS.index("distance")] > FAR_FROM_KNOWN
            for score, found, ground_truth in zip(
                (jumps, creases), logits[0].sigmoid(), sample[2].transpose(2, 0, 1) > 0, strict=True
            ):
                score.add(found.cpu().numpy(), ground_truth, far)
            offset = at_quarter(log_depth - features[:, 1:2])[0, 0].cpu().numpy()
            counted = np.isfinite(offset) & far[2::4, 2::4]
            errors.append(np.abs(offset - coarse[0, 0].cpu().numpy())[counted])
            fills.append(np.abs(offset)[counted])
        return {
            "held-out loss": float(np.mean(losses)),
            "jump AP": jumps.average_precision,
            "crease AP": creases.average_precision,
            "coarse error": float(np.mean(np.concatenate(errors))),
            "filled error": float(np.mean(np.concatenate(fills))),
        }

    def deployed(self, model: nn.Module) -> nn.Module:
        return _Deployed(model)
