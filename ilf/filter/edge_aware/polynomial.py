"""The polynomial that a block's known depth follows to within its noise, of no more terms than it bears out."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from .noise import Noise
from .trend import cell_sums

Array = NDArray[np.float64]

_ORDERS = (8, 6, 4, 2)
"""Largest power of row and column together: the first for which what lies in gaps is certain enough."""

_ORDER = _ORDERS[0]

_CELLS = 800
"""The polynomial is found from the means of about so many cells."""

_BORNE_OUT = 2.0
"""A term counts in full where it is many times what noise alone would make of it, and not at all below so many."""

_OWN = 0.02
"""Cells' means have an error of their own of so many deviations of a pixel's noise, however many pixels they have."""

_CERTAIN, _CERTAIN_SHARE = 0.05, 0.0005
"""What noise makes of the polynomial in gaps is at most so many deviations of a pixel's noise, or this share of
depth."""

_DETERMINED = 1e-6
"""Cells determine the terms if the least of them is more than so much of the largest."""

_FAR_SHARE, _FAR = 0.05, 4.0
"""A pixel does not count that is off by more than this share of depth, and so many deviations of noise."""

_ROUNDS = 3
"""Each leaves out what is far off the polynomial of the one before."""

_LEAST_SHARE = 0.9
"""So much of the known depth must not be far off."""

_LEFT, _LEFT_SHARE = 0.15, 0.0004
"""What is left of the cells' means, beyond what noise explains, is at most so many deviations of a pixel's noise; of
lower orders than the cells determine, which may lack a term, also at most this share of depth."""

_CHANCE, _CHANCE_LOWER = 4.0, 0.5
"""More may be left by chance, in deviations of what noise leaves: by the highest order, and by lower ones."""

_TERMS = sorted(((a, b) for a in range(_ORDER + 1) for b in range(_ORDER + 1 - a)), key=sum)
"""Powers of y and x, the lower orders first."""

_DEGREES = np.sum(_TERMS, axis=1)


def polynomial_trend(depth: NDArray[np.float32], mask: NDArray[np.bool_], noise: Noise) -> NDArray[np.float32] | None:
    """The polynomial surface that the block's known depth lies on, up to its noise.

    Products of Legendre polynomials are made orthonormal over the known depth, the lower orders first, so that what one
    of them brings does not depend on the others; the more noise alone might have brought one, the less it counts.

    Parameters
    ----------
    depth : ndarray of float32, shape (h, w)
        Depth [m], NaN = missing, on the region to find the surface on.
    mask : ndarray of bool, shape (h, w)
        The block's pixels; only their depth counts.
    noise : Noise
        That of the known depth.

    Returns
    -------
    ndarray of float32, shape (h, w), or None
        Depth [m]; None if the known depth has more in it than such a polynomial and noise.
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
    far = np.maximum(np.float32(_FAR_SHARE) * values, np.float32(_FAR) * deviation)
    followed, weights = known, np.zeros(len(_TERMS))
    for _ in range(_ROUNDS):
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
        if np.count_nonzero(followed) < _LEAST_SHARE * np.count_nonzero(known):
            return None
        far = np.float32(_FAR) * deviation
    return _surface(weights, along).astype(np.float32)


def _fitted(terms: Array, means: Array, expected: Array, gaps: Array, pixel: Array) -> Array | None:
    """Weights of the terms; None if no polynomial explains the cells' means and is certain in the gaps."""
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
            return None  # lower orders leave more
        most_left = min(_LEFT * noise, _LEFT_SHARE * usual) ** 2 + _CHANCE_LOWER * by_chance
        beyond = np.square(gaps[:, :count] @ inverse)[:, share > 0].sum(axis=1)
        if beyond.max(initial=0) < certain**2:
            return np.pad(weights, (0, len(_TERMS) - count))
    return None


def _off_middle(followed: NDArray[np.bool_], counts: Array, cell: int) -> Array:
    """How the terms at the middle of every cell's pixels that count differ from those at the middle of all of them."""
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
    """Legendre polynomials at every place along an axis, of positions in [-1, 1] on the block and no farther beyond."""
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
