"""The inner loops of the edge-aware iteration: each in numpy, and as loops that are compiled where numba is installed.

All arrays are float32 of shape (H, W) and contiguous, but for weights between neighbours. Sums are those of rows in
float32, added up in float64.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiling import compiled
from ..sums import inner

Array = NDArray[np.float32]


def _pull(counts: Array, slope_x: Array, slope_y: Array, bend_x: Array, bend_y: Array, u: Array, out: Array) -> float:
    height, width = u.shape
    two = np.float32(2)
    # along x, with a 0 before the first pair of neighbours and one after the last
    turn, flow = np.zeros(width + 1, np.float32), np.zeros(width + 1, np.float32)
    next_turn, next_flow = turn[1:], flow[1:]
    # along y, of this row and the one above
    turn_here, turn_above = np.zeros(width, np.float32), np.zeros(width, np.float32)
    flow_here, flow_above = np.zeros(width, np.float32), np.zeros(width, np.float32)
    total = 0.0
    for y in range(height):
        # one short loop after the other: more arrays in one, and it is not vectorised
        row, pulled, count = u[y], out[y], counts[y]
        slope, bend = slope_x[y], bend_x[y]
        left, right, beyond = row[:-1], row[1:], row[2:]
        for x in range(width - 2):
            next_turn[x] = bend[x] * (beyond[x] - two * right[x] + left[x])
        for x in range(width - 1):
            next_flow[x] = slope[x] * (right[x] - left[x]) - next_turn[x] + turn[x]
        for x in range(width):
            pulled[x] = count[x] * row[x] + flow[x] - next_flow[x]
        turn_here[:] = 0
        flow_here[:] = 0
        if y < height - 2:
            bend, below, lower = bend_y[y], u[y + 1], u[y + 2]
            for x in range(width):
                turn_here[x] = bend[x] * (lower[x] - two * below[x] + row[x])
        if y < height - 1:
            slope, below = slope_y[y], u[y + 1]
            for x in range(width):
                flow_here[x] = slope[x] * (below[x] - row[x]) - turn_here[x] + turn_above[x]
        part = np.float32(0)
        for x in range(width):
            pulled[x] += flow_above[x] - flow_here[x]
            part += pulled[x] * row[x]
        total += float(part)
        turn_here, turn_above = turn_above, turn_here
        flow_here, flow_above = flow_above, flow_here
    return total


@compiled(_pull)
def pull(counts: Array, slope_x: Array, slope_y: Array, bend_x: Array, bend_y: Array, u: Array, out: Array) -> float:
    """Half the gradient of the energy's quadratic part at u, written to `out`, and its inner product with u.

    Parameters
    ----------
    counts : ndarray
        Weight of the samples.
    slope_x, slope_y, bend_x, bend_y : ndarray
        See `Weights`.
    u, out : ndarray
    """
    np.multiply(counts, u, out=out)
    # the transposes give views: what is added along y lands in the same array
    for values, pulled, slope, bend in ((u, out, slope_x, bend_x), (u.T, out.T, slope_y.T, bend_y.T)):
        step = values[:, 1:] - values[:, :-1]
        flow = slope * step
        turn = bend * (step[:, 1:] - step[:, :-1])
        flow[:, :-1] -= turn
        flow[:, 1:] += turn
        pulled[:, :-1] -= flow
        pulled[:, 1:] += flow
    return inner(u, out)


def _advance(
    inverse: Array, direction: Array, image: Array, length: Any, u: Array, out: Array, residual: Array
) -> float:
    total = 0.0
    for y in range(u.shape[0]):
        part = np.float32(0)
        for x in range(u.shape[1]):
            out[y, x] = u[y, x] + length * direction[y, x]
            left = residual[y, x] - length * image[y, x]
            residual[y, x] = left
            part += left * inverse[y, x] * left
        total += float(part)
    return total


@compiled(_advance)
def advance(
    inverse: Array, direction: Array, image: Array, length: np.float32, u: Array, out: Array, residual: Array
) -> float:
    """A step of conjugate gradients: u + length * direction, written to `out`, and the residual that is left, in place.

    Returns
    -------
    float
        Inner product of the residual with the preconditioned one.
    """
    np.add(u, length * direction, out=out)
    residual -= length * image
    return inner(residual, inverse * residual)


def _turn(inverse: Array, residual: Array, share: Any, direction: Array) -> None:
    for y in range(direction.shape[0]):
        for x in range(direction.shape[1]):
            direction[y, x] = share * direction[y, x] + inverse[y, x] * residual[y, x]


@compiled(_turn)
def turn(inverse: Array, residual: Array, share: np.float32, direction: Array) -> None:
    """The next direction, in place: a share of the last one and the preconditioned residual."""
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
    """What the record of an iteration tells of.

    Returns
    -------
    changes, sizes : float
        Over the pixels that `inside` counts, the sums of (u - previous)^2 and of |u + trend|.
    misfits : float
        Sum of counts u^2 - 2 totals u: of squared differences to the samples, but for the samples' own squares.
    """
    change = u - previous
    sizes = inner(inside, np.abs(u + trend))
    return inner(inside, change * change), sizes, inner(counts * u - 2 * totals, u)


def _spread(slope_x: Array, slope_y: Array, bend_x: Array, bend_y: Array, out: NDArray[Any]) -> None:
    height, width = out.shape
    one, four = np.float32(1), np.float32(4)
    for y in range(height):
        row = out[y]
        slope, bend = slope_x[y], bend_x[y]
        right, beyond = row[1:], row[2:]
        for x in range(width - 1):
            right[x] += slope[x]
        for x in range(width - 1):
            row[x] += slope[x]
        for x in range(width - 2):
            beyond[x] += bend[x]
        for x in range(width - 2):
            right[x] += four * bend[x]
        for x in range(width - 2):
            row[x] += bend[x]
        for off in range(3):
            if off < 2 and 0 <= y - off < height - 1:
                slope = slope_y[y - off]
                for x in range(width):
                    row[x] += slope[x]
            if 0 <= y - off < height - 2:
                bend = bend_y[y - off]
                times = four if off == 1 else one
                for x in range(width):
                    row[x] += times * bend[x]


@compiled(_spread)
def spread(slope_x: Array, slope_y: Array, bend_x: Array, bend_y: Array, out: NDArray[Any]) -> None:
    """Add the smoothness terms' share in the diagonal of the energy's matrix, in place.

    Parameters
    ----------
    slope_x, slope_y, bend_x, bend_y : ndarray
        See `Weights`.
    out : ndarray of float32 or float64
    """
    for diagonal, slope, bend in ((out, slope_x, bend_x), (out.T, slope_y.T, bend_y.T)):
        diagonal[:, 1:] += slope
        diagonal[:, :-1] += slope
        diagonal[:, 2:] += bend
        diagonal[:, 1:-1] += 4 * bend
        diagonal[:, :-2] += bend


def _let_go(weights: Array, down: int, right: int, second: bool, u: Array, scale: Array, times: Any) -> Array:
    one, two = np.float32(1), np.float32(2)
    out = np.empty_like(weights)
    for y in range(weights.shape[0]):
        weight, left = weights[y], out[y]
        here, there, width = u[y], u[y + down, right:], scale[y + down, right:]
        if second:
            beyond = u[y + 2 * down, 2 * right :]
            for x in range(weights.shape[1]):
                ratio = (beyond[x] - two * there[x] + here[x]) / (times * width[x])
                left[x] = weight[x] / (one + ratio * ratio)
        else:
            for x in range(weights.shape[1]):
                ratio = (there[x] - here[x]) / (times * width[x])
                left[x] = weight[x] / (one + ratio * ratio)
    return out


@compiled(_let_go)
def let_go(weights: Array, down: int, right: int, second: bool, u: Array, scale: Array, times: np.float32) -> Array:
    """Weights of differences by Cauchy's rule: halved where a difference is as large as its scale.

    Parameters
    ----------
    weights : ndarray
        Of the differences between neighbours along y (`down` is 1) or x (`right` is 1), first or second ones.
    down, right : int
    second : bool
    u, scale : ndarray
    times : float32
        Factor on the scale.
    """
    height, width = weights.shape
    here, there = u[:height, :width], u[down : down + height, right : right + width]
    difference = there - here
    if second:
        difference = u[2 * down :, 2 * right :] - there - difference
    ratio = difference / (times * scale[down : down + height, right : right + width])
    return weights / (1 + ratio * ratio)
