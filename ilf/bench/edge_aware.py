"""A candidate for the default preset: a dense surface that is smooth, to first and second order, except at edges.

The energy's minimum is the fixed point of the iteration u <- S(raw where known, u elsewhere) with an edge-aware
low-pass S = (1 + lambda L)^-1. It is found directly on a coarse grid and refined by conjugate gradients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

Array = NDArray[np.float32]

_LEVELLING = np.float32(1e-9)
"""Data weight [1] towards the mean where there is no data: keeps cut-off corners from being singular."""

_NEAREST = 0.1
"""Depth [m] below which the scale of a jump no longer shrinks."""


def edge_aware_depth(
    depth: NDArray[np.float32],
    strength: NDArray[np.float32],
    *,
    edge_scale: float = 0.15,
    trust_distance: float = 6.0,
    slope_weight: float = 0.02,
    bending_weight: float = 0.1,
    jump_share: float = 0.005,
    slope_jumps: float = 4.0,
    halvings: int = 2,
    sweeps: tuple[int, ...] = (20, 40),
    reweightings: int = 2,
    reweighted_sweeps: int = 8,
) -> NDArray[np.float64]:
    """Complete depth with a surface that is smooth except at edges.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    edge_scale : float
        Strength at which smoothness is worth 1/e.
    trust_distance : float
        Distance [px] to known depth from which on edges count in full; below, in proportion.
    slope_weight, bending_weight : float
        Weights of squared first and second differences [per pixel], a known sample having weight 1.
    jump_share : float
        Second difference, as a share of depth, at which smoothness lets go.
    slope_jumps : float
        The same for first differences, in units of `jump_share`.
    halvings : int
        How often the grid is halved for the direct solution.
    sweeps : tuple of int
        Conjugate-gradient steps on the full grid, the half grid, and so on; none where it has no entry.
    reweightings, reweighted_sweeps : int
        Rounds of robust reweighting on the full grid, and the steps in each.

    Returns
    -------
    ndarray of float64, shape (H, W)
        Dense depth [m]; known pixels are smoothed too.

    Raises
    ------
    ValueError
        If no depth is known, or the shapes differ.
    """
    known = np.isfinite(depth)
    if depth.shape != strength.shape or not known.any():
        raise ValueError(f"Depth {depth.shape} and strength {strength.shape} must match, with some depth known.")
    mean = float(depth[known].mean(dtype=np.float64))
    count = known.astype(np.float32)
    total = np.where(known, depth - np.float32(mean), np.float32(0))
    distance = cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 5)
    # among dense samples the depth itself says where the jumps are, and colour is registered a few pixels off
    edges = (strength * np.minimum(distance / trust_distance, 1)).astype(np.float32)

    grids = [(count, total, edges)]
    for _ in range(halvings):
        count, total, edges = grids[-1]
        grids.append((_sum2(count), _sum2(total), _max2(edges)))

    surface: Array | None = None
    for level in range(halvings, -1, -1):
        count, total, edges = grids[level]
        weights = _weights(np.exp(-edges / np.float32(edge_scale)), slope_weight, bending_weight * 4.0**-level)
        energy = _Energy(count + _LEVELLING, *weights)
        if surface is None:
            surface = energy.solve(total)
            continue
        surface = _enlarged(surface, count.shape)
        if level < len(sweeps):
            surface = energy.refine(total, surface, sweeps[level])

    assert surface is not None
    for _ in range(reweightings):
        scale = np.maximum(surface + np.float32(mean), np.float32(_NEAREST)) * np.float32(jump_share)
        energy = _Energy(count + _LEVELLING, *_robust(weights, surface, scale, np.float32(slope_jumps)))
        surface = energy.refine(total, surface, reweighted_sweeps)
    return surface.astype(np.float64) + mean


@dataclass(frozen=True, eq=False)
class _Energy:
    """Weights of the samples (H, W), of first differences along x and y, and of second ones."""

    data: Array
    slope_x: Array
    slope_y: Array
    bend_x: Array
    bend_y: Array

    def apply(self, u: Array) -> Array:
        """Half the gradient of the quadratic part."""
        result = self.data * u
        # the transposes give views: what is added along y lands in the same array
        for values, out, slope, bend in (
            (u, result, self.slope_x, self.bend_x),
            (u.T, result.T, self.slope_y.T, self.bend_y.T),
        ):
            step = values[:, 1:] - values[:, :-1]
            flow = slope * step
            turn = bend * (step[:, 1:] - step[:, :-1])
            flow[:, :-1] -= turn
            flow[:, 1:] += turn
            out[:, :-1] -= flow
            out[:, 1:] += flow
        return result

    def diagonal(self) -> Array:
        result = self.data.copy()
        for out, slope, bend in ((result, self.slope_x, self.bend_x), (result.T, self.slope_y.T, self.bend_y.T)):
            out[:, 1:] += slope
            out[:, :-1] += slope
            out[:, 2:] += bend
            out[:, 1:-1] += 4 * bend
            out[:, :-2] += bend
        return result

    def refine(self, right: Array, start: Array, steps: int) -> Array:
        """Conjugate gradients with a diagonal preconditioner."""
        inverse = 1 / self.diagonal()
        u = start.copy()
        residual = right - self.apply(u)
        scaled = inverse * residual
        direction = scaled.copy()
        size = np.vdot(residual, scaled)
        for _ in range(steps):
            if size <= 0:
                break
            image = self.apply(direction)
            length = size / np.vdot(direction, image)
            u += length * direction
            residual -= length * image
            scaled = inverse * residual
            previous, size = size, np.vdot(residual, scaled)
            direction *= size / previous
            direction += scaled
        return u

    def solve(self, right: Array) -> Array:
        """Sparse direct solution."""
        height, width = self.data.shape
        near_x, far_x = _couplings(self.slope_x, self.bend_x, self.data.shape)
        near_y, far_y = (a.T for a in _couplings(self.slope_y.T, self.bend_y.T, (width, height)))
        numbers = np.arange(right.size)
        rows, columns = [numbers], [numbers]
        entries = [self.diagonal().astype(np.float64).ravel()]
        for values, offset in ((near_x, 1), (far_x, 2), (near_y, width), (far_y, 2 * width)):
            here, there = numbers[:-offset], numbers[offset:]
            band = values.ravel()[: here.size]
            rows += [here, there]
            columns += [there, here]
            entries += [band, band]
        places = np.concatenate(rows), np.concatenate(columns)
        matrix = coo_array((np.concatenate(entries), places), shape=(right.size, right.size)).tocsc()
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return factors.solve(right.astype(np.float64).ravel()).reshape(right.shape).astype(np.float32)


def _couplings(slope: Array, bend: Array, shape: tuple[int, int]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Matrix entries between a pixel and the next, and the one after that, along the second axis."""
    near, far = np.zeros(shape), np.zeros(shape)
    near[:, :-1] -= slope
    near[:, :-2] -= 2 * bend
    near[:, 1:-1] -= 2 * bend
    far[:, :-2] += bend
    return near, far


def _weights(smooth: Array, slope: float, bending: float) -> tuple[Array, Array, Array, Array]:
    """A difference is worth as much as the least smooth pixel in it."""
    x, y = np.minimum(smooth[:, 1:], smooth[:, :-1]), np.minimum(smooth[1:], smooth[:-1])
    bend_x, bend_y = np.minimum(x[:, 1:], x[:, :-1]), np.minimum(y[1:], y[:-1])
    first, second = np.float32(slope), np.float32(bending)
    return first * x, first * y, second * bend_x, second * bend_y


def _robust(
    weights: tuple[Array, Array, Array, Array], u: Array, scale: Array, slope_jumps: np.float32
) -> tuple[Array, Array, Array, Array]:
    """Weights by Cauchy's rule: differences far above the scale let go."""
    x, y = u[:, 1:] - u[:, :-1], u[1:] - u[:-1]
    ratios = (
        x / (slope_jumps * scale[:, 1:]),
        y / (slope_jumps * scale[1:]),
        (x[:, 1:] - x[:, :-1]) / scale[:, 1:-1],
        (y[1:] - y[:-1]) / scale[1:-1],
    )
    slope_x, slope_y, bend_x, bend_y = (w / (1 + r * r) for w, r in zip(weights, ratios, strict=True))
    return slope_x, slope_y, bend_x, bend_y


def _quarters(values: Array, mode: str) -> tuple[Array, Array, Array, Array]:
    even = np.pad(values, [(0, size % 2) for size in values.shape], mode=mode)  # type: ignore[call-overload]
    return even[::2, ::2], even[1::2, ::2], even[::2, 1::2], even[1::2, 1::2]


def _sum2(values: Array) -> Array:
    return sum(_quarters(values, "constant"))  # type: ignore[return-value]


def _max2(values: Array) -> Array:
    return np.maximum.reduce(_quarters(values, "edge"))


def _enlarged(values: Array, shape: tuple[int, ...]) -> Array:
    size = (2 * values.shape[1], 2 * values.shape[0])
    return np.ascontiguousarray(cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)[: shape[0], : shape[1]])
