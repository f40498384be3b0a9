"""Rims of gaps at jumps: the first pixels beside measured surfaces, where an outline lies within reach.

There the filter draws a ramp from one surface to the other, and follows all wrong samples of the outline. Colour shows
on which of the surfaces a pixel lies: depth is that of `colourisation`, solved around these pixels only.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.compiling import compiled
from .._runtime.long_work import check_cancelled
from ..data.blocks import Block, bounds, grown, moved, within
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.pixel_grids import contrast, distance_to, filled_from_nearest, strips
from .edge_aware.view import WELL_KNOWN, flying_pixels

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

_SURFACE = np.ones((3, 3), np.uint8)
"""Measured surfaces are squares of 3 x 3 px that are all known. Scattered samples are none: among them, depth itself
contains the jumps."""

_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))

_RIM = 2.9
"""Maximum distance [px] of a rim's pixels from a measured surface."""

_JUMP, _REACH = 1.12, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (11, 11))
"""Ratio of the farthest surface around a pixel to the nearest above which there is a jump, and where that is."""

_STEP = 1.06
"""Minimum ratio of one depth of the surfaces around to the next smaller one: on a slope, smaller steps follow each
other."""

_AT_A_TIME = 1 << 16
"""Maximum number of pixels whose surroundings are sorted at a time."""

_BESIDE = 3
_AROUND = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, [2 * _BESIDE + 1] * 2)
"""Pixels around those of a rim that are solved for, too: missing ones, and known ones, which wrong samples may be."""

_SWEEPS = 40
"""Number of Jacobi iterations."""

_ROWS, _HALO = 512, 24
"""Rows that are solved together, and pixels beside them that matter: values fade within a few pixels of known depth."""


def depth_at_rims(frame: RGBDFrame, block: Block, drawn: Mask | None = None) -> Array:
    """Depth by colour [m] at a block's rims of gaps beside jumps, but not at drawn borders; NaN at its other pixels, in
    the order of `block.mask`'s True values. It keeps to the range of the block's known depth, unless most of that is
    missing.

    Examples
    --------
    >>> depth = np.full((20, 30), 1.0)
    >>> depth[:, 15:] = 2.0
    >>> depth[:, 14:17] = np.nan
    >>> colour = np.zeros((20, 30, 3), np.uint8)
    >>> colour[:, 16:] = 255
    >>> whole = Block(1, np.s_[0:20, 0:30], np.ones((20, 30), bool))
    >>> depth_at_rims(RGBDFrame(colour, depth), whole).reshape(20, 30)[10, 13:18].round(1).tolist()
    [nan, 1.0, 1.0, 2.0, nan]
    """
    box = grown(block.box, _BESIDE, frame.shape)
    depth = frame.depth[box]
    own = np.zeros(depth.shape, bool)
    own[within(block.box, box)] = block.mask
    rims = _rims(frame)[box] & own
    if drawn is not None:
        border = own & (cv2.erode(own.view(np.uint8), _CROSS) == 0)
        border[own] &= drawn
        rims &= cv2.dilate(border.view(np.uint8), _REACH) == 0
    found = np.full(depth.shape, np.nan, np.float32)
    for rows, *_ in strips(len(found), rows=_ROWS):
        check_cancelled()
        if (some := bounds(rims[rows])) is not None:
            here = moved(some, rows.start, 0)
            wider = grown(here, _HALO, found.shape)
            values = _by_colour(frame.edge_rgb[box][wider], depth[wider], rims[wider], own[wider])
            found[here] = np.where(rims[here], values[within(here, wider)], np.float32(np.nan))
    known = depth[own & np.isfinite(depth)]
    if known.size >= WELL_KNOWN * np.count_nonzero(own):
        np.clip(found, known.min(), known.max(), out=found)
    return found[own]


def _by_colour(rgb: NDArray[np.uint8], depth: Array, rims: Mask, own: Mask) -> Array:
    """Colourisation at the rims of a block, as Jacobi's iteration from the nearest known depth leaves it."""
    around = cv2.dilate(rims.view(np.uint8), _AROUND).view(bool)
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float64) / 255.0
    weights, neighbours = similar_neighbours(grey, around, own)
    known = np.isfinite(depth[around])
    given, share = np.where(known, depth[around], np.float32(0)), np.where(known, np.float32(0.5), np.float32(1))
    result = filled_from_nearest(depth)
    links = (share * weights).astype(np.float32)
    result[around] = _relaxed(links, neighbours, share * given, result[around], _SWEEPS)
    return result


def _relax(links: Array, neighbours: NDArray[np.intp], given: Array, values: Array, sweeps: int) -> Array:
    for _ in range(sweeps):
        new = given.copy()
        for k in range(len(links)):
            for n in range(new.size):
                new[n] += links[k, n] * values[neighbours[k, n]]
        values = new
    return values


@compiled(_relax)
def _relaxed(links: Array, neighbours: NDArray[np.intp], given: Array, values: Array, sweeps: int) -> Array:
    """Jacobi's iteration: values become the sums of their eight neighbours by weights, and what is given."""
    for _ in range(sweeps):
        values = given + (links * values[neighbours]).sum(axis=0)
    return values


@once_per_frame
def _rims(frame: RGBDFrame) -> Mask:
    """The missing pixels beside surfaces, with a jump between surfaces around, bool (H, W)."""
    found = np.empty(frame.shape, bool)
    flying = flying_pixels(frame)
    for rows, wider, inner in strips(len(found), _HALO, _ROWS):
        depth = frame.depth[wider]
        known = np.isfinite(depth)
        surfaces = cv2.morphologyEx((known & ~flying[wider]).view(np.uint8), cv2.MORPH_OPEN, _SURFACE).view(bool)
        beside = distance_to(surfaces) <= _RIM
        rims = ~known & beside & (contrast(depth, surfaces, _REACH) > _JUMP)
        rims[rims] = _have_steps(np.where(surfaces, depth, np.float32(np.nan)), np.argwhere(rims))
        found[rows] = rims[inner]
    return found


def _have_steps(depth: Array, places: NDArray[np.intp]) -> Mask:
    """Whether depth around each place, NaN = no surface, has a step."""
    reach = len(_REACH) // 2
    padded = cv2.copyMakeBorder(depth, reach, reach, reach, reach, cv2.BORDER_REPLICATE)
    row = padded.shape[1], 1
    around, at, found = np.argwhere(_REACH) @ row, places @ row, np.empty(len(places), bool)
    for first in range(0, len(at), _AT_A_TIME):
        part = slice(first, first + _AT_A_TIME)
        ordered = np.sort(padded.ravel()[at[part] + around[:, np.newaxis]], axis=0)  # NaN last
        found[part] = (ordered[1:] > np.float32(_STEP) * ordered[:-1]).any(axis=0)
    return found


# The weights of colourisation: pixels of similar colour have similar depth.

_NEIGHBOURS = np.array([(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1) if (row, column) != (0, 0)])
_VARIANCE_SHARE = 0.6
_MIN_WEIGHT = 0.01
_MIN_VARIANCE = 2e-6
_ACROSS = 0.2


def similar_neighbours(
    grey: NDArray[np.float64], pixels: NDArray[np.bool_], block: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The weights by which each of some pixels is the mean of those around it.

    Parameters
    ----------
    grey : ndarray of float64, shape (H, W)
        Grey levels in [0, 1].
    pixels : ndarray of bool, shape (H, W)
        The N pixels; others have no weight.
    block : ndarray of bool, shape (H, W), optional
        Pixels of a block, across whose border neighbours have a fifth of their weight.

    Returns
    -------
    weights : ndarray of float64, shape (8, N)
        Of sum 1, or 0 for a pixel without neighbours.
    neighbours : ndarray of int, shape (8, N)
        Which of the pixels they belong to, in rows from the top; where a weight is 0, any of them.
    """
    padded = np.pad(pixels, 1)
    number, places = np.cumsum(padded) - 1, np.flatnonzero(padded)
    around = places + (_NEIGHBOURS @ np.array([padded.shape[1], 1]))[:, np.newaxis]
    weights = np.where(padded.ravel()[around], _affinities(grey, places, around), 0.0)
    if block is not None:
        own = np.pad(block, 1).ravel()
        weights[own[around] != own[places]] *= _ACROSS
    weights /= np.maximum(weights.sum(axis=0), np.finfo(np.float64).tiny)
    return weights, np.maximum(number[around], 0)


def _affinities(grey: NDArray[np.float64], places: NDArray[np.intp], around: NDArray[np.intp]) -> NDArray[np.float64]:
    """Similarity of N pixels with their eight neighbours, (8, N); both are indices in the image with a rim of 1 px."""
    inside = np.pad(np.ones(grey.shape, bool), 1).ravel()[around]
    levels = np.pad(grey, 1).ravel()
    own, others = levels[places], levels[around]
    count = inside.sum(axis=0) + 1
    mean = (others.sum(axis=0) + own) / count
    deviation = np.where(inside, others - mean, 0.0)
    variance = ((deviation**2).sum(axis=0) + (own - mean) ** 2) / count
    difference = (others - own) ** 2
    # the most similar neighbour keeps some weight whatever the variance
    nearest = np.where(inside, difference, np.inf).min(axis=0)
    spread = np.maximum.reduce(
        [_VARIANCE_SHARE * variance, nearest / -math.log(_MIN_WEIGHT), np.full(places.size, _MIN_VARIANCE)]
    )
    return np.exp(-difference / spread)
