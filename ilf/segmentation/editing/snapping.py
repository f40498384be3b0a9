"""Snapping a drawn line to edges, and limiting a stroke to similar pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_image
from ...data.parameters import BlockParameters
from ...data.pixel_grids import mark_both
from ..edges.detectors import colour_gradient, gradient_strength
from ..edges.frame_edges import relief_of
from .patches import Mask, Points

# Snapping a line to the strongest evidence for a border beside it.

_NETWORK, _GRADIENT = 0.5, 0.5
"""Weights of edge strength and colour gradient; a depth jump has the weight 1."""

_ON_SURFACE = 0.2
"""Factor on these weights where the known depth is continuous."""

_WIDTH = 1.0
"""Blur [px] of depth jumps, so that they attract lines beside them."""

_AWAY, _BEND = 0.04, 0.3
"""Cost of a move by 1 px, and of a change of the move by 1 px from one pixel to the next: without evidence, the line
stays as drawn."""

_STEP = 0.5
"""Moves are multiples of this [px]."""

_STEEPEST = 2
"""Largest change of the move, in steps, from one pixel of the line to the next."""

_STRAIGHTENED = 4.0
"""Blur [px] along the line before its directions are taken."""


def border_evidence(frame: RGBDFrame, strength: NDArray[np.float32]) -> NDArray[np.float32]:
    """Evidence for a border at every pixel, by depth, edges and colour.

    Parameters
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].

    Returns
    -------
    ndarray of float32, shape (H, W)
        About 1 where a border is certain.
    """
    relief = relief_of(frame, BlockParameters())
    jumps = mark_both(relief.jumps)
    ridge = cv2.GaussianBlur(jumps.astype(np.float32), (0, 0), _WIDTH)
    gradient = np.float32(_GRADIENT) * _gradient(frame.edge_rgb)
    colour = np.float32(_NETWORK) * np.where(relief.edges, 0, strength) + gradient
    beside = cv2.dilate(jumps.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    goes_on = relief.near & ~beside
    return np.asarray(ridge + np.where(goes_on, np.float32(_ON_SURFACE), np.float32(1)) * colour, np.float32)


@once_per_image
def _gradient(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    return gradient_strength(*colour_gradient(rgb, 1.0))


def snap(points: Points, evidence: NDArray[np.float32], leash: float) -> list[tuple[float, float]]:
    """Move a line to the strongest evidence within a leash.

    Every point moves at a right angle to the line, and neighbouring points move by similar distances.

    Parameters
    ----------
    points : sequence of (x, y)
        The line as drawn, in image coordinates.
    evidence : ndarray of float32, shape (H, W)
        From `border_evidence`.
    leash : float
        Maximum move of a point [px]; 0 returns the line as drawn.

    Returns
    -------
    list of (x, y)
        A point for every pixel of the line's length.
    """
    line = _every_pixel(np.asarray(points, np.float64).reshape(-1, 2))
    if leash < _STEP or len(line) < 3:
        return [(float(x), float(y)) for x, y in points]
    straight = gaussian_filter1d(line, _STRAIGHTENED, axis=0, mode="nearest")
    along = np.gradient(straight, axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    reach = int(leash / _STEP)
    moves = _STEP * np.arange(-reach, reach + 1)
    x, y = np.moveaxis(line[:, None] + moves[:, None] * across[:, None], -1, 0)
    found = map_coordinates(evidence, (y - 0.5, x - 0.5), order=1, mode="constant")
    chosen = moves[_cheapest(_AWAY * np.abs(moves) - found)]
    snapped = line + gaussian_filter1d(chosen, 1.0, mode="nearest")[:, None] * across
    return [(float(x), float(y)) for x, y in snapped]


def _every_pixel(line: NDArray[np.float64]) -> NDArray[np.float64]:
    steps = np.hypot(*np.diff(line, axis=0).T)
    length = float(steps.sum())
    if length < 2:
        return line[:0]
    wanted = np.linspace(0, length, round(length) + 1)
    return np.stack([np.interp(wanted, np.append(0, np.cumsum(steps)), line[:, k]) for k in range(2)], axis=1)


def _cheapest(cost: NDArray[np.float64]) -> NDArray[np.intp]:
    """The index of the move for every point of a line that minimises the sum of the costs (n, moves) and of the changes
    from point to point, by dynamic programming."""
    count, moves = cost.shape
    changes = np.arange(-_STEEPEST, _STEEPEST + 1)
    bend = (_BEND * _STEP * np.abs(changes))[:, None]
    # row j holds what lies `changes[j]` moves away
    beside = np.arange(moves) + changes[:, None] + _STEEPEST
    total = np.full(moves + 2 * _STEEPEST, np.inf)
    total[_STEEPEST:-_STEEPEST] = cost[0]
    best_change = np.zeros((count, moves), np.intp)
    everywhere = np.arange(moves)
    for point in range(1, count):
        reached = total[beside] + bend
        best_change[point] = reached.argmin(axis=0)
        total[_STEEPEST:-_STEEPEST] = reached[best_change[point], everywhere] + cost[point]
    chosen = np.empty(count, np.intp)
    chosen[-1] = total[_STEEPEST:-_STEEPEST].argmin()
    for point in range(count - 1, 0, -1):
        chosen[point - 1] = chosen[point] + changes[best_change[point, chosen[point]]]
    return chosen


# Limiting a stroke to pixels similar to its start: of similar colour and depth, and not beyond a strong edge.

_EDGE = 0.5
"""Minimum strength of a strong edge."""

_COLOUR = (40, 16, 16)
"""Maximum difference of a colour from that at the start, in 8-bit Lab: larger for lightness, which shading changes."""

_DEPTH_SHARE = 0.15
"""Maximum difference of depth from that at the start, as a fraction of it."""

_INTO_EDGE = 3
"""Maximum distance [px] that a stroke may extend into the width of an edge, if colour and depth are similar."""

_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)


def similar_pixels(frame: RGBDFrame, strength: NDArray[np.float32], x: float, y: float) -> Mask:
    """The pixels that a stroke may cover, given its start point.

    Parameters
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    x, y : float
        Start of the stroke in image coordinates; outside the frame, all pixels are similar.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    row, column = int(np.floor(y)), int(np.floor(x))
    if not (0 <= row < frame.shape[0] and 0 <= column < frame.shape[1]):
        return np.ones(frame.shape, bool)
    jumps = relief_of(frame, BlockParameters()).edges
    return _reached(_like(frame, row, column), strength < _EDGE, jumps, row, column)


def _like(frame: RGBDFrame, row: int, column: int) -> NDArray[np.bool_]:
    """Pixels with about the colour and depth of a pixel; where depth is missing, only colour counts."""
    around = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
    lab = smooth_lab(frame.edge_rgb)
    start = np.median(lab[around].reshape(-1, 3), axis=0)
    like = _within(lab, start - _COLOUR, start + _COLOUR)
    near = frame.depth[around]
    if np.isfinite(near).any():
        depth = float(np.nanmedian(near))
        low, high = (np.array(depth * (1 + sign * _DEPTH_SHARE)) for sign in (-1, 1))
        like &= _within(frame.depth, low, high) | ~frame.known
    like[row, column] = True
    return like


def _within(values: NDArray[Any], low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.bool_]:
    return cv2.inRange(values, low, high) > 0


@once_per_image
def smooth_lab(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A colour image in 8-bit Lab, slightly blurred, uint8 (H, W, 3); cached with it."""
    return np.asarray(cv2.cvtColor(cv2.GaussianBlur(rgb, (0, 0), 1.0), cv2.COLOR_RGB2Lab), np.uint8)


def _reached(
    like: NDArray[np.bool_], weak: NDArray[np.bool_], jumps: NDArray[np.bool_], row: int, column: int
) -> NDArray[np.bool_]:
    """Pixels that can be reached from a pixel over similar ones, and a short distance into the edges around."""
    open_ground = (like & weak & ~jumps).astype(np.uint8)
    open_ground[row, column] = 1
    cv2.floodFill(open_ground, None, (column, row), 2, flags=4)
    reached, edge = open_ground == 2, like & ~(weak & ~jumps)
    last = reached
    for _ in range(_INTO_EDGE):
        last = (cv2.dilate(last.astype(np.uint8), _CROSS) > 0) & edge & ~reached
        reached = reached | last
        # a jump lies behind the marked pixel: that pixel may be covered, those behind it not
        last = last & ~jumps
    return reached
