"""Where a block that holds two surfaces could be cut."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from ..edges.pairs import apart, both, mark
from ..edges.relief import Relief, find_relief
from ..errors import InputError
from ..frame import RGBDFrame
from ..parameters import BlockParameters
from .boundaries import contract, regions_between, snap_to_jumps
from .edit import split
from .edit.cracks import CrackPaths, find_cracks
from .edit.patches import box_of
from .flooding import flood
from .merging import RegionGraph

_SAMPLES = 90
"""Samples of depth along the longer side of the block's box, at most."""

_KNOWN, _SHARE = 30, 0.04
"""Samples that a surface needs, and the share of all that each of the two must have."""

_NOISE_SHARE, _NOISE_PER_METRE = 0.005, 0.0015
"""Deviation (root mean square) from one smooth surface up to which there is but one, as a share of the depth: the
larger of a constant and one that grows with depth."""

_BETTER = 0.55
"""Two planes must leave at most this share of the deviation that one curved surface leaves."""

_LEAST = 60
"""Pixels that a part beyond a jump has at least."""

_SEEN = 0.5
"""Share of their border along which depth jumps between two parts."""

_BELOW_JUMPS = 0.9
"""Factor on the edge strength beside jumps, which must stand above it."""

_ALL_BUT_JUMPS = 2.0
"""Cost of a border up to which regions are one surface: more than any without a jump."""

_ROUNDS = 12

_UNSURE = 0.03
"""Width of the band between the surfaces in which edges decide, as a share of the box's diagonal; 4 px at least."""


def suggest_split(
    frame: RGBDFrame, labels: NDArray[np.int32], label: int, strength: NDArray[np.float32]
) -> list[tuple[float, float]] | None:
    """The line that parts the two surfaces in a block, as known depth and edges suggest.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
    label : int
        The block.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].

    Returns
    -------
    list of (x, y) or None
        For `edit.split`, in image coordinates; None if the known depth is on one surface, too little is known, or the
        two surfaces do not lie side by side.
    """
    box = box_of(labels, label) if label > 0 else None
    if box is None:
        return None
    block = labels[box] == label
    depth = np.where(block, frame.depth[box], np.float32(np.nan))
    parts = _at_jumps(frame.rgb[box], depth, block, strength[box])
    if parts is None:
        sides = _two_surfaces(depth)
        parts = None if sides is None else _parted(block, sides, strength[box])
    line = None if parts is None else _border(parts)
    if line is None:
        return None
    points = [(float(x), float(y)) for x, y in line + np.array([box[1].start, box[0].start])]
    return points if split(labels, label, points) is not None else None


def _at_jumps(
    rgb: NDArray[np.uint8], depth: NDArray[np.float32], block: NDArray[np.bool_], strength: NDArray[np.float32]
) -> NDArray[np.int32] | None:
    """The block's pixels in two parts, 1 and 2, with a jump along most of their border; None without one."""
    usual = BlockParameters()
    relief = find_relief(depth, usual.depth_jump, usual.depth_jump_share)
    if not any(pairs.any() for pairs in relief.jumps):
        return None
    edges = mark(relief.jumps)
    guide = np.where(edges, np.float32(1), np.float32(_BELOW_JUMPS) * strength)
    regions = snap_to_jumps(contract(regions_between(edges, 1.0, block), guide, block), relief.jumps)
    try:
        graph = RegionGraph(regions, strength, RGBDFrame(rgb, depth), relief)
    except InputError:  # alone, such far or near depth would be none in metres
        return None
    graph.merge_below(_ALL_BUT_JUMPS)
    surfaces = graph.labels()
    least = max(_SHARE * np.count_nonzero(block), _LEAST)
    for surface in range(1, int(surfaces.max()) + 1):
        part = surfaces == surface
        if least <= np.count_nonzero(part) <= np.count_nonzero(block) / 2 and _jump_share(part, block, relief) >= _SEEN:
            return np.where(block, np.where(part, np.int32(2), np.int32(1)), np.int32(0))
    return None


def _jump_share(part: NDArray[np.bool_], block: NDArray[np.bool_], relief: Relief) -> float:
    """Share of a part's border to the rest of its block along which depth jumps."""
    border = [rim & inside for rim, inside in zip(apart(part.astype(np.int32)), both(block), strict=True)]
    length = sum(np.count_nonzero(some) for some in border)
    along = sum(np.count_nonzero(some & jumps) for some, jumps in zip(border, relief.jumps, strict=True))
    return along / max(length, 1)


def _two_surfaces(depth: NDArray[np.float32]) -> NDArray[np.int32] | None:
    """Of every pixel the surface, 1 or 2, whose plane its surroundings are nearer to; None if there are not two."""
    step = max(1, math.ceil(max(depth.shape) / _SAMPLES))
    coarse = depth[step // 2 :: step, step // 2 :: step]
    known = np.isfinite(coarse)
    if np.count_nonzero(known) < 2 * _KNOWN:
        return None
    rows, columns = np.nonzero(known)
    x, y = columns / coarse.shape[1] - 0.5, rows / coarse.shape[0] - 0.5
    inverse = 1 / coarse[known].astype(np.float64)
    typical = float(np.median(inverse))
    plane = np.stack([np.ones(x.size), x, y], axis=1)
    curved = np.concatenate([plane, np.stack([x * x, x * y, y * y], axis=1)], axis=1)
    one = _deviation(_residual(curved, inverse, np.ones(x.size, bool))) / typical
    if one <= max(_NOISE_SHARE, _NOISE_PER_METRE / typical):
        return None
    best, least = None, _BETTER * one
    for lean in (inverse, x, y, x + y, x - y):
        second = lean > _threshold(lean)
        for _ in range(_ROUNDS):
            if min(second.sum(), (~second).sum()) < max(_KNOWN, _SHARE * second.size):
                break
            off = [_residual(plane, inverse, members) ** 2 for members in (~second, second)]
            nearer = _smoothed(known, off[0] - off[1])
            if np.array_equal(nearer[known] > 0, second):
                break
            second = nearer[known] > 0
        else:
            off = [_residual(plane, inverse, members) ** 2 for members in (~second, second)]
        if min(second.sum(), (~second).sum()) < max(_KNOWN, _SHARE * second.size):
            continue
        two = math.sqrt(float(np.mean(np.where(second, off[1], off[0])))) / typical
        if two < least:
            best, least = np.where(nearer > 0, np.int32(2), np.int32(1)), two
    if best is None:
        return None
    return np.asarray(cv2.resize(best.astype(np.uint8), depth.shape[::-1], interpolation=cv2.INTER_NEAREST), np.int32)


def _threshold(values: NDArray[np.float64]) -> float:
    """Otsu's: that which leaves two classes with the least spread."""
    low, high = float(values.min()), float(values.max())
    levels = ((values - low) / max(high - low, 1e-12) * 255).astype(np.uint8)
    return low + cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255 * (high - low)


def _residual(
    terms: NDArray[np.float64], values: NDArray[np.float64], members: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """By how much all values are off the fit to some of them, of which a second fit leaves out the farthest tenth."""
    chosen = members
    for _ in range(2):
        fit = np.linalg.lstsq(terms[chosen], values[chosen], rcond=None)[0]
        off = values - terms @ fit
        chosen = members & (np.abs(off) <= np.quantile(np.abs(off[members]), 0.9))
    return off


def _deviation(residual: NDArray[np.float64]) -> float:
    return math.sqrt(float(np.mean(residual**2)))


def _smoothed(known: NDArray[np.bool_], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at the known samples, averaged with those around, everywhere."""
    spread = np.zeros(known.shape)
    bound = float(np.median(np.abs(values))) + 1e-15
    spread[known] = np.clip(values, -bound, bound)  # so that none outweighs all around it
    fine, wide = (cv2.GaussianBlur(spread, (0, 0), sigma) for sigma in (1.5, 12.0))
    return np.where(np.abs(fine) > 1e-6 * bound, fine, wide)


def _parted(block: NDArray[np.bool_], sides: NDArray[np.int32], strength: NDArray[np.float32]) -> NDArray[np.int32]:
    """The block's pixels by surface, 1 or 2, parted where between them the edges are strongest; 0 off the block."""
    unsure = max(4.0, _UNSURE * math.hypot(*block.shape))
    distances = [
        cv2.distanceTransform(np.pad((sides == side).astype(np.uint8), 1, constant_values=1), cv2.DIST_L2, 5)[
            1:-1, 1:-1
        ]
        for side in (1, 2)
    ]
    sure = block & (np.maximum(*distances) > unsure)
    markers = np.where(sure, sides, 0)
    if np.unique(markers[sure]).size < 2:
        markers = np.where(block, sides, 0)
    return flood(strength, markers, block)


def _border(parts: NDArray[np.int32]) -> NDArray[np.float64] | None:
    """The longest line (n, 2) of (x, y) between the two parts."""
    cracks = find_cracks(parts)
    cracks = cracks[cracks.sides[:, 0] > 0]
    if len(cracks.start) < 3:
        return None
    paths = CrackPaths(cracks, np.ones(len(cracks.start)))
    longest = paths.longest()
    line = gaussian_filter1d(longest, 1.5, axis=0, mode="nearest")
    line[[0, -1]] = longest[[0, -1]]
    return line
