"""What a frame's own depth says about where boundaries belong: its jumps, and the surfaces that go on smoothly."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ..blocks import Box
from ..ebs.edges import filled_depth
from ..ebs.extraction import find_margins
from ..frame import RGBDFrame

JUMP, JUMP_SHARE = 0.04, 0.04
"""Neighbours that differ by more than the larger of the two [m, share of the nearer depth] are parted by a jump."""

TRUSTED_DISTANCE = 3.0
"""How far [px] from known depth a jump is still one: farther inside a hole, it is only where two nearest fills meet."""

JUMP_LENGTH = 10
"""Jumps count in lines longer than this [px]; shorter ones are flying pixels and noise."""

TOLERANCE = 2
"""How far [px] a boundary may be off, here and in boundary recall and precision."""

REACH, AVERAGED = 6, 9
"""Over how many pixels to either side a surface must go on to count as smooth, and the side of the squares over which
its depth is averaged before."""

BEND_SHARE, BEND_PER_METRE = 0.01, 0.003
"""Largest departure from a straight line over `REACH` on a smooth surface, as a share of the depth: the larger of a
constant, which a right-angled corner of a room in a Kinect's picture exceeds by about half, and one that grows with
depth as the noise of such sensors does."""

Pairs = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""What holds between a pixel and its right neighbour, shape (H, W - 1), and its lower one, shape (H - 1, W)."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What block maps of one frame are held against, all inside the margins: (h, w) is the shape of `window`.

    Attributes
    ----------
    window : tuple of slice
        Rows and columns of the frame inside the margins that the extraction finds by itself.
    known : ndarray of bool, shape (h, w)
        Pixels with depth.
    near_known : ndarray of bool, shape (h, w)
        Pixels within `TRUSTED_DISTANCE` of known depth: where a jump would have been seen.
    jumps : pair of ndarray of bool
        Neighbours between which depth jumps.
    smooth : pair of ndarray of bool
        Neighbours on one surface that goes on smoothly.
    """

    window: Box
    known: NDArray[np.bool_]
    near_known: NDArray[np.bool_]
    jumps: Pairs
    smooth: Pairs


def margin_window(rgb: NDArray[np.uint8]) -> Box:
    """Rows and columns inside the margins of a colour image, as `ilf.ebs.extraction.find_margins` finds them."""
    top, bottom, left, right = find_margins(rgb)
    return slice(top, rgb.shape[0] - bottom), slice(left, rgb.shape[1] - right)


def find_evidence(frame: RGBDFrame) -> Evidence:
    """Jumps and smooth surfaces of a frame's known depth.

    Neighbours of the filled depth (`ilf.ebs.edges.filled_depth`) that differ by more than max(4 cm, 4 %) are a jump
    if both lie within 3 px of known depth; so jumps are seen across gaps of up to 6 px, and no farther. Jumps count
    only in 8-connected lines of more than 10 px.

    A pixel lies on a smooth surface if its depth is known, there is no jump, of any length, and no larger hole in the
    13 x 13 pixels around it, and depth has equal slopes on both sides, within noise: the inverse depth, which is linear
    on a plane, averaged over 9 x 9 pixels, departs from a straight line over 6 px to either side by at most max(1 %,
    0.3 % per metre of depth), along the row and along the column, and so it does within 2 px around. A pair of
    neighbours is smooth if both are.
    """
    window = margin_window(frame.rgb)
    depth, known = frame.depth[window], frame.known[window]
    if not known.any():
        return Evidence(window, known, known, both(known), both(known))
    depth, distance = filled_depth(depth)
    near = distance <= TRUSTED_DISTANCE
    right, below = (
        (np.abs(one - other) > np.maximum(JUMP, JUMP_SHARE * np.minimum(one, other))) & trusted
        for (one, other), trusted in zip(_sides(depth), both(near), strict=True)
    )
    smooth = known & _goes_on(depth, near & ~mark((right, below)))
    return Evidence(window, known, near, _long_lines((right, below)), both(smooth))


def both(mask: NDArray[np.bool_]) -> Pairs:
    """Neighbours that both are in a mask of shape (H, W)."""
    right, below = (one & other for one, other in _sides(mask))
    return right, below


def apart(labels: NDArray[np.int32]) -> Pairs:
    """Neighbours of different labels in a map of shape (H, W)."""
    right, below = (one != other for one, other in _sides(labels))
    return right, below


def mark(pairs: Pairs) -> NDArray[np.bool_]:
    """Pairs as a picture of shape (H, W), a line 1 px wide: the left or upper pixel of every pair is set."""
    right, below = pairs
    marked = np.zeros((right.shape[0], below.shape[1]), bool)
    marked[:, :-1] |= right
    marked[:-1] |= below
    return marked


def _sides(values: NDArray) -> tuple[tuple[NDArray, NDArray], tuple[NDArray, NDArray]]:
    return (values[:, :-1], values[:, 1:]), (values[:-1], values[1:])


def _long_lines(jumps: Pairs) -> Pairs:
    """Those jumps whose 8-connected lines are longer than `JUMP_LENGTH`."""
    _, lines, sizes, _ = cv2.connectedComponentsWithStats(mark(jumps).astype(np.uint8), connectivity=8)
    long = sizes[:, cv2.CC_STAT_AREA][lines] > JUMP_LENGTH
    return jumps[0] & long[:, :-1], jumps[1] & long[:-1]


def _goes_on(depth: NDArray[np.float32], surface: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where depth has equal slopes on both sides; `surface` is where there is any, and no jump."""
    square = np.ones((2 * REACH + 1,) * 2, np.uint8)
    whole = cv2.erode(surface.astype(np.uint8), square, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    inverse = np.pad(cv2.blur(1 / depth, (AVERAGED, AVERAGED)), REACH)
    centre, before, after = slice(REACH, -REACH), slice(None, -2 * REACH), slice(2 * REACH, None)
    twice = 2 * inverse[centre, centre]
    along_column = inverse[before, centre] - twice + inverse[after, centre]
    along_row = inverse[centre, before] - twice + inverse[centre, after]
    bend = depth * np.maximum(np.abs(along_column), np.abs(along_row))
    bent = whole & (bend > np.maximum(BEND_SHARE, BEND_PER_METRE * depth))
    return whole & ~widened(bent, TOLERANCE)


def widened(mask: NDArray[np.bool_], radius: int) -> NDArray[np.bool_]:
    """Pixels within a distance of at most `radius` [px] of a mask of shape (H, W)."""
    if not mask.any():
        return np.zeros_like(mask)
    return distance_transform_edt(~mask) <= radius
