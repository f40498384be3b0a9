"""An energy of samples, slopes and bending on a pixel grid, and the ways to its minimum.

    E(u) = sum c (u - s)^2 + sum w_1 (first differences)^2 + sum w_2 (second differences)^2

along both axes. Its minimum is the fixed point of ILF, u <- S(samples where known, u elsewhere), with the low-pass
filter S = (1 + L)^-1, where L is the operator of the two smoothness terms: weights that fall at edges make the filter
edge-aware.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..sums import inner

Array = NDArray[np.float32]

_CONVERGED = 1e-14
"""Share of the first squared residual below which there are no digits left to gain."""


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of first and second differences, float32.

    Attributes
    ----------
    slope_x, slope_y : ndarray, shapes (H, W - 1) and (H - 1, W)
    bend_x, bend_y : ndarray, shapes (H, W - 2) and (H - 2, W)
    """

    slope_x: Array
    slope_y: Array
    bend_x: Array
    bend_y: Array

    def bent(self, times: np.float32) -> Weights:
        """Weights with those of second differences so many times as large."""
        return Weights(self.slope_x, self.slope_y, times * self.bend_x, times * self.bend_y)

    def loosened(self, u: Array, scale: Array, slope_jumps: float) -> Weights:
        """Weights by Cauchy's rule: differences of u far above the scale let go.

        Parameters
        ----------
        u : ndarray, shape (H, W)
        scale : ndarray, shape (H, W)
            Second difference at which the weight is halved, in the unit of u.
        slope_jumps : float
            The same for first differences, in units of `scale`.
        """
        x, y = u[:, 1:] - u[:, :-1], u[1:] - u[:-1]
        slope_scale = np.float32(slope_jumps) * scale
        return Weights(
            _let_go(self.slope_x, x, slope_scale[:, 1:]),
            _let_go(self.slope_y, y, slope_scale[1:]),
            _let_go(self.bend_x, x[:, 1:] - x[:, :-1], scale[:, 1:-1]),
            _let_go(self.bend_y, y[1:] - y[:-1], scale[1:-1]),
        )


def make_weights(smooth_x: Array, smooth_y: Array, slope: float, bending: float, stiff: Array | None = None) -> Weights:
    """Weights from how much of the smoothness is left between neighbours.

    Parameters
    ----------
    smooth_x, smooth_y : ndarray of float32, shapes (H, W - 1) and (H - 1, W)
        1 where nothing parts two neighbours, 0 where everything does. A second difference is worth as much as the
        less smooth of its two pairs.
    slope, bending : float
        Weights of the two terms.
    stiff : ndarray of float32, shape (H, W), optional
        How much of the second difference around a pixel counts, from 1, all, to 0, none, where the surface has a
        crease: it may bend there, but not tear.
    """
    first, second = np.float32(slope), np.float32(bending)
    bend_x = second * np.minimum(smooth_x[:, 1:], smooth_x[:, :-1])
    bend_y = second * np.minimum(smooth_y[1:], smooth_y[:-1])
    if stiff is not None:
        bend_x, bend_y = bend_x * stiff[:, 1:-1], bend_y * stiff[1:-1]
    return Weights(first * smooth_x, first * smooth_y, bend_x, bend_y)


class SmoothnessEnergy:
    """The energy on one grid.

    Parameters
    ----------
    counts : ndarray of float32, shape (H, W)
        Weight c of the samples; 0 where there is none, but more than 0 somewhere in every connected part.
    totals : ndarray of float32, shape (H, W)
        c times the sample.
    weights : Weights
    """

    def __init__(self, counts: Array, totals: Array, weights: Weights) -> None:
        self._counts = counts
        self._totals = totals
        self._weights = weights

    def descend(self, start: Array) -> Iterator[Array]:
        """Conjugate gradients with a diagonal preconditioner: one approximation of the minimum after the other.

        Ends by itself where float32 can come no nearer.
        """
        inverse = 1 / self._diagonal(np.float32)
        u = start
        residual = self._totals - self._image(u)
        scaled = inverse * residual
        direction = scaled.copy()
        size = inner(residual, scaled)
        least = _CONVERGED * size
        while size > least:
            image = self._image(direction)
            curvature = inner(direction, image)
            if curvature <= 0:
                return  # rounding is all that is left
            length = np.float32(size / curvature)
            u = np.add(u, length * direction)
            yield u
            residual -= length * image
            scaled = inverse * residual
            previous, size = size, inner(residual, scaled)
            direction *= np.float32(size / previous)
            direction += scaled

    def minimum(self) -> Array:
        """The minimum itself, by a sparse direct solution; for small grids."""
        height, width = self._counts.shape
        size = height * width
        near_x, far_x = _couplings(self._weights.slope_x, self._weights.bend_x, (height, width))
        down = _couplings(self._weights.slope_y.T, self._weights.bend_y.T, (width, height))
        numbers = np.arange(size)
        rows, columns = [numbers], [numbers]
        entries = [self._diagonal(np.float64).ravel()]
        for values, offset in ((near_x, 1), (far_x, 2), (down[0].T, width), (down[1].T, 2 * width)):
            here, there = numbers[:-offset], numbers[offset:]
            band = values.ravel()[: here.size]
            rows += [here, there]
            columns += [there, here]
            entries += [band, band]
        places = np.concatenate(rows), np.concatenate(columns)
        matrix = coo_array((np.concatenate(entries), places), shape=(size, size)).tocsc()
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        found = factors.solve(self._totals.astype(np.float64).ravel())
        return found.reshape(height, width).astype(np.float32)

    def _image(self, u: Array) -> Array:
        """Half the gradient of the quadratic part."""
        weights = self._weights
        result = self._counts * u
        # the transposes give views: what is added along y lands in the same array
        for values, out, slope, bend in (
            (u, result, weights.slope_x, weights.bend_x),
            (u.T, result.T, weights.slope_y.T, weights.bend_y.T),
        ):
            step = values[:, 1:] - values[:, :-1]
            flow = slope * step
            turn = bend * (step[:, 1:] - step[:, :-1])
            flow[:, :-1] -= turn
            flow[:, 1:] += turn
            out[:, :-1] -= flow
            out[:, 1:] += flow
        return result

    def _diagonal(self, dtype: type[np.floating]) -> NDArray[Any]:
        weights = self._weights
        result = self._counts.astype(dtype)
        for out, slope, bend in (
            (result, weights.slope_x, weights.bend_x),
            (result.T, weights.slope_y.T, weights.bend_y.T),
        ):
            out[:, 1:] += slope
            out[:, :-1] += slope
            out[:, 2:] += bend
            out[:, 1:-1] += 4 * bend
            out[:, :-2] += bend
        return result


def _couplings(slope: Array, bend: Array, shape: tuple[int, int]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Matrix entries between a pixel and the next, and the one after that, along the second axis."""
    near, far = np.zeros(shape), np.zeros(shape)
    near[:, :-1] -= slope
    near[:, :-2] -= 2 * bend
    near[:, 1:-1] -= 2 * bend
    far[:, :-2] += bend
    return near, far


def _let_go(weights: Array, difference: Array, scale: Array) -> Array:
    ratio = difference / scale
    return weights / (1 + ratio * ratio)
