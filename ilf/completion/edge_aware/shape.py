"""The overall shape of a block's known depth, and its noise."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..._runtime.compiling import compiled
from ...data.frame import FARTHEST_DEPTH
from ...data.pixel_grids import cells_of, strips
from ..banded import empty_band, solve_band
from .noise import Noise

Array = NDArray[np.float64]

# The plane that a block's known depth lies on or, if it lies much closer to one, a quadric, refined by a stiff sheet.

_ROUNDS = 4
"""Rounds of reweighting, which reduce the weight of outliers from the shape."""

_NEAR_SHARE = 0.02
"""A cell lies on a shape if its mean is off by less than this share of its depth or three deviations of noise."""

_FAR_SHARE = 0.05
"""A pixel that is off its cell's median by more than this share of depth is ignored."""

_REACH = 0.5
"""Maximum excess of the surface over the range of the known depth, in widths of that range."""

_LEAST_SHARE, _LEAST_PLANE_SHARE = 0.8, 0.5
"""Minimum share of a block's known depth that lies on the quadric, and on the plane, which extrapolates more safely."""

_CLOSER = 0.5
"""A quadric replaces the plane if four fifths of the cells are off by less than this share of what they are from it."""

_CELLS = 800
"""Approximate number of cells of the grid for the fit."""

_STIFFNESS = 1e9
"""Weight of squared third differences [per pixel] in the sheet that refines the quadric; they are 0 for quadrics."""

_MIXED = 30
"""Weight of mixed third differences, relative to the others: a profile continues unchanged across a wide hole."""

_AT_ONCE = 1 << 18
"""Number of pixels processed at a time, in whole cells, to limit memory."""

_POWERS = tuple((a, b) for a in range(3) for b in range(3 - a))
"""Powers of y and x in the terms of a quadric."""

_OF_A_PLANE = [k for k, powers in enumerate(_POWERS) if sum(powers) < 2]
"""Which of them a plane has, of which inverse depth is a linear function."""


@dataclass(frozen=True, eq=False)
class Trend:
    """The surface that a block's known depth lies on.

    Attributes
    ----------
    surface : ndarray of float32, shape (h, w)
        Depth [m] in the whole requested region.
    spread : float
        Standard deviation of the known depth from it [m] beyond noise.
    """

    surface: NDArray[np.float32]
    spread: float


def noise_of(depth: NDArray[np.float32], mask: NDArray[np.bool_]) -> float:
    """Estimate the standard deviation of the known depth's noise [m] from the median of second differences.

    Parameters
    ----------
    depth : ndarray of float32, shape (h, w)
        Depth [m], NaN = missing.
    mask : ndarray of bool, shape (h, w)
        The pixels to use. The result is 0.0 if there are fewer than 20 triples in rows and columns.
    """
    found = _bends(np.ascontiguousarray(depth), np.ascontiguousarray(mask))
    if found.size < 20:
        return 0.0
    # for independent noise, the variance of a second difference is 1 + 4 + 1 times as large
    return float(np.median(found)) / 0.6745 / math.sqrt(6.0)


def _bends_one_by_one(depth: NDArray[np.float32], mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    height, width = depth.shape
    inside = np.empty_like(depth)
    for y in range(height):
        for x in range(width):
            inside[y, x] = depth[y, x] if mask[y, x] else np.float32(np.nan)
    found, count, two = np.empty(2 * depth.size + 1, depth.dtype), 0, np.float32(2)
    for y in range(height):
        for x in range(width):
            if x + 2 < width:
                found[count] = abs(inside[y, x] - two * inside[y, x + 1] + inside[y, x + 2])
                count += np.isfinite(found[count])
            if y + 2 < height:
                found[count] = abs(inside[y, x] - two * inside[y + 1, x] + inside[y + 2, x])
                count += np.isfinite(found[count])
    return found[:count]


@compiled(_bends_one_by_one)
def _bends(depth: NDArray[np.float32], mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Absolute second differences along rows and columns of the masked depth, in any order."""
    inside = np.where(mask, depth, np.float32(np.nan))
    seconds = [a[:, :-2] - 2 * a[:, 1:-1] + a[:, 2:] for a in (inside, inside.T)]
    return np.abs(np.concatenate([values[np.isfinite(values)] for values in seconds]))


def trend_of(depth: NDArray[np.float32], mask: NDArray[np.bool_], noise: float) -> Trend | None:
    """Fit a plane to the block's known depth or, if it lies much closer to one, a quadric, which a stiff sheet refines
    where the depth deviates.

    Parameters
    ----------
    depth : ndarray of float32, shape (h, w)
        Depth [m], NaN = missing, in the region of the surface.
    mask : ndarray of bool, shape (h, w)
        The block's pixels; only their depth is used.
    noise : float
        Standard deviation of the depth's noise [m].

    Returns
    -------
    Trend or None
        None if too little of the depth lies on one quadric or plane.
    """
    known = mask & np.isfinite(depth)
    height, width = depth.shape
    cell = max(1, math.ceil(math.sqrt(height * width / _CELLS)))
    parts = [rows for rows, *_ in strips(height, rows=cell * max(1, _AT_ONCE // (cell * width)))]
    for rows in parts:
        medians = _medians(np.where(known[rows], depth[rows], np.float32(np.nan)), cell)
        known[rows] &= np.abs(depth[rows] - medians) < np.maximum(_FAR_SHARE * medians, 3 * noise)
    counts = np.concatenate([cell_sums(known[rows], cell) for rows in parts])
    totals = np.concatenate([cell_sums(np.where(known[rows], depth[rows], 0.0), cell) for rows in parts])
    held = counts > 0
    if np.count_nonzero(held) < 3 * len(_POWERS):
        return None
    values, weights = totals[held] / counts[held], counts[held]
    near = np.maximum(_NEAR_SHARE * values, 3 * noise / np.sqrt(weights))
    y, x = (np.linspace(-1, 1, size) for size in counts.shape)
    basis = np.stack([(y**a)[:, None] * (x**b)[None, :] for a, b in _POWERS], axis=2)[held]
    found = _best_shape(basis, values, weights, near)
    if found is None:
        return None
    coefficients, off, inverse = found
    lies_on_it = off < near

    # relative to the shape, a cell's mean is valid at its centre wherever the known pixels are in the cell
    shape = partial(_shape, coefficients, inverse, (height, width), cell)
    rests = np.concatenate([cell_sums(np.where(known[rows], depth[rows] - shape(rows), 0.0), cell) for rows in parts])
    trusted = counts.copy()
    trusted[held] = np.where(lies_on_it, weights, 0.0)
    sheet = np.zeros(counts.shape) if inverse else _sheet(trusted, rests, cell)
    size = counts.shape[1] * cell, counts.shape[0] * cell
    refined = cv2.resize(sheet, size, interpolation=cv2.INTER_CUBIC)
    low, high = float(values[lies_on_it].min()), float(values[lies_on_it].max())
    reach = _REACH * (high - low)
    surface = np.empty((height, width), np.float32)
    for rows in parts:
        surface[rows] = np.clip(shape(rows) + refined[rows, :width], low - reach, high + reach)
    return Trend(surface, _spread(rests, counts, sheet, noise))


def _best_shape(basis: Array, values: Array, weights: Array, near: Array) -> tuple[Array, Array, bool] | None:
    """The coefficients of the plane or quadric that the cells lie on, how far they are off, and whether it is a plane;
    None if too few lie on either.

    Where known depth ends, a quadric goes on bending, so a plane is preferred unless the depth clearly contradicts it.
    """
    plane, quadric = (_fitted_shape(basis, values, weights, near, inverse) for inverse in (True, False))
    on_plane, on_quadric = (weights[off < near].sum() / weights.sum() for _, off in (plane, quadric))
    off_plane, off_quadric = (np.quantile(off, _LEAST_SHARE) for _, off in (plane, quadric))
    if on_quadric >= _LEAST_SHARE and off_quadric < _CLOSER * off_plane:
        return *quadric, False
    return (*plane, True) if on_plane >= _LEAST_PLANE_SHARE else None


def _fitted_shape(basis: Array, values: Array, weights: Array, near: Array, inverse: bool) -> tuple[Array, Array]:
    """Coefficients of the quadric, or of the plane of inverse depth, through most of the cells' means, and how far
    these are off [m]."""
    used = _OF_A_PLANE if inverse else slice(None)
    # an error of inverse depth is one of depth times its square
    terms, target, scale = basis[:, used], 1 / values if inverse else values, values**2 if inverse else 1
    coefficients, trust = np.zeros(len(_POWERS)), np.ones(values.size)
    for _ in range(_ROUNDS):
        root = np.sqrt(weights * trust) * scale
        coefficients[used], *_rest = np.linalg.lstsq(terms * root[:, None], target * root, rcond=None)
        off = np.abs(values - _as_depth(basis @ coefficients, inverse))
        trust = 1 / (1 + (off / near) ** 2)
    return coefficients, off


def _as_depth(values: Array, inverse: bool) -> Array:
    return 1 / np.maximum(values, 1 / FARTHEST_DEPTH) if inverse else values


def _shape(
    coefficients: NDArray[np.floating], inverse: bool, shape: tuple[int, int], cell: int, rows: slice
) -> NDArray[np.float64]:
    """The quadric or plane at the pixels of some rows; -1 and 1 are the centres of the first and the last cell."""
    y, x = ((np.arange(size) - (cell - 1) / 2) / (cell * max(-(-size // cell) - 1, 1) / 2) - 1 for size in shape)
    square = np.zeros((3, 3))
    square[tuple(zip(*_POWERS, strict=True))] = coefficients
    along_x = square @ np.vander(x, 3, increasing=True).T
    # threads of BLAS would spin longer than they work
    return _as_depth(np.einsum("ya,ax->yx", np.vander(y[rows], 3, increasing=True), along_x), inverse)


def _sheet(counts: NDArray[np.float64], totals: NDArray[np.float64], cell: int) -> NDArray[np.float64]:
    """A stiff sheet through the cells' samples; `totals` of cells without a count are ignored."""
    if counts.shape[0] < counts.shape[1]:  # the band is narrower along the shorter side
        return _sheet(counts.T, totals.T, cell).T
    wanted = np.where(counts > 0, totals, 0.0).reshape(1, -1)
    least = 1e-6
    while True:
        band = _third_differences(*counts.shape) * (_STIFFNESS / cell**4)
        band[:, 0] += counts.ravel() + least
        found = solve_band(band, wanted.copy())
        if np.isfinite(found).all():
            return found.reshape(counts.shape)
        least *= 10  # samples in a row or a corner hold the sheet by less than rounding


def _spread(
    totals: NDArray[np.float64], counts: NDArray[np.float64], surface: NDArray[np.float64], noise: float
) -> float:
    """Standard deviation [m] of the cells' means from a surface, less the part due to noise."""
    held = counts > 0
    squares = (totals[held] / counts[held] - surface[held]) ** 2 - noise**2 / counts[held]
    return math.sqrt(max(float(np.average(squares, weights=counts[held])), 0.0))


def cell_sums(values: NDArray[Any], cell: int) -> NDArray[np.float64]:
    """Sums over cells of cell x cell pixels."""
    rows, columns = (np.arange(0, size, cell) for size in values.shape)
    return np.add.reduceat(np.add.reduceat(values.astype(np.float64, copy=False), rows, axis=0), columns, axis=1)


def _medians(values: NDArray[np.float32], cell: int) -> NDArray[np.float32]:
    """At every pixel, the (lower) median of the known depth in its cell; NaN if there is none."""
    height, width = values.shape
    cells = cells_of(values, cell, value=math.nan).swapaxes(1, 2)
    ordered = np.sort(cells.reshape(*cells.shape[:2], -1), axis=2)  # NaN last
    middle = np.maximum(np.isfinite(ordered).sum(axis=2) - 1, 0) // 2
    medians = np.take_along_axis(ordered, middle[..., None], axis=2)[..., 0]
    return medians.repeat(cell, axis=0).repeat(cell, axis=1)[:height, :width]


_DIFFERENCES = ((1,), (1, -1), (1, -2, 1), (1, -3, 3, -1))
"""Factors of the values in a difference of order 0, 1, 2 and 3."""


def _third_differences(height: int, width: int) -> Array:
    """`empty_band` with the operator of the sum of squared third differences, the mixed ones weighted most: f(x) + g(y)
    is smooth."""
    band = empty_band(height * width, 3 * width)
    for order, times in enumerate((1, _MIXED, _MIXED, 1)):
        other = 3 - order
        for down, right in itertools.product(range(order + 1), range(-other, other + 1)):
            if height > order and width > other and (down > 0 or right >= 0):
                entries = band[:, down * width + right].reshape(height, width)  # a view
                entries = entries[: height - down, max(0, -right) : width - max(0, right)]
                entries += times * np.outer(_squared(height, order, down), _squared(width, other, abs(right)))
    return band


def _squared(size: int, order: int, off: int) -> Array:
    """A diagonal of the operator of the sum of squared differences along an axis, so many entries off the main one."""
    factors = _DIFFERENCES[order]
    products = [a * b for a, b in zip(factors, factors[off:], strict=False)]
    return np.convolve(np.ones(size - order), products)


# The polynomial that fits a block's known depth to within its noise, with significant terms only.

_ORDERS = (8, 6, 4, 2)
"""Maximum total degree: the first for which the polynomial is certain enough in gaps."""

_ORDER = _ORDERS[0]

_BORNE_OUT = 2.0
"""A term has full weight far above its standard deviation due to noise, and none below so many of these."""

_OWN = 0.02
"""Additional error of cells' means, in deviations of a pixel's noise, whatever their number of pixels."""

_CERTAIN, _CERTAIN_SHARE = 0.05, 0.0005
"""Maximum deviation of the polynomial in gaps due to noise, in deviations of a pixel's noise or as a share of depth."""

_DETERMINED = 1e-6
"""The cells determine the terms if the smallest diagonal element is more than this share of the largest."""

_POLYNOMIAL_FAR_SHARE, _FAR = 0.05, 4.0
"""A pixel is ignored if it is off by more than this share of depth and so many deviations of noise."""

_POLYNOMIAL_ROUNDS = 3
"""Number of rounds; each ignores outliers from the polynomial of the previous one."""

_LEAST_POLYNOMIAL_SHARE = 0.9
"""Minimum share of the known depth that is not an outlier."""

_LEFT, _LEFT_SHARE = 0.15, 0.0004
"""Maximum residual of the cells' means beyond noise, in deviations of a pixel's noise; for lower orders than the cells
determine, which may lack a term, also as a share of depth."""

_CHANCE, _CHANCE_LOWER = 4.0, 0.5
"""Additional residual allowed by chance, in deviations of the residual due to noise: highest order, lower ones."""

_TERMS = sorted(((a, b) for a in range(_ORDER + 1) for b in range(_ORDER + 1 - a)), key=sum)
"""Powers of y and x, lower orders first."""

_DEGREES = np.sum(_TERMS, axis=1)


def polynomial_trend(depth: NDArray[np.float32], mask: NDArray[np.bool_], noise: Noise) -> NDArray[np.float32] | None:
    """Fit a polynomial surface to the block's known depth, to within its noise.

    Products of Legendre polynomials are orthonormalised over the known depth, lower orders first, so that their
    coefficients are independent; the closer a coefficient is to noise, the lower its weight.

    Parameters
    ----------
    depth : ndarray of float32, shape (h, w)
        Depth [m], NaN = missing, in the region of the surface.
    mask : ndarray of bool, shape (h, w)
        The block's pixels; only their depth is used.
    noise : Noise
        Noise of the known depth.

    Returns
    -------
    ndarray of float32, shape (h, w), or None
        Depth [m]; None if the known depth is not such a polynomial plus noise.
    """
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    known = mask[box] & np.isfinite(depth[box])
    values = np.where(known, depth[box], np.float32(0))
    deviation = noise.deviation(values)
    cell = max(1, math.ceil(math.sqrt(known.size / _CELLS)))
    along = [_basis(size, side, sides) for size, side, sides in zip(depth.shape, box, known.shape, strict=True)]
    inside = [basis[side] for basis, side in zip(along, box, strict=True)]
    whole = _products([_cell_means(basis, cell) for basis in inside])
    gaps = whole[cell_sums(mask[box] & ~known, cell) > 0]
    far = np.maximum(np.float32(_POLYNOMIAL_FAR_SHARE) * values, np.float32(_FAR) * deviation)
    followed, weights = known, np.zeros(len(_TERMS))
    for _ in range(_POLYNOMIAL_ROUNDS):
        counts = cell_sums(followed, cell)
        held = counts > 0
        if np.count_nonzero(held) < 2 * len(_TERMS):
            return None
        pixels = counts[held]
        pixel = cell_sums(np.where(followed, deviation, 0), cell)[held] / pixels
        means = cell_sums(np.where(followed, values, 0), cell)[held] / pixels
        expected = pixel * np.sqrt(np.minimum(noise.grain / pixels, 1))
        terms = whole[held] + _off_middle(followed, counts, cell)
        fitted = _fitted(terms, means, expected, gaps, pixel)
        if fitted is None:
            return None
        weights = fitted
        followed = known & (np.abs(values - _surface(weights, inside)) < far)
        if np.count_nonzero(followed) < _LEAST_POLYNOMIAL_SHARE * np.count_nonzero(known):
            return None
        far = np.float32(_FAR) * deviation
    return _surface(weights, along).astype(np.float32)


def _fitted(terms: Array, means: Array, expected: Array, gaps: Array, pixel: Array) -> Array | None:
    """Coefficients of the terms; None if no polynomial explains the cells' means and is certain in the gaps."""
    noise, usual = float(np.median(pixel)), float(np.median(means))
    by_chance = math.sqrt(2 / len(means)) * float(np.square(expected).mean())
    most_left = (_LEFT * noise) ** 2 + _CHANCE * by_chance
    allowed = np.hypot(expected, _OWN * pixel)
    certain = max(_CERTAIN * noise, _CERTAIN_SHARE * usual)
    for order in _ORDERS:
        count = int(np.count_nonzero(order >= _DEGREES))
        orthonormal, triangle = np.linalg.qr(terms[:, :count] / allowed[:, None])
        sizes = np.abs(np.diag(triangle))
        if sizes.min() < _DETERMINED * sizes.max():
            continue
        found = orthonormal.T @ (means / allowed)
        inverse = np.linalg.inv(triangle)
        share = 1 - np.square(_BORNE_OUT / np.maximum(np.abs(found), _BORNE_OUT))
        share[0] = 1
        weights = inverse @ (share * found)
        left = np.square(means - terms[:, :count] @ weights) - np.square(expected)
        if left.mean() > most_left:
            return None  # lower orders have larger residuals
        most_left = min(_LEFT * noise, _LEFT_SHARE * usual) ** 2 + _CHANCE_LOWER * by_chance
        beyond = np.square(gaps[:, :count] @ inverse)[:, share > 0].sum(axis=1)
        if beyond.max(initial=0) < certain**2:
            return np.pad(weights, (0, len(_TERMS) - count))
    return None


def _off_middle(followed: NDArray[np.bool_], counts: Array, cell: int) -> Array:
    """Difference of the terms between the centre of each cell's used pixels and the centre of all of its pixels."""
    at = []
    for axis, size in enumerate(followed.shape):
        places = (2 * np.arange(size) + 1) / size - 1
        places = np.expand_dims(places, 1 - axis)
        at.append([cell_sums(np.where(mask, places, 0), cell) for mask in (followed, np.ones_like(followed))])
    everywhere, held = cell_sums(np.ones_like(followed), cell), counts > 0
    ends = [
        _products_at(*(legendre.legvander(sums[held] / number[held], _ORDER) for sums in pair))
        for pair, number in zip(zip(*at, strict=True), (counts, everywhere), strict=True)
    ]
    return ends[0] - ends[1]


def _basis(size: int, side: slice, inside: int) -> Array:
    """Legendre polynomials along an axis, of positions in [-1, 1] on the block, clipped beyond it."""
    positions = (2 * (np.arange(size) - side.start) + 1) / inside - 1
    return legendre.legvander(np.clip(positions, -1, 1), _ORDER)


def _cell_means(basis: Array, cell: int) -> Array:
    starts = np.arange(0, len(basis), cell)
    sizes = np.minimum(cell, len(basis) - starts)
    return np.add.reduceat(basis, starts) / sizes[:, None]


def _products(along: list[Array]) -> Array:
    """All terms, shape (rows, columns, terms), from the polynomials along rows and columns."""
    return _products_at(along[0][:, None], along[1][None, :])


def _products_at(y: Array, x: Array) -> Array:
    powers_y, powers_x = np.transpose(_TERMS)
    return y[..., powers_y] * x[..., powers_x]


def _surface(weights: Array, along: list[Array]) -> Array:
    square = np.zeros((_ORDER + 1,) * 2)
    for weight, powers in zip(weights, _TERMS, strict=True):
        square[powers] = weight
    return along[0] @ square @ along[1].T
