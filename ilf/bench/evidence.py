"""What a frame's own depth says about where boundaries belong: its jumps, and the surfaces that go on smoothly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ..blocks import Box
from ..ebs.extraction import find_margins
from ..edges.pairs import Pairs, both
from ..edges.relief import find_relief
from ..frame import RGBDFrame

JUMP, JUMP_SHARE = 0.04, 0.04
"""Neighbours that differ by more than the larger of the two [m, share of the nearer depth] are parted by a jump."""

TOLERANCE = 2
"""How far [px] a boundary may be off, here and in boundary recall and precision."""


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
        Pixels within 3 px of known depth: where a jump would have been seen.
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

    Jumps are those of `ilf.edges.relief.find_relief` in lines of more than 10 px.

    A pixel lies on a smooth surface if its depth is known, there is no jump, of any length, and no larger hole in the
    21 x 21 pixels around it, and the surface does not bend there or within 2 px around, by the same function.
    """
    window = margin_window(frame.rgb)
    known = frame.known[window]
    relief = find_relief(frame.depth[window], JUMP, JUMP_SHARE)
    smooth = known & relief.judged & ~widened(relief.bend > 1, TOLERANCE)
    return Evidence(window, known, relief.near, relief.jumps, both(smooth))


def widened(mask: NDArray[np.bool_], radius: int) -> NDArray[np.bool_]:
    """Pixels within a distance of at most `radius` [px] of a mask of shape (H, W)."""
    if not mask.any():
        return np.zeros_like(mask)
    return distance_transform_edt(~mask) <= radius
