"""Differentiable spreading of changes of depth through a grid of conductors."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from ....completion.correction_network import factors_of, load_of, solve

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


class _Conduction(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, *inputs: Tensor) -> Tensor:
        right, below, rise_right, rise_below, held, pull = (one.detach().cpu().numpy() for one in inputs)
        ctx.factors = [factors_of(*one) for one in zip(right, below, held, strict=True)]
        solved = torch.stack(
            [
                torch.from_numpy(solve(factors, load_of(*one)))
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
        adjoint = torch.stack([torch.from_numpy(solve(*one)) for one in zip(ctx.factors, gradient, strict=True)]).to(
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
