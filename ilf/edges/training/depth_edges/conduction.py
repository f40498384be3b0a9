"""Depth that spreads through a grid of conductors from the cells where it is known, differentiably."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded
from torch import Tensor

Array = NDArray[np.float64]

_LEAK = 1e-8
"""Conductance of every cell to 0, so that there is a solution even where nothing is known."""


def conduct(right: Tensor, below: Tensor, rise_right: Tensor, rise_below: Tensor, held: Tensor, to: Tensor) -> Tensor:
    """The values u that minimise sum held (u - to)^2 + sum link (u_next - u - rise)^2.

    Parameters
    ----------
    right, rise_right : Tensor, shape (N, H, W - 1)
        Conductance of the link from a cell to its right neighbour, and how much higher that one should be.
    below, rise_below : Tensor, shape (N, H - 1, W)
        The same of links to lower neighbours.
    held, to : Tensor, shape (N, H, W)
        How firmly each cell is held to its known value, 0 where there is none, and that value.

    Returns
    -------
    Tensor, shape (N, H, W)
        As float64.
    """
    values: Tensor = _Conduction.apply(*(one.double() for one in (right, below, rise_right, rise_below, held, to)))
    return values


class _Conduction(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, *inputs: Tensor) -> Tensor:
        right, below, rise_right, rise_below, held, to = (one.detach().cpu().numpy() for one in inputs)
        load = held * to
        load[:, :, 1:] += right * rise_right
        load[:, :, :-1] -= right * rise_right
        load[:, 1:] += below * rise_below
        load[:, :-1] -= below * rise_below
        ctx.factors = [_factors(*one) for one in zip(right, below, held, strict=True)]
        solved = torch.from_numpy(_solve(ctx.factors, load)).to(inputs[0].device)
        ctx.save_for_backward(solved, *inputs)
        return solved

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor, ...]:
        solved, right, below, rise_right, rise_below, held, to = ctx.saved_tensors
        adjoint = torch.from_numpy(_solve(ctx.factors, gradients[0].cpu().numpy())).to(solved.device)
        across, down = adjoint.diff(dim=2), adjoint.diff(dim=1)
        return (
            -across * (solved.diff(dim=2) - rise_right),
            -down * (solved.diff(dim=1) - rise_below),
            right * across,
            below * down,
            adjoint * (to - solved),
            held * adjoint,
        )


def _factors(right: Array, below: Array, held: Array) -> Array:
    """Banded Cholesky factors, cells being counted down the columns."""
    height, width = held.shape
    diagonal = held + _LEAK
    diagonal[:, 1:] += right
    diagonal[:, :-1] += right
    diagonal[1:] += below
    diagonal[:-1] += below
    bands = np.zeros((height + 1, width, height))
    bands[0] = diagonal.T
    bands[1, :, :-1] = -below.T
    bands[height, :-1] = -right.T
    return np.asarray(cholesky_banded(bands.reshape(height + 1, -1), overwrite_ab=True, lower=True, check_finite=False))


def _solve(factors: list[Array], load: Array) -> Array:
    """Solutions of shape (N, H, W)."""
    _, height, width = load.shape
    solved = [
        cho_solve_banded((bands, True), one.T.reshape(-1), check_finite=False).reshape(width, height).T
        for bands, one in zip(factors, load, strict=True)
    ]
    return np.stack(solved)
