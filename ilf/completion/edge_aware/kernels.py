"""The inner loops of the edge-aware iteration: each in numpy, and as loops that are compiled if numba is installed.

All arrays are contiguous float32 of shape (H, W), except weights between neighbours. Rows, or runs of cells, are summed
in float32, and these sums in float64.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import compiled, inner
from ...data.pixel_grids import strips

Array = NDArray[np.float32]

_CHUNK = 1024
"""Number of cells whose products are summed in float32."""


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
    """Write the weights of differences, from the smoothness at pixels: a difference has that of its least smooth one.

    Parameters
    ----------
    smooth : ndarray of float32, shape (H, W)
        From 1, fully linked to its neighbours, to 0.
    slope, bending : float32
        Weights of first and of second differences.
    creases : ndarray of float32, shape (H, W), or None
        Share by which a second difference around a pixel counts less.
    out : ndarray of float32, shape (4, H + 4, W)
        See `Weights.framed`; entries without a difference are left as they are.
    """
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
    """Reduce weights of differences with Cauchy's function, in place: halved where a difference equals its scale.

    Parameters
    ----------
    weights : ndarray of float32, shape (4, H + 4, W)
        See `Weights.framed`.
    u, scale : ndarray of float32, shape (H, W)
        Surface, and scale of second differences.
    times : float32
        Ratio of the scale of first differences to it.
    """
    inside = weights[:, 2:-2]
    for kind, (values, width) in enumerate(((u, scale), (u.T, scale.T))):
        slope, bend = (part.T if kind else part for part in (inside[kind], inside[2 + kind]))
        step = values[:, 1:] - values[:, :-1]
        ratio = step / (times * width[:, 1:])
        slope[:, :-1] /= 1 + ratio * ratio
        ratio = (step[:, 1:] - step[:, :-1]) / width[:, 1:-1]
        bend[:, :-2] /= 1 + ratio * ratio
