"""Training task of the depth-edge network: generated pictures, to which new ones may be added during training."""

from __future__ import annotations

import time
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from ....segmentation.edges.depth_edges import CHANNELS, COARSE, LOG_SPREADS
from ..trainer import Arrays, TrainingTask, write_onnx
from .measures import LineScore
from .model import DepthEdgeModel
from .pictures import PictureFolder, random_sample, read_picture, sample_of, with_hidden_depth

# Loss of the depth-edge network: lines and coarse depth, weighted.

POSITIVE_WEIGHT = 3.0
"""Weight of a pixel on a line; other pixels have 1."""

BESIDE_WEIGHT = 0.25
"""Weight of a pixel beside a line."""

KNOWN_WEIGHT = 0.4
"""Weight of pixels with known depth, where the known depth shows edges; pixels with missing depth have 1."""

CREASE_SHARE, COARSE_SHARE = 0.5, 0.1
"""Weights of creases and of the coarse depth in the loss; jumps have 1."""


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
    offset = at_quarter(log_depth - features[:, CHANNELS.index("filled")][:, None])
    weights = at_quarter(_where_missing(features)) * torch.isfinite(offset)
    middle, spread = coarse.float().split(1, 1)
    spread = spread.clamp(*LOG_SPREADS)
    loss = (torch.nan_to_num(offset) - middle).abs() * torch.exp(-spread) + spread
    return (loss * weights).sum() / weights.sum().clamp(min=1)


def at_quarter(values: Tensor) -> Tensor:
    """Take one pixel of each 4 x 4, not their mean, which could lie between two surfaces."""
    return values[..., COARSE // 2 :: COARSE, COARSE // 2 :: COARSE]


def _where_missing(features: Tensor) -> Tensor:
    known = features[:, CHANNELS.index("known")][:, None]
    return 1 - (1 - KNOWN_WEIGHT) * known


# The trained model as ONNX: colour and depth features in, probabilities of lines and coarse depth out.


class _Deployed(nn.Module):
    def __init__(self, model: DepthEdgeModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, image: Tensor, depth: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        lines, coarse = self.model(image, depth)
        jump, crease = torch.sigmoid(lines).split(1, 1)
        return jump, crease, coarse


def deployable(model: DepthEdgeModel) -> nn.Module:
    """Convert the model for inference: (1, 3, H, W) and (1, 6, H, W) to jump, crease and coarse, as in the file."""
    return _Deployed(deepcopy(model).cpu()).eval()


def export_onnx(model: DepthEdgeModel, path: Path) -> None:
    """Write the model to an ONNX file (`write_onnx`)."""
    write_onnx(deployable(model), path, {"image": 3, "depth": len(CHANNELS)}, ("jump", "crease", "coarse"))


BATCH = 4
RELIST_INTERVAL_S = 60.0
"""Interval at which the folder is listed again."""

FAR_FROM_KNOWN = np.log1p(3) / 4
"""The feature "distance" at 3 px from known depth; up to there the known depth itself shows jumps."""


class DepthEdgeTraining(TrainingTask):
    """Training task of the depth-edge network.

    Parameters
    ----------
    folder : PictureFolder
    """

    seed = 20
    peak_rate = 2e-3
    file_name = "depth-edges.onnx"

    def __init__(self, folder: PictureFolder) -> None:
        self.folder = folder
        self._looked = time.monotonic()

    def new_model(self) -> nn.Module:
        return DepthEdgeModel()

    def batch(self, rng: np.random.Generator) -> Arrays:
        if time.monotonic() > self._looked + RELIST_INTERVAL_S:
            self.folder.relist()
            self._looked = time.monotonic()
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
            far = sample[1][..., CHANNELS.index("distance")] > FAR_FROM_KNOWN
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

    def export(self, model: nn.Module, path: Path) -> None:
        assert isinstance(model, DepthEdgeModel)
        export_onnx(model, path)
