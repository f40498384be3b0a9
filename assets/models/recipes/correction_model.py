"""The correction network: the depth-edge network's trunk, with outputs that control how changes of depth spread."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded
from torch import Tensor, nn
from torch.nn import functional

from ilf.completion.correction import CELL, CHANNELS, LEAK, load_of

from .depth_edges import DepthEdgeModel
from .unet import UP_WIDTHS

Floats = NDArray[np.floating]

Links = tuple[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor]
"""Arguments of `conduct`."""


def conduct(right: Tensor, below: Tensor, rise_right: Tensor, rise_below: Tensor, held: Tensor, pull: Tensor) -> Tensor:
    """Compute the values u that minimise sum held u^2 - 2 pull u + sum link (u_next - u - rise)^2.

    Parameters
    ----------
    right, rise_right : Tensor, shape (N, H, W - 1)
        Conductance of the link from a cell to its right neighbour, and the wanted difference of the neighbour.
    below, rise_below : Tensor, shape (N, H - 1, W)
        The same for links to lower neighbours.
    held : Tensor, shape (N, H, W)
        Firmness with which each cell is held.
    pull : Tensor, shape (N, H, W)
        Firmness times the value that the cell is held to.

    Returns
    -------
    Tensor, shape (N, H, W)
        As float64.
    """
    values: Tensor = _Conduction.apply(*(one.double() for one in (right, below, rise_right, rise_below, held, pull)))
    return values


def _factors_of(right: Floats, below: Floats, held: Floats) -> Floats:
    """Banded Cholesky factors of a grid, with cells numbered down the columns.

    Parameters
    ----------
    right, below : ndarray, shapes (H, W - 1) and (H - 1, W)
        Conductances of the links to the right and to the lower neighbour.
    held : ndarray, shape (H, W)
        Weight with which each cell is pulled to 0.
    """
    height, width = held.shape
    diagonal = held + LEAK
    diagonal[:, 1:] += right
    diagonal[:, :-1] += right
    diagonal[1:] += below
    diagonal[:-1] += below
    bands = np.zeros((height + 1, width, height), diagonal.dtype)
    bands[0] = diagonal.T
    bands[1, :, :-1] = -below.T
    bands[height, :-1] = -right.T
    return np.asarray(cholesky_banded(bands.reshape(height + 1, -1), overwrite_ab=True, lower=True, check_finite=False))


def _solve(factors: Floats, load: Floats) -> Floats:
    """Solve for the values of the cells, shape (H, W)."""
    height, width = load.shape
    values = cho_solve_banded((factors, True), load.T.reshape(-1), check_finite=False)
    return np.asarray(values.reshape(width, height).T)


class _Conduction(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, *inputs: Tensor) -> Tensor:
        right, below, rise_right, rise_below, held, pull = (one.detach().cpu().numpy() for one in inputs)
        ctx.factors = [_factors_of(*one) for one in zip(right, below, held, strict=True)]
        solved = torch.stack(
            [
                torch.from_numpy(_solve(factors, load_of(*one)))
                for factors, one in zip(
                    ctx.factors, zip(right, below, rise_right, rise_below, pull, strict=True), strict=True
                )
            ]
        ).to(inputs[0].device)
        ctx.save_for_backward(solved, *inputs)
        return solved

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor, ...]:
        solved, right, below, rise_right, rise_below, *_ = ctx.saved_tensors
        gradient = gradients[0].cpu().numpy()
        adjoint = torch.stack([torch.from_numpy(_solve(*one)) for one in zip(ctx.factors, gradient, strict=True)]).to(
            solved.device
        )
        across, down = adjoint.diff(dim=2), adjoint.diff(dim=1)
        return (
            -across * (solved.diff(dim=2) - rise_right),
            -down * (solved.diff(dim=1) - rise_below),
            right * across,
            below * down,
            -adjoint * solved,
            adjoint,
        )


FIRMNESS = 10.0
"""Firmness with which a cell of known pixels is held to its depth, relative to a conductance of 1."""

MIN_CONDUCTANCE = 1e-5
AROUND = 9
"""Number of cells whose changes are averaged for a pixel: its own and its neighbours."""

_STEEPNESS = 4.0
"""Initial exponent that turns the probability of no jump into a conductance."""

_GAIN, _RISE_GAIN, _TARGET_GAIN = 4.0, 0.1, 0.5
"""Gains of the last convolution's outputs: for conductance and trust, rises of log depth, and the change itself."""

_INITIAL_TRUST, _INITIAL_LEVELLING = -4.0, -3.0
"""Initial logarithm of the firmness with which cells without known depth are held to the completed depth, and initial
logit of the share of its own rises that is removed."""


class CorrectionModel(nn.Module):
    """Network from colour and features of a frame to parameters of the spreading of changes of its completed depth.

    The image is (N, 3, H, W), RGB in [0, 1], the features are (N, 10, H, W), H and W multiples of 32. `forward` gives
    the logits of lines and the coarse depth, as in the depth-edge model, the links of cells of 4 x 4 pixels
    (`conduct`), and the logits of the weights with which each pixel averages the changes of the cells around it,
    (N, 36, H/2, W/2): for each of the 9 cells those of the 2 x 2 pixels.
    """

    def __init__(self) -> None:
        super().__init__()
        self.base = DepthEdgeModel(3 + len(CHANNELS))
        self.links = nn.Sequential(
            nn.Conv2d(UP_WIDTHS[1] + 4, 32, 3, padding=1, bias=False),
            nn.BatchNorm2d(32),
            nn.ReLU(),
            nn.Conv2d(32, 9, 3, padding=1),
        )
        self.weights = nn.Conv2d(UP_WIDTHS[0], AROUND * 4, 3, padding=1)
        self.steepness = nn.Parameter(torch.tensor(_STEEPNESS))
        with torch.no_grad():
            for last in (self.links[-1], self.weights):
                last.weight.zero_()
                last.bias.zero_()
            self.weights.bias.view(AROUND, 4)[AROUND // 2] = 1.0

    def forward(self, image: Tensor, features: Tensor) -> tuple[Tensor, Tensor, Links, Tensor]:
        half, quarter = self.base.levels(image, features)
        lines, coarse = self.base.lines(half), self.base.coarse(quarter)
        # the first four are the jumps in 2 x 2 pixels; pooled from centre to centre of the cells
        jump = lines[:, :4].float().amax(1, keepdim=True)
        across = functional.max_pool2d(functional.pad(jump[..., 1:], (0, 1), value=-9.0), CELL // 2)
        down = functional.max_pool2d(functional.pad(jump[..., 1:, :], (0, 0, 0, 1), value=-9.0), CELL // 2)
        middle, spread = coarse.float().split(1, 1)
        x = self.links(torch.cat([quarter, across / 4, down / 4, middle, spread / 4], 1)).float()
        right = self._conductance(_GAIN * x[:, 0] + across[:, 0])[:, :, :-1]
        below = self._conductance(_GAIN * x[:, 1] + down[:, 0])[:, :-1]
        known = functional.avg_pool2d(features[:, :1].float(), CELL)[:, 0]
        completed = functional.avg_pool2d(features[:, CHANNELS.index("completed")][:, None].float(), CELL)[:, 0]
        levelling = torch.sigmoid(_INITIAL_LEVELLING + _GAIN * x[:, 4:6])
        risen, fallen = completed[:, :, 1:] - completed[:, :, :-1], completed[:, 1:] - completed[:, :-1]
        rise_right = _RISE_GAIN * x[:, 2, :, :-1] - levelling[:, 0, :, :-1] * risen
        rise_below = _RISE_GAIN * x[:, 3, :-1] - levelling[:, 1, :-1] * fallen
        firm = FIRMNESS * known * torch.exp((_GAIN * x[:, 6]).clamp(-6, 3))
        loose = torch.exp((_INITIAL_TRUST + _GAIN * x[:, 7]).clamp(-9, 4))
        pull = loose * _TARGET_GAIN * x[:, 8]
        links = right, below, rise_right, rise_below, firm + loose, pull
        return functional.pixel_shuffle(lines, 2), coarse, links, self.weights(half)

    def _conductance(self, logit: Tensor) -> Tensor:
        return torch.exp(-self.steepness * functional.softplus(logit)).clamp(max=1) + MIN_CONDUCTANCE


def change(links: Links, logits: Tensor) -> Tensor:
    """The change of log depth of every pixel, (N, H, W), from links and the logits of the weights."""
    cells = conduct(*links).float()
    count, height, width = cells.shape
    around = functional.unfold(functional.pad(cells[:, None], (1, 1, 1, 1), mode="replicate"), 3)
    around = functional.interpolate(around.view(count, AROUND, height, width), scale_factor=CELL, mode="nearest")
    return (functional.softmax(functional.pixel_shuffle(logits, 2).float(), 1) * around).sum(1)
