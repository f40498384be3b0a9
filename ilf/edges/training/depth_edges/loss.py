"""What the depth-edge network is told about its mistakes: lines and coarse depth, where it counts."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from ...depth_features import CHANNELS
from ...depth_network import COARSE

POSITIVE_WEIGHT = 3.0
"""Of a pixel on a line, against 1 of another."""

BESIDE_WEIGHT = 0.25
"""Of a pixel beside a line."""

KNOWN_WEIGHT = 0.4
"""Of pixels whose depth is known, and which the known depth tells about, against 1 where it is missing."""

CREASE_SHARE, COARSE_SHARE = 0.5, 0.1
"""Of creases and of the coarse depth in the loss, against 1 of jumps."""


def line_loss(logits: Tensor, lines: Tensor, features: Tensor) -> Tensor:
    """Weighted cross-entropy of jumps and creases, each (N, H, W) in logits and lines of shape (N, 2, H, W)."""
    near = functional.max_pool2d(lines, 3, stride=1, padding=1) > 0
    weights = torch.where(lines > 0, POSITIVE_WEIGHT, torch.where(near, BESIDE_WEIGHT, 1.0))
    weights = weights * _where_missing(features)
    shares = torch.tensor((1.0, CREASE_SHARE), device=lines.device).view(1, 2, 1, 1)
    loss = functional.binary_cross_entropy_with_logits(logits.float(), lines, weights * shares, reduction="sum")
    return loss / weights[:, 0].sum()


def coarse_loss(coarse: Tensor, log_depth: Tensor, features: Tensor) -> Tensor:
    """Negative log-likelihood of a Laplace distribution around the coarse depth.

    Parameters
    ----------
    coarse : Tensor, shape (N, 2, H/4, W/4)
        Log depth less the filled one, and the log of its mean error.
    log_depth : Tensor, shape (N, 1, H, W)
        The true one in the unit of the features, NaN where there is none.
    features : Tensor, shape (N, 6, H, W)
    """
    offset = at_quarter(log_depth - features[:, CHANNELS.index("filled")][:, None])
    weights = at_quarter(_where_missing(features)) * torch.isfinite(offset)
    middle, spread = coarse.float().split(1, 1)
    spread = spread.clamp(-7, 3)
    loss = (torch.nan_to_num(offset) - middle).abs() * torch.exp(-spread) + spread
    return (loss * weights).sum() / weights.sum().clamp(min=1)


def at_quarter(values: Tensor) -> Tensor:
    """One pixel of each 4 x 4: no mean, which would lie between two surfaces."""
    return values[..., COARSE // 2 :: COARSE, COARSE // 2 :: COARSE]


def _where_missing(features: Tensor) -> Tensor:
    known = features[:, CHANNELS.index("known")][:, None]
    return 1 - (1 - KNOWN_WEIGHT) * known
