"""Surfaces that depth by hand may follow into a hole: the plane of known depth, or the nearer or farther of the two
surfaces around the hole."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.frame import FARTHEST_DEPTH
from ..data.pixel_grids import distance_to
from ..errors import InputError

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Planes in inverse depth.
#
# Seen by a pinhole camera, the inverse depth of a plane is a linear function of the image coordinates, whatever the
# intrinsics are. The noise of inverse depth does not depend on depth for stereo and structured light.

_FEWEST = 12
"""Minimum number of pixels with known depth."""

_SAMPLES, _TRIPLES = 4000, 300
"""Maximum number of pixels used, and number of triples that a plane is drawn through."""

_NARROW = 1.0
"""Minimum standard deviation [px] of the pixels' positions across their main direction."""

_INLIER, _LEAST_INLIER = 3.0, 1e-4
"""Deviations, in standard deviations, and as a share of the inverse depth, up to which pixels lie on the plane."""

_NORMAL_MAD = 0.6745
"""Median absolute deviation of a normal distribution, in standard deviations."""


def _plane_in(hole: Mask, depth: Array, source: Mask) -> tuple[Array, float]:
    """Depth [m] in a hole, on the plane that most of some known depth lies on, by the least median of squares and then
    least squares; NaN where it is behind the camera or farther than 300 m. And the share of that depth on the plane."""
    y, x = np.nonzero(source & np.isfinite(depth))
    if y.size < _FEWEST:
        raise InputError(f"A plane needs at least {_FEWEST} pixels with known depth, not {y.size}. Select more.")
    places = np.random.default_rng(0).permutation(y.size)[:_SAMPLES]
    y, x = y[places], x[places]
    inverse = 1 / depth[y, x].astype(np.float64)
    centre = float(x.mean()), float(y.mean())
    basis = np.stack([x - centre[0], y - centre[1], np.ones(x.size)], axis=1)
    if np.linalg.svd(basis[:, :2], compute_uv=False)[1] < _NARROW * math.sqrt(x.size):
        raise InputError("The known depth lies on a line, which leaves the plane's tilt open. Select more.")
    off = np.abs(inverse - _through_most(basis, inverse))
    for _ in range(3):
        limit = max(_INLIER * float(np.median(off)) / _NORMAL_MAD, _LEAST_INLIER * float(np.median(inverse)))
        lies = off <= limit
        (a, b, c), *_rest = np.linalg.lstsq(basis[lies], inverse[lies], rcond=None)
        off = np.abs(inverse - basis @ np.array([a, b, c]))
    y, x = np.nonzero(hole)
    continued = float(a) * x + float(b) * y + float(c - a * centre[0] - b * centre[1])
    found, seen = np.full(hole.shape, np.nan, np.float32), continued >= 1 / FARTHEST_DEPTH
    found[y[seen], x[seen]] = 1 / continued[seen]
    return found, float(lies.mean())


def _through_most(basis: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of the plane through three of the samples with the least median deviation from all."""
    random = np.random.default_rng(0)
    best, least = np.full(values.size, np.median(values)), math.inf
    for _ in range(_TRIPLES):
        three = random.choice(values.size, 3, replace=False)
        try:
            found = basis @ np.linalg.solve(basis[three], values[three])
        except np.linalg.LinAlgError:  # on a line
            continue
        if (middle := float(np.median(np.abs(values - found)))) < least:
            best, least = found, middle
    return best


def continue_plane(depth: Array, source: Mask, hole: Mask) -> tuple[Array, float]:
    """Continue the plane of known depth into a hole.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    source, hole : ndarray of bool, shape (H, W)
        The pixels whose depth is fitted, and those that get depth.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] in the hole, NaN elsewhere, and where the plane is behind the camera or farther than 300 m.
    float
        Share of the known depth that lies on the plane.

    Raises
    ------
    InputError
        If there are fewer than 12 pixels with known depth, or they lie on a line, or the plane does not reach the hole
        in front of the camera.

    Examples
    --------
    >>> hole = np.arange(24).reshape(4, 6) == 9
    >>> depth = np.where(hole, np.float32(np.nan), np.float32(2))
    >>> found, share = continue_plane(depth, ~hole, hole)
    >>> round(float(found[hole][0]), 6), share
    (2.0, 1.0)
    """
    found, share = _plane_in(hole, depth, source)
    if not np.isfinite(found).any():
        raise InputError("Continued into the hole, the plane lies behind the camera or beyond 300 m.")
    return found, share


# The two surfaces around a hole.

_RIM = 8
"""Distance [px] from the hole up to which known depth is its rim."""

_LEAST_SHARE, _LEAST_PIXELS = 0.05, 8
"""Minimum share of the rim, and number of its pixels, on each of the two surfaces."""

_STRAY = 0.02
"""Share of the rim that may lie between the surfaces, such as flying pixels."""

_APART = 1.03
"""Minimum ratio of the depths on the two sides of the jump, or of the medians in two blocks."""

_MARGIN = 1.1
"""Ratio by which the continued plane may leave the range of its surface at the rim."""


def nearer_or_farther(depth: Array, labels: NDArray[np.int32], hole: Mask, nearer: bool) -> Array:
    """Continue the nearer or the farther of the two surfaces around a hole into it: those on the two sides of a jump in
    the depth at its rim, or of two blocks there.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    labels : ndarray of int32, shape (H, W)
        Label map, 0 = no block.
    hole : ndarray of bool, shape (H, W)
        Pixels without depth; connected parts are treated separately.
    nearer : bool

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] in the parts that lie between two surfaces, NaN elsewhere.

    Raises
    ------
    InputError
        If no part of the hole lies between two surfaces.
    """
    found = np.full(depth.shape, np.nan, np.float32)
    count, parts, boxes, _ = cv2.connectedComponentsWithStats(hole.astype(np.uint8), connectivity=8)
    for number in range(1, count):
        x, y, width, height = boxes[number, :4]
        around = np.s_[max(y - _RIM, 0) : y + height + _RIM, max(x - _RIM, 0) : x + width + _RIM]
        part, there = parts[around] == number, depth[around]
        distance = distance_to(part)
        rim = (distance <= _RIM) & np.isfinite(there)
        surface = _surface_of(there, labels[around], rim, nearer)
        if surface is not None:
            found[around][part] = _continued(there, surface, part)[part]
    if not np.isfinite(found).any():
        raise InputError("The hole does not lie between two surfaces. Continue a plane instead, or paint depth.")
    return found


def _surface_of(depth: Array, labels: NDArray[np.int32], rim: Mask, nearer: bool) -> Mask | None:
    """The pixels of a hole's rim on the requested surface; None if there are no two."""
    least = max(_LEAST_PIXELS, _LEAST_SHARE * np.count_nonzero(rim))
    values = np.sort(depth[rim])
    stray = max(1, round(_STRAY * values.size))
    low, high = values[:-stray], values[stray:]
    ratios = high / low
    first, last = math.ceil(least), low.size - math.ceil(least)
    if first < last:
        place = first + int(np.argmax(ratios[first:last]))
        if ratios[place] >= _APART:
            limit = math.sqrt(float(low[place]) * float(high[place]))
            return rim & ((depth < limit) if nearer else (depth > limit))
    sizes = np.bincount(labels[rim])
    blocks = [int(label) for label in np.flatnonzero(sizes >= least) if label]
    medians = {label: float(np.median(depth[rim & (labels == label)])) for label in blocks}
    if len(medians) < 2 or max(medians.values()) < _APART * min(medians.values()):
        return None
    chosen = (min if nearer else max)(medians, key=lambda label: medians[label])
    return rim & (labels == chosen)


def _continued(depth: Array, surface: Mask, hole: Mask) -> Array:
    """A surface's plane in the hole, within the range of its depth at the rim; its median depth if it has no plane."""
    values = depth[surface]
    low, high = float(values.min()) / _MARGIN, float(values.max()) * _MARGIN
    try:
        found, _ = _plane_in(hole, depth, surface)
    except InputError:
        return np.where(hole, np.float32(np.median(values)), np.float32(np.nan))
    return np.clip(np.where(np.isnan(found), np.float32(high), found), low, high)
