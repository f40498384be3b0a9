"""An energy of samples, slopes and bending on a pixel grid, and its minimisation.

    E(u) = sum c (u - s)^2 + sum w_1 (first differences)^2 + sum w_2 (second differences)^2

along both axes. Its minimum is the fixed point of ILF, u <- S(samples where known, u elsewhere), with the low-pass
filter S = (1 + L)^-1, where L is the operator of the two smoothness terms: lower weights at edges make the filter
edge-aware.

Inner loops are written twice: in numpy, and as loops that are compiled if numba is installed. Their arrays are
contiguous float32 of shape (H, W), except weights between neighbours. Rows, or runs of cells, are summed in float32,
and these sums in float64.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import compiled, inner
from ...data.pixel_grids import strips
from ..banded import solve_grid

Array = NDArray[np.float32]

# Weights of differences between neighbours.


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of first and second differences.

    Attributes
    ----------
    framed : ndarray of float32, shape (4, H + 4, W)
        Weights of first differences along x and y and of second differences along x and y, at the first pixel of each;
        0 where there is no such difference, and in the two padding rows above and below.
    """

    framed: Array

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> Weights:
        """All 0, to be filled in."""
        return cls(np.zeros((4, shape[0] + 4, shape[1]), np.float32))

    @property
    def slope_x(self) -> Array:
        """Shape (H, W - 1)."""
        return self.framed[0, 2:-2, :-1]

    @property
    def slope_y(self) -> Array:
        """Shape (H - 1, W)."""
        return self.framed[1, 2:-3]

    @property
    def bend_x(self) -> Array:
        """Shape (H, W - 2)."""
        return self.framed[2, 2:-2, :-2]

    @property
    def bend_y(self) -> Array:
        """Shape (H - 2, W)."""
        return self.framed[3, 2:-4]

    def bent(self, times: np.float32) -> Weights:
        """Weights with those of second differences multiplied by a factor."""
        return Weights(self.framed * np.array([1, 1, times, times], np.float32)[:, None, None])

    def weaken(self, u: Array, scale: Array, slope_jumps: float) -> None:
        """Reduce them with Cauchy's function, in place, where differences of u are far above the scale.

        Parameters
        ----------
        u : ndarray, shape (H, W)
        scale : ndarray, shape (H, W)
            Second difference at which the weight is halved, in the unit of u.
        slope_jumps : float
            The same for first differences, in units of `scale`.
        """
        weaken_links(self.framed, u, scale, np.float32(slope_jumps))


def make_weights(
    smooth: Array,
    slope: float,
    bending: float,
    creases: Array | None = None,
    out: Weights | None = None,
) -> Weights:
    """Make weights from the smoothness of pixels.

    Parameters
    ----------
    smooth : ndarray of float32, shape (H, W)
        1 where a pixel is fully linked to its neighbours, 0 where it is separated from them. A difference has the
        smoothness of the least smooth of its pixels.
    slope, bending : float
        Weights of the two terms.
    creases : ndarray of float32, shape (H, W), optional
        Share by which the second difference around a pixel counts less: 1 at a crease, where the surface may bend, but
        not tear.
    out : Weights, optional
        Weights of this grid that are no longer needed; overwritten, to avoid allocation.
    """
    made = out or Weights.none(smooth.shape)
    link(smooth, np.float32(slope), np.float32(bending), creases, made.framed)
    return made


def _link(smooth: Array, slope: Any, bending: Any, creases: Array | None, out: Array) -> None:
    one, below, lower = np.float32(1), smooth[1:], smooth[2:]
    for y in range(smooth.shape[0]):
        here, straight, bent = smooth[y], out[0, y + 2], out[2, y + 2]
        right, after = here[1:], here[2:]
        for x in range(right.size):
            straight[x] = slope * min(here[x], right[x])
        for x in range(after.size):
            bent[x] = bending * min(min(here[x], right[x]), after[x])
        if y < below.shape[0]:
            straight, next_row = out[1, y + 2], below[y]
            for x in range(here.size):
                straight[x] = slope * min(here[x], next_row[x])
        if y < lower.shape[0]:
            bent, next_row, last_row = out[3, y + 2], below[y], lower[y]
            for x in range(here.size):
                bent[x] = bending * min(min(here[x], next_row[x]), last_row[x])
        if creases is not None:
            bent, crease = out[2, y + 2], creases[y, 1:]
            for x in range(after.size):
                bent[x] *= one - crease[x]
            if y < lower.shape[0]:
                bent, crease = out[3, y + 2], creases[y + 1]
                for x in range(here.size):
                    bent[x] *= one - crease[x]


@compiled(_link)
def link(smooth: Array, slope: np.float32, bending: np.float32, creases: Array | None, out: Array) -> None:
    """`make_weights`, into the array `Weights.framed`; entries without a difference are left as they are."""
    inside = out[:, 2:-2]
    for rows, *_ in strips(len(smooth)):
        # transposes are views; a strip along y reads the two rows after it, too
        for kind, here in enumerate((smooth[rows], smooth[rows.start : rows.stop + 2].T)):
            straight, bent = (part[rows].T if kind else part[rows] for part in (inside[kind], inside[2 + kind]))
            pairs = np.minimum(here[:, 1:], here[:, :-1])
            straight, bent = straight[:, : pairs.shape[1]], bent[:, : max(pairs.shape[1] - 1, 0)]
            np.multiply(slope, pairs[:, : straight.shape[1]], out=straight)
            np.multiply(bending, np.minimum(pairs[:, 1:], pairs[:, :-1])[:, : bent.shape[1]], out=bent)
            if creases is not None:
                around = creases[rows.start : rows.stop + 2].T if kind else creases[rows]
                bent *= 1 - around[:, 1 : 1 + bent.shape[1]]


def _weaken_links(weights: Array, u: Array, scale: Array, times: Any) -> None:
    values, scales, size = u.reshape(-1), scale.reshape(-1), np.uint64(u.size)
    row, rows, two = np.uint64(u.shape[1]), np.uint64(2 * u.shape[1]), np.float32(2)
    for kind in range(2):
        step = row if kind else np.uint64(1)
        slope, bend = weights[kind].reshape(-1), weights[2 + kind].reshape(-1)
        for i in range(max(size, step) - step):
            ratio = (values[i + step] - values[i]) / (times * scales[i + step])
            slope[rows + i] = slope[rows + i] / (np.float32(1) + ratio * ratio)
        for i in range(max(size, step + step) - step - step):
            ratio = (values[i + step + step] - two * values[i + step] + values[i]) / scales[i + step]
            bend[rows + i] = bend[rows + i] / (np.float32(1) + ratio * ratio)


@compiled(_weaken_links)
def weaken_links(weights: Array, u: Array, scale: Array, times: np.float32) -> None:
    """`Weights.weaken`, in the array `Weights.framed`; `times` is the scale of first differences relative to that of
    second ones."""
    inside = weights[:, 2:-2]
    for kind, (values, width) in enumerate(((u, scale), (u.T, scale.T))):
        slope, bend = (part.T if kind else part for part in (inside[kind], inside[2 + kind]))
        step = values[:, 1:] - values[:, :-1]
        ratio = step / (times * width[:, 1:])
        slope[:, :-1] /= 1 + ratio * ratio
        ratio = (step[:, 1:] - step[:, :-1]) / width[:, 1:-1]
        bend[:, :-2] /= 1 + ratio * ratio


# Minimisation: conjugate gradients with a diagonal preconditioner, or a direct solution.

_CONVERGED = 1e-14
"""Share of the first squared residual below which no further precision can be gained."""

_CELLS_AT_A_TIME = 2**18
"""Steps on small grids are made several at a time, up to this total of cells: about half a millisecond's work."""

_CHUNK = 1024
"""Number of cells whose products are summed in float32."""


class SmoothnessEnergy:
    """The energy on one grid.

    Parameters
    ----------
    counts : ndarray of float32, shape (H, W)
        Weight c of the samples; 0 where there is none, but positive somewhere in every connected part.
    totals : ndarray of float32, shape (H, W)
        c times the sample.
    weights : Weights
    """

    def __init__(self, counts: Array, totals: Array, weights: Weights) -> None:
        self._counts = counts
        self._totals = totals
        self._weights = weights

    def descend(
        self, u: Array, inputs: tuple[Array, Array, Array, Array], steady: float, limit: int
    ) -> Iterator[tuple[Array, Sums]]:
        """Minimise by conjugate gradients with a diagonal preconditioner, from u on; yields the approximations and the
        sums of their steps.

        Ends after `limit` steps, when they are steady, or at the precision of float32. Steps on small grids are made
        several at a time.

        Parameters
        ----------
        u : ndarray of float32, shape (H, W)
        inputs : tuple of ndarray of float32, shape (H, W)
            For the sums: number of the block's pixels in every cell, the trend that the surface is relative to, weights
            of the samples in the misfit, and weights times samples.
        steady : float
            Sum of squared changes below which the descent is steady.
        limit : int
        """
        weights, direction = self._weights.framed, framed(u)
        inverse = self._diagonal(np.float32)
        np.reciprocal(inverse, out=inverse)
        residual = np.empty_like(u)
        pull(self._counts, weights, direction, residual)
        direction[:] = 0
        np.subtract(self._totals, residual, out=residual)
        size, ratio = inner(residual, inverse * residual), 0.0
        least, changes = _CONVERGED * size, math.inf
        while limit > 0 and size > least and changes >= steady:
            many = min(limit, max(1, _CELLS_AT_A_TIME // u.size))
            found, sums = np.empty((many, *u.shape), np.float32), np.empty((many, len(Sums._fields)))
            state, sizes = (direction, residual), (size, ratio, least)
            steps, size, ratio = descend(self._counts, weights, inverse, state, sizes, inputs, steady, u, found, sums)
            limit -= steps
            for u, (changes, *others) in zip(found[:steps], sums.tolist(), strict=False):
                yield u, Sums(changes, *others)

    def minimum(self) -> Array:
        """The exact minimum, by a direct solution; for small grids."""
        weights = self._weights
        shape = self._counts.shape
        along_x = _couplings(weights.slope_x, weights.bend_x, shape)
        along_y = _couplings(weights.slope_y.T, weights.bend_y.T, shape[::-1])
        wanted = self._totals.astype(np.float64)[None]
        found = solve_grid(self._diagonal(np.float64), along_x, (along_y[0].T, along_y[1].T), wanted)
        return found[0].astype(np.float32)

    def _diagonal(self, dtype: type[np.floating]) -> NDArray[Any]:
        result = self._counts.astype(dtype)
        spread(self._weights.framed, result)
        return result


def _couplings(slope: Array, bend: Array, shape: tuple[int, ...]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Matrix entries between a pixel and the next, and the one after that, along the second axis."""
    near, far = np.zeros(shape), np.zeros(shape)
    near[:, :-1] -= slope
    near[:, :-2] -= 2 * bend
    near[:, 1:-1] -= 2 * bend
    far[:, :-2] += bend
    return near, far


# Inner loops of the descent.


class Sums(NamedTuple):
    """Sums over the pixels of one step.

    Attributes
    ----------
    changes, sizes : float
        Sums of (u - previous)^2 and of |u + trend| over the block's pixels.
    misfits : float
        Sum of counts u^2 - 2 totals u: squared differences from the samples, without the samples' own squares.
    """

    changes: float
    sizes: float
    misfits: float


def framed(values: Array) -> Array:
    """Pad values with two rows of zeros above and below: shape (H + 4, W).

    So indices two rows off a cell are in the array, and those two columns off, in the same, previous or next row.
    """
    result = np.zeros((values.shape[0] + 4, values.shape[1]), np.float32)
    result[2:-2] = values
    return result


def _pull(counts: Array, weights: Array, u: Array, out: Array) -> float:
    # flattened, with unsigned indices: otherwise it is not vectorised
    count, values, pulled = counts.reshape(-1), u.reshape(-1), out.reshape(-1)
    slope_x, slope_y = weights[0].reshape(-1), weights[1].reshape(-1)
    bend_x, bend_y = weights[2].reshape(-1), weights[3].reshape(-1)
    one, two = np.uint64(1), np.uint64(2)
    row, rows = np.uint64(counts.shape[1]), np.uint64(2 * counts.shape[1])
    twice, total = np.float32(2), 0.0
    for first in range(0, counts.size, _CHUNK):
        part = np.float32(0)
        for cell in range(np.uint64(first), np.uint64(min(first + _CHUNK, counts.size))):
            i = rows + cell
            before, left = values[i - one] - values[i - two], values[i] - values[i - one]
            right, after = values[i + one] - values[i], values[i + two] - values[i + one]
            upper, above = values[i - row] - values[i - rows], values[i] - values[i - row]
            below, lower = values[i + row] - values[i], values[i + rows] - values[i + row]
            along_x = slope_x[i - one] * left - slope_x[i] * right
            along_x += bend_x[i] * (after - right) - twice * bend_x[i - one] * (right - left)
            along_x += bend_x[i - two] * (left - before)
            along_y = slope_y[i - row] * above - slope_y[i] * below
            along_y += bend_y[i] * (lower - below) - twice * bend_y[i - row] * (below - above)
            along_y += bend_y[i - rows] * (above - upper)
            here = count[cell] * values[i] + along_x + along_y
            pulled[cell] = here
            part += here * values[i]
        total += float(part)
    return total


@compiled(_pull)
def pull(counts: Array, weights: Array, u: Array, out: Array) -> float:
    """Write half the gradient of the energy's quadratic part at u to `out`, and return its inner product with u.

    Parameters
    ----------
    counts : ndarray of float32, shape (H, W)
        Weight of the samples.
    weights : ndarray of float32, shape (4, H + 4, W)
        See `Weights.framed`.
    u : ndarray of float32, shape (H + 4, W)
        `framed`.
    out : ndarray of float32, shape (H, W)
    """
    inside = u[2:-2]
    np.multiply(counts, inside, out=out)
    slope_x, slope_y, bend_x, bend_y = weights[:, 2:-2]
    # transposes are views: adding along y writes to the same array
    for values, pulled, slope, bend in ((inside, out, slope_x, bend_x), (inside.T, out.T, slope_y.T, bend_y.T)):
        step = values[:, 1:] - values[:, :-1]
        flow = slope[:, :-1] * step
        turn = bend[:, :-2] * (step[:, 1:] - step[:, :-1])
        flow[:, :-1] -= turn
        flow[:, 1:] += turn
        pulled[:, :-1] -= flow
        pulled[:, 1:] += flow
    return inner(inside, out)


def _advance(inverse: Array, direction: Array, image: Array, length: Any, u: Array, residual: Array) -> float:
    total = 0.0
    for y in range(u.shape[0]):
        part = np.float32(0)
        for x in range(u.shape[1]):
            left = residual[y, x] - length * image[y, x]
            image[y, x] = u[y, x] + length * direction[y, x]
            residual[y, x] = left
            part += left * inverse[y, x] * left
        total += float(part)
    return total


@compiled(_advance)
def advance(inverse: Array, direction: Array, image: Array, length: np.float32, u: Array, residual: Array) -> float:
    """Make a step of conjugate gradients: update `residual` in place, and overwrite `image`, the energy's matrix times
    the direction, with u + length * direction.

    Returns
    -------
    float
        Inner product of the residual with the preconditioned one.
    """
    residual -= length * image
    np.add(u, length * direction, out=image)
    return inner(residual, inverse * residual)


def _turn(inverse: Array, residual: Array, share: Any, direction: Array) -> None:
    for y in range(direction.shape[0]):
        for x in range(direction.shape[1]):
            direction[y, x] = share * direction[y, x] + inverse[y, x] * residual[y, x]


@compiled(_turn)
def turn(inverse: Array, residual: Array, share: np.float32, direction: Array) -> None:
    """Compute the next direction in place: share times the last one plus the preconditioned residual."""
    direction *= share
    direction += inverse * residual


def _tally(
    u: Array, previous: Array, inside: Array, trend: Array, counts: Array, totals: Array
) -> tuple[float, float, float]:
    two = np.float32(2)
    changes, sizes, misfits = 0.0, 0.0, 0.0
    for y in range(u.shape[0]):
        change_part, size_part, misfit_part = np.float32(0), np.float32(0), np.float32(0)
        for x in range(u.shape[1]):
            here = u[y, x]
            change = here - previous[y, x]
            change_part += inside[y, x] * (change * change)
            size_part += inside[y, x] * abs(here + trend[y, x])
            misfit_part += (counts[y, x] * here - two * totals[y, x]) * here
        changes += float(change_part)
        sizes += float(size_part)
        misfits += float(misfit_part)
    return changes, sizes, misfits


@compiled(_tally)
def tally(
    u: Array, previous: Array, inside: Array, trend: Array, counts: Array, totals: Array
) -> tuple[float, float, float]:
    """Compute the `Sums` of a step from `previous` to u; `inside` contains the weights of the pixels."""
    change = u - previous
    sizes = inner(inside, np.abs(u + trend))
    return inner(inside, change * change), sizes, inner(counts * u - 2 * totals, u)


@compiled()
def descend(
    counts: Array,
    weights: Array,
    inverse: Array,
    state: tuple[Array, Array],
    sizes: tuple[float, float, float],
    inputs: tuple[Array, ...],
    steady: float,
    start: Array,
    found: Array,
    sums: NDArray[np.float64],
) -> tuple[int, float, float]:
    """Make steps of conjugate gradients, as many as fit into `found`, or until they are steady or have converged.

    Parameters
    ----------
    counts : ndarray
        Weight of the samples.
    weights : ndarray
        As for `pull`.
    inverse : ndarray
        The preconditioner.
    state : tuple of ndarray
        Direction, `framed`, and residual of the previous step; updated in place.
    sizes : tuple of float
        Squared size of the residual, its ratio to that of the previous step, and the minimum size to continue.
    inputs : tuple of ndarray
        Arguments of `tally` after the surfaces.
    steady : float
        Sum of squared changes below which iteration stops.
    start : ndarray
        The initial surface.
    found : ndarray of float32, shape (K, H, W)
        Receives the surfaces.
    sums : ndarray of float64, shape (K, 3)
        Receives the `Sums` of each.

    Returns
    -------
    steps : int
        Number of steps.
    size, ratio : float
        See `sizes`. The size is 0 if only rounding is left.
    """
    framed_direction, residual = state
    direction = framed_direction[2:-2]
    inside, trend, samples, totals = inputs
    size, ratio, least = sizes
    u = start
    for step in range(len(found)):
        if not size > least:
            return step, size, ratio
        turn(inverse, residual, np.float32(ratio), direction)
        better = found[step]
        curvature = pull(counts, weights, framed_direction, better)
        if curvature <= 0:
            return step, 0.0, ratio
        left = advance(inverse, direction, better, np.float32(size / curvature), u, residual)
        size, ratio = left, left / size
        sums[step, 0], sums[step, 1], sums[step, 2] = tally(better, u, inside, trend, samples, totals)
        u = better
        if sums[step, 0] < steady:
            return step + 1, size, ratio
    return len(found), size, ratio


def _spread(weights: Array, out: NDArray[Any]) -> None:
    diagonal = out.reshape(-1)
    slope_x, slope_y = weights[0].reshape(-1), weights[1].reshape(-1)
    bend_x, bend_y = weights[2].reshape(-1), weights[3].reshape(-1)
    one, two, four = np.uint64(1), np.uint64(2), np.float32(4)
    row, rows = np.uint64(out.shape[1]), np.uint64(2 * out.shape[1])
    for cell in range(np.uint64(out.size)):
        i = rows + cell
        here = diagonal[cell] + slope_x[i - one] + slope_x[i]  # in the precision of `out`
        here = here + bend_x[i - two] + four * bend_x[i - one] + bend_x[i]
        here = here + slope_y[i - row] + slope_y[i]
        diagonal[cell] = here + bend_y[i - rows] + four * bend_y[i - row] + bend_y[i]


@compiled(_spread)
def spread(weights: Array, out: NDArray[Any]) -> None:
    """Add the smoothness terms to the diagonal of the energy's matrix, in place.

    Parameters
    ----------
    weights : ndarray of float32, shape (4, H + 4, W)
        See `Weights.framed`.
    out : ndarray of float32 or float64, shape (H, W)
    """
    slope_x, slope_y, bend_x, bend_y = weights[:, 2:-2]
    for diagonal, slope, bend in ((out, slope_x, bend_x), (out.T, slope_y.T, bend_y.T)):
        diagonal[:, 1:] += slope[:, :-1]
        diagonal[:, :-1] += slope[:, :-1]
        diagonal[:, 2:] += bend[:, :-2]
        diagonal[:, 1:-1] += 4 * bend[:, :-2]
        diagonal[:, :-2] += bend[:, :-2]
