"""Cutting a block along a line, suggesting such a line, and finding the piece under a point."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from ...data.blocks import Box
from ...data.frame import RGBDFrame
from ...data.parameters import BlockParameters
from ...data.pixel_grids import both, different_labels, flood, mark, spread
from ...errors import InputError
from ..edges.frame_edges import Relief, find_relief
from ..extraction import contract, cut_at_jumps, regions_between, snap_to_jumps
from ..merging import RegionGraph
from .borders import CrackPaths, find_cracks, have_border
from .patches import LabelPatch, Labels, Mask, Points, box_of, patch_within, values_at

_NEAR = 3.0
"""Maximum distance [px] of a line's end from the block's boundary to be extended to it; twice that straight on."""

_FRAGMENT = 16
"""Parts of up to this many pixels result from an unsteady line, and are cut off wherever they lie."""


def split(
    labels: Labels,
    label: int,
    points: Points,
    locked: Collection[int] = (),
    first_new: int | None = None,
    near: float = _NEAR,
) -> LabelPatch | None:
    """Cut a block along a line; the largest part keeps the label, the others get new ones.

    The line's own pixels go to the nearest part, and an end that stops a few pixels short of the block's boundary is
    extended to it. None if the line does not divide the block.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    label : int
        The block to cut.
    points : sequence of (x, y)
        The line, two points or more.
    locked : collection of int
        Blocks that must not change.
    first_new : int, optional
        Number of the first new block; one more than the largest label if left out.
    near : float
        Maximum distance [px] of a line's end from the boundary to be extended to it; twice that straight on.
    """
    cut_block = None if label in locked else _cut(labels, label, points, near)
    if cut_block is None:
        return None
    numbers = np.full(cut_block.sizes.size, label, np.int32)
    following = int(labels.max()) + 1 if first_new is None else first_new
    for piece in cut_block.pieces:
        for part in piece[1:]:
            numbers[part] = following
            following += 1
    return cut_block.patch(labels, numbers)


def cut_off(labels: Labels, source: int, points: Points, label: int, near: float = _NEAR) -> LabelPatch | None:
    """Cut a block along a line, and give the parts beside another block to that, except the largest part.

    If only the largest part is beside it and has a border with it, it gets that part; if none is, all parts but the
    largest. None if the line does not divide the block `source`, or if that is `label` itself.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    source : int
        The block to cut.
    points : sequence of (x, y)
        The line, as in `split`.
    label : int
        The block that gets the parts.
    near : float
        As in `split`; also the maximum distance [px] of a part beside the block from it.
    """
    cut_block = None if label == source else _cut(labels, source, points, near)
    if cut_block is None:
        return None
    taker = labels[cut_block.box] == label
    bordering = have_border(cut_block.parts, taker)
    distance = cv2.distanceTransform((~taker).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    beside = set(np.unique(cut_block.parts[distance <= max(near, 1.0)]).tolist())
    numbers = np.full(cut_block.sizes.size, source, np.int32)
    for largest, *others in cut_block.pieces:
        touching = [part for part in others if part in beside or cut_block.sizes[part] <= _FRAGMENT]
        if not touching:
            touching = [largest] if bordering[largest] else others
        numbers[touching] = label
    return cut_block.patch(labels, numbers)


def extend_to_boundary(labels: Labels, label: int, points: Points, near: float = _NEAR) -> list[tuple[float, float]]:
    """Extend the ends of a line inside a block to the block's boundary, at any distance.

    They are extended as by `split` if it is near, and straight on otherwise. The outline of a block that the block
    encloses is not part of its boundary.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    label : int
        The block to cut.
    points : sequence of (x, y)
        The line, two points or more.
    near : float
        As in `split`.

    Returns
    -------
    list of (x, y)
        The line with another point at each extended end.
    """
    box = box_of(labels, label, rim=1)
    if box is None or len(points) < 2:
        return [(float(x), float(y)) for x, y in points]
    corner = box[1].start, box[0].start
    line = _extended(labels[box] == label, np.asarray(points, np.float64) - corner, near, math.inf) + corner
    return [(float(x), float(y)) for x, y in line]


@dataclass(frozen=True, eq=False)
class _CutBlock:
    """A block cut by a line.

    Attributes
    ----------
    box : tuple of slice
        Box around the block.
    parts : ndarray of int32
        The number of the part at every pixel of the box; 0 outside the block.
    sizes : ndarray of int
        Number of pixels of each part, indexed by its number.
    pieces : list of list of int
        The parts of each connected piece of the block that the line cuts, the largest first.
    """

    box: Box
    parts: NDArray[np.int32]
    sizes: NDArray[np.intp]
    pieces: list[list[int]]

    def patch(self, labels: Labels, numbers: NDArray[np.int32]) -> LabelPatch | None:
        """The patch that gives each part its label."""
        before = labels[self.box]
        return patch_within(self.box, before, np.where(self.parts > 0, numbers[self.parts], before).astype(np.int32))


def _cut(labels: Labels, label: int, points: Points, near: float) -> _CutBlock | None:
    """The parts into which a line cuts a block; None if it stays whole."""
    box = None if label <= 0 or len(points) < 2 else box_of(labels, label, rim=1)
    if box is None:
        return None
    block = labels[box] == label
    line = np.asarray(points, np.float64) - (box[1].start, box[0].start)
    cut = block & _drawn(_extended(block, line, near, 2 * near), block.shape)
    _, whole = cv2.connectedComponents(block.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    count, parts = cv2.connectedComponents((block & ~cut).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    sizes = np.bincount(parts.ravel(), minlength=count)
    piece_of = np.zeros(count, np.intp)
    piece_of[parts[block]] = whole[block]
    pieces = []
    for piece in np.unique(whole[cut]):
        found = np.flatnonzero(piece_of == piece)
        if np.count_nonzero(found) > 1:
            pieces.append(sorted(found[found > 0].tolist(), key=lambda number: -sizes[number]))
    if not pieces:
        return None
    # each of the line's pixels goes to the part that is nearest through others
    parts = spread(parts.astype(np.int32), cut, both(np.ones(block.shape, bool)), cut.size)
    return _CutBlock(box, np.where(block, parts, 0), sizes, pieces)


def _drawn(line: NDArray[np.float64], shape: tuple[int, ...]) -> Mask:
    drawn = np.zeros(shape, np.uint8)
    path = np.floor(line).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(drawn, [path], isClosed=False, color=1, thickness=1, lineType=cv2.LINE_4)
    return drawn > 0


def _extended(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    # the outlines of its holes are not its boundary
    beyond = np.pad(block.astype(np.uint8), 1)
    cv2.floodFill(beyond, None, (0, 0), 2, flags=4)
    filled = np.asarray(beyond[1:-1, 1:-1] != 2, bool)
    before, after = (_extension_point(filled, some, near, far) for some in (line[::-1], line))
    return np.concatenate([before, line, after])


def _extension_point(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    """The point outside the block to which a line's end is extended; empty if none is needed, or all are too far.

    It is the point straight on within twice `near`; or else the nearest one within `near`; or else the point straight
    on within `far`.
    """
    end, nowhere = line[-1], np.empty((0, 2))
    if not values_at(block, end[None], False)[0]:
        return nowhere
    distance = np.hypot(*(line - end).T)
    direction = end - line[distance >= min(2 * near, distance.max())][-1]
    length = math.hypot(*direction)
    steps = np.arange(0.5, min(far, math.hypot(*block.shape)) + 0.5, 0.5) if length > 0 else np.empty(0)
    straight = end + steps[:, None] / max(length, 1e-9) * direction
    off = np.flatnonzero(~values_at(block, straight, False))[:1]
    if off.size and steps[off[0]] <= 2 * near:
        return straight[off]
    reach = math.ceil(near)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    around = np.stack([np.floor(end[0]) + right + 0.5, np.floor(end[1]) + down + 0.5], axis=-1).reshape(-1, 2)
    distance = np.hypot(*(around - end).T)
    distance[values_at(block, around, False)] = np.inf
    nearest = int(np.argmin(distance))
    return around[nearest : nearest + 1] if distance[nearest] <= near else straight[off]


# Suggesting where to cut a block with two surfaces.

_SAMPLES = 90
"""Maximum number of depth samples along the longer side of the block's box."""

_KNOWN, _SHARE = 30, 0.04
"""Minimum number of samples of a surface, and minimum fraction of all samples for each of the two."""

_NOISE_SHARE, _NOISE_PER_METRE = 0.005, 0.0015
"""Maximum RMS deviation of a single smooth surface, as a fraction of the depth: the larger of a constant and a term
that grows with depth."""

_MAX_DEVIATION_RATIO = 0.55
"""Maximum deviation from two planes, as a fraction of the deviation from one curved surface."""

_MIN_PART_PIXELS = 60
"""Minimum number of pixels of a part beyond a jump."""

_SEEN = 0.5
"""Minimum fraction of the border between two parts along which depth jumps."""

_BELOW_JUMPS = 0.9
"""Factor on the edge strength off jumps, so that jumps are the highest."""

_MAX_SURFACE_COST = 2.0
"""Maximum cost of a border between regions of one surface: above any without a jump."""

_ROUNDS = 12

_BAND_SHARE = 0.03
"""Width of the band between the surfaces in which edges decide, as a fraction of the box's diagonal; at least 4 px."""


def suggest_split(
    frame: RGBDFrame, labels: NDArray[np.int32], label: int, strength: NDArray[np.float32]
) -> list[tuple[float, float]] | None:
    """Suggest a line that separates the two surfaces in a block, from known depth and edges.

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
        A line for `split`, in image coordinates; None if the known depth is on one surface, too little is known, or
        the two surfaces are not adjacent.
    """
    box = box_of(labels, label) if label > 0 else None
    if box is None:
        return None
    block = labels[box] == label
    depth = np.where(block, frame.depth[box], np.float32(np.nan))
    parts = _at_jumps(frame.edge_rgb[box], depth, block, strength[box])
    if parts is None:
        sides = _two_surfaces(depth)
        parts = None if sides is None else _divided(block, sides, strength[box])
    line = None if parts is None else _border(parts)
    if line is None:
        return None
    points = [(float(x), float(y)) for x, y in line + np.array([box[1].start, box[0].start])]
    return points if split(labels, label, points) is not None else None


def _at_jumps(
    rgb: NDArray[np.uint8], depth: NDArray[np.float32], block: NDArray[np.bool_], strength: NDArray[np.float32]
) -> NDArray[np.int32] | None:
    """Divide the block's pixels into two parts, 1 and 2, with a jump along most of their border; None without one."""
    usual = BlockParameters()
    relief = find_relief(depth, usual.depth_jump, usual.depth_jump_share)
    if not any(pairs.any() for pairs in relief.jumps):
        return None
    edges = mark(relief.jumps)
    guide = np.where(edges, np.float32(1), np.float32(_BELOW_JUMPS) * strength)
    regions = snap_to_jumps(contract(regions_between(edges, 1.0, block), guide, block), relief.jumps)
    regions = cut_at_jumps(regions, guide, relief)
    try:
        graph = RegionGraph(regions, strength, RGBDFrame(rgb, depth), relief)
    except InputError:  # the depth of this block alone may be outside the valid scale
        return None
    graph.merge_below(_MAX_SURFACE_COST)
    surfaces = graph.labels()
    least = max(_SHARE * np.count_nonzero(block), _MIN_PART_PIXELS)
    for surface in range(1, int(surfaces.max()) + 1):
        part = surfaces == surface
        if least <= np.count_nonzero(part) <= np.count_nonzero(block) / 2 and _jump_share(part, block, relief) >= _SEEN:
            return np.where(block, np.where(part, np.int32(2), np.int32(1)), np.int32(0))
    return None


def _jump_share(part: NDArray[np.bool_], block: NDArray[np.bool_], relief: Relief) -> float:
    """Fraction of a part's border to the rest of its block along which depth jumps."""
    border = [rim & inside for rim, inside in zip(different_labels(part.astype(np.int32)), both(block), strict=True)]
    length = sum(np.count_nonzero(some) for some in border)
    along = sum(np.count_nonzero(some & jumps) for some, jumps in zip(border, relief.jumps, strict=True))
    return along / max(length, 1)


def _two_surfaces(depth: NDArray[np.float32]) -> NDArray[np.int32] | None:
    """For every pixel the surface, 1 or 2, whose plane is nearer to its surroundings; None if there are not two."""
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
    one = math.sqrt(float(np.mean(_residual(curved, inverse, np.ones(x.size, bool)) ** 2))) / typical
    if one <= max(_NOISE_SHARE, _NOISE_PER_METRE / typical):
        return None
    best, least = None, _MAX_DEVIATION_RATIO * one
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
    """Otsu's threshold, which minimises the variance within the two classes."""
    low, high = float(values.min()), float(values.max())
    levels = ((values - low) / max(high - low, 1e-12) * 255).astype(np.uint8)
    return low + cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255 * (high - low)


def _residual(
    terms: NDArray[np.float64], values: NDArray[np.float64], members: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Residuals of all values from a fit to some of them; a second fit leaves out the farthest tenth of those."""
    chosen = members
    for _ in range(2):
        fit = np.linalg.lstsq(terms[chosen], values[chosen], rcond=None)[0]
        off = values - terms @ fit
        chosen = members & (np.abs(off) <= np.quantile(np.abs(off[members]), 0.9))
    return off


def _smoothed(known: NDArray[np.bool_], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smoothed values everywhere, from the values at the known samples."""
    spread = np.zeros(known.shape)
    bound = float(np.median(np.abs(values))) + 1e-15
    spread[known] = np.clip(values, -bound, bound)  # limits the weight of single values
    fine, wide = (cv2.GaussianBlur(spread, (0, 0), sigma) for sigma in (1.5, 12.0))
    return np.where(np.abs(fine) > 1e-6 * bound, fine, wide)


def _divided(block: NDArray[np.bool_], sides: NDArray[np.int32], strength: NDArray[np.float32]) -> NDArray[np.int32]:
    """The block's pixels by surface, 1 or 2, divided where the edges between are strongest; 0 outside the block."""
    unsure = max(4.0, _BAND_SHARE * math.hypot(*block.shape))
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


# Pieces of blocks that a click can give to another block.


def piece_at(
    labels: NDArray[np.int32], x: float, y: float, regions: NDArray[np.int32] | None = None
) -> NDArray[np.bool_]:
    """The piece of a block under a point.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    x, y : float
        The point in image coordinates.
    regions : ndarray of int32, shape (H, W), optional
        Regions of the extraction (`Extraction.contracted`). With them, the piece is limited to the region under the
        point, if there is one.

    Returns
    -------
    ndarray of bool, shape (H, W)
        4-connected pixels of the same label, which may be 0; empty if the point is outside the frame.
    """
    piece = np.zeros(labels.shape, bool)
    row, column = int(np.floor(y)), int(np.floor(x))
    if not (0 <= row < labels.shape[0] and 0 <= column < labels.shape[1]):
        return piece
    alike = labels == labels[row, column]
    if regions is not None and regions[row, column] > 0:
        alike &= regions == regions[row, column]
    # fill with 2, starting at the point
    filled = alike.astype(np.uint8)
    cv2.floodFill(filled, None, (column, row), 2, flags=4)
    np.equal(filled, 2, out=piece)
    return piece
