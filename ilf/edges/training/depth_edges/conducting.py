"""The depth-edge network taught by what depth does that spreads through its conductances."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ...depth_features import CHANNELS
from .conduction import conduct
from .loss import COARSE_SHARE, coarse_loss, line_loss
from .model import UP_WIDTHS, DepthEdgeModel

Links = tuple[Tensor, Tensor, Tensor, Tensor, Tensor]

CELL = 4
FIRMNESS = 10.0
"""How firmly a cell whose pixels are all known is held, against a conductance of 1."""

LEAST_CONDUCTANCE = 1e-5

SOLUTION_SHARE, LINES_SHARE = 4.0, 0.1
"""In the loss, of the solution, and of what the network learnt before."""

_STEEPNESS = 4.0
"""Power, at first, of the probability of no jump that is the conductance."""

_HUBER = 0.02
"""Error of log depth up to which the loss is a square."""

_GAIN, _RISE_GAIN = 4.0, 0.1
"""Of what the last convolution says of conductance and trust, and of rises of log depth."""

_FEWEST = 20
"""Cells that are counted in a picture, or it is left out."""


class ConductingModel(nn.Module):
    """The depth-edge model, and from it the links of a grid of cells of 4 x 4 pixels, for `conduct`.

    `forward` gives what the depth-edge model gives, and conductances of links to the right (N, H/4, W/4 - 1) and below
    (N, H/4 - 1, W/4), the rises of log depth along them, and how far to trust each known cell (N, H/4, W/4).

    Parameters
    ----------
    rises : bool
        Whether rises and trust are learnt; else they are 0 and 1.
    """

    def __init__(self, rises: bool = True) -> None:
        super().__init__()
        self.base = DepthEdgeModel()
        self.rises = rises
        self._level = torch.empty(0)
        self.base.coarse.register_forward_hook(self._keep)
        self.first = nn.Conv2d(UP_WIDTHS[1] + 4, 32, 3, padding=1, bias=False)
        self.norm = nn.BatchNorm2d(32)
        self.last = nn.Conv2d(32, 5 if rises else 2, 3, padding=1)
        nn.init.zeros_(self.last.weight)
        nn.init.zeros_(self.last.bias)
        self.steepness = nn.Parameter(torch.tensor(_STEEPNESS))

    def _keep(self, module: nn.Module, inputs: tuple[Tensor, ...], output: Tensor) -> None:
        self._level = inputs[0]

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor, Links]:
        logits, coarse = self.base(image, features)
        jump = logits[:, :1].float()
        # from centre to centre of the cells
        across = functional.max_pool2d(functional.pad(jump[..., CELL // 2 :], (0, CELL // 2), value=-9.0), CELL)
        down = functional.max_pool2d(functional.pad(jump[..., CELL // 2 :, :], (0, 0, 0, CELL // 2), value=-9.0), CELL)
        middle, spread = coarse.float().split(1, 1)
        x = torch.cat([self._level, across / 4, down / 4, middle, spread / 4], 1)
        x = self.last(functional.relu(self.norm(self.first(x)))).float()
        right = self._conductance(_GAIN * x[:, 0] + across[:, 0])[:, :, :-1]
        below = self._conductance(_GAIN * x[:, 1] + down[:, 0])[:, :-1]
        if not self.rises:
            return (
                logits,
                coarse,
                (right, below, torch.zeros_like(right), torch.zeros_like(below), torch.ones_like(x[:, 0])),
            )
        trust = torch.exp((_GAIN * x[:, 4]).clamp(-6, 3))
        return logits, coarse, (right, below, _RISE_GAIN * x[:, 2, :, :-1], _RISE_GAIN * x[:, 3, :-1], trust)

    def _conductance(self, logit: Tensor) -> Tensor:
        return torch.exp(-self.steepness * functional.softplus(logit)).clamp(max=1) + LEAST_CONDUCTANCE


def known_cells(features: Tensor) -> tuple[Tensor, Tensor]:
    """Share of the pixels of each cell whose depth is known, and their mean log depth, each (N, H/4, W/4)."""
    known = features[:, CHANNELS.index("known")][:, None].float()
    total = functional.avg_pool2d(features[:, CHANNELS.index("filled")][:, None].float() * known, CELL)
    share = functional.avg_pool2d(known, CELL)
    return share[:, 0], (total / share.clamp(min=1e-6))[:, 0]


def true_cells(log_depth: Tensor) -> tuple[Tensor, Tensor]:
    """Whether half of a cell's pixels have a true depth, and their mean log depth, each (N, H/4, W/4)."""
    there = torch.isfinite(log_depth).float()
    share = functional.avg_pool2d(there, CELL)
    return share[:, 0] >= 0.5, (functional.avg_pool2d(torch.nan_to_num(log_depth), CELL) / share.clamp(min=1e-6))[:, 0]


def counted_cells(log_depth: Tensor, features: Tensor) -> Tensor:
    """Cells that have a true depth and no known one; none where those are few. Shape (N, H/4, W/4)."""
    counted = true_cells(log_depth)[0] & (known_cells(features)[0] == 0)
    return counted & (counted.sum((1, 2), keepdim=True) > _FEWEST)


def solution(features: Tensor, links: Links) -> Tensor:
    """Log depth of the cells, (N, H/4, W/4), in the unit of the features."""
    share, known = known_cells(features)
    right, below, rise_right, rise_below, trust = links
    return conduct(right, below, rise_right, rise_below, FIRMNESS * share * trust, known)


def solution_loss(solved: Tensor, log_depth: Tensor, features: Tensor) -> Tensor:
    """Mean, over pictures, of the error in cells without any known depth."""
    counted = counted_cells(log_depth, features)
    true = true_cells(log_depth)[1].double()
    error = functional.smooth_l1_loss(solved, true, reduction="none", beta=_HUBER) * counted
    return (error.sum((1, 2)) / counted.sum((1, 2)).clamp(min=1)).mean()


def whole_loss(model: nn.Module, batch: tuple[Tensor, ...]) -> Tensor:
    """Loss of the solution, and a little of that of lines and coarse depth."""
    image, features, lines, log_depth = batch
    logits, coarse, links = model(image, features)
    before = line_loss(logits, lines, features) + COARSE_SHARE * coarse_loss(coarse, log_depth, features)
    return SOLUTION_SHARE * solution_loss(solution(features, links), log_depth, features) + LINES_SHARE * before
