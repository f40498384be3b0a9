"""Cutting a block along a line."""

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
from ...data.pixel_grids import apart, both, mark
from ...errors import InputError
from ..edges.relief import Relief, find_relief
from ..extraction import contract, regions_between, snap_to_jumps
from ..flooding import flood
from ..merging import RegionGraph
from .borders import CrackPaths, find_cracks, have_border
from .patches import LabelPatch, Labels, Mask, Points, box_of, patch_within

_NEAR = 3.0
"""How far [px] from a line's end the block's boundary may be for the line to be led there; straight on twice as far."""

_FRAGMENT = 16
"""Parts of up to so many pixels come of a trembling line, and go along wherever they lie."""


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
    led on to it. None if the line does not part the block.

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
        How far [px] from an end of the line the boundary may be for the line to be led there; straight on twice as far.
    """
    parted = None if label in locked else _part(labels, label, points, near)
    if parted is None:
        return None
    numbers = np.full(parted.sizes.size, label, np.int32)
    following = int(labels.max()) + 1 if first_new is None else first_new
    for piece in parted.pieces:
        for part in piece[1:]:
            numbers[part] = following
            following += 1
    return parted.patch(labels, numbers)


def cut_off(
    labels: Labels, source: int, points: Points, label: int, locked: Collection[int] = (), near: float = _NEAR
) -> LabelPatch | None:
    """Give a block what a line cuts off from another: of the parts beside it, all but the largest part.

    If the largest part alone is beside it, and has a border with it, that is what it gets; if none is, all parts but
    the largest. None if the line does not part the block `source`, if that is `label` itself, or if one of them is
    locked.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    source : int
        The block to cut.
    points : sequence of (x, y)
        The line, as in `split`.
    label : int
        The block that gets what is cut off.
    locked : collection of int
        Blocks that must not change.
    near : float
        As in `split`; also how far [px] a part beside the block may be from it.
    """
    parted = None if label == source or {label, source} & set(locked) else _part(labels, source, points, near)
    if parted is None:
        return None
    taker = labels[parted.box] == label
    bordering = have_border(parted.parts, taker)
    distance = cv2.distanceTransform((~taker).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    beside = set(np.unique(parted.parts[distance <= max(near, 1.0)]).tolist())
    numbers = np.full(parted.sizes.size, source, np.int32)
    for largest, *others in parted.pieces:
        touching = [part for part in others if part in beside or parted.sizes[part] <= _FRAGMENT]
        if not touching:
            touching = [largest] if bordering[largest] else others
        numbers[touching] = label
    return parted.patch(labels, numbers)


def run_on(labels: Labels, label: int, points: Points, near: float = _NEAR) -> list[tuple[float, float]]:
    """A line whose ends in a block run on to the block's boundary, however far that is.

    They are led there as by `split` if it is near, and go straight on otherwise. It is no boundary where the block goes
    around another.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    label : int
        The block that is to be cut.
    points : sequence of (x, y)
        The line, two points or more.
    near : float
        As in `split`.

    Returns
    -------
    list of (x, y)
        The line with a point more at each end that has run on.
    """
    box = box_of(labels, label, rim=1)
    if box is None or len(points) < 2:
        return [(float(x), float(y)) for x, y in points]
    corner = box[1].start, box[0].start
    line = _led_on(labels[box] == label, np.asarray(points, np.float64) - corner, near, math.inf) + corner
    return [(float(x), float(y)) for x, y in line]


@dataclass(frozen=True, eq=False)
class _Parted:
    """A block that a line has cut.

    Attributes
    ----------
    box : tuple of slice
        Around the block.
    parts : ndarray of int32
        The number of the part at every pixel of the box; 0 off the block.
    sizes : ndarray of int
        Pixels of each part, by its number.
    pieces : list of list of int
        The parts of each connected piece of the block that the line has cut, the largest first.
    """

    box: Box
    parts: NDArray[np.int32]
    sizes: NDArray[np.intp]
    pieces: list[list[int]]

    def patch(self, labels: Labels, numbers: NDArray[np.int32]) -> LabelPatch | None:
        """The patch by which each part has a label of its own."""
        before = labels[self.box]
        return patch_within(self.box, before, np.where(self.parts > 0, numbers[self.parts], before).astype(np.int32))


def _part(labels: Labels, label: int, points: Points, near: float) -> _Parted | None:
    """A block in the parts that a line cuts it into; None if it stays whole."""
    box = None if label <= 0 or len(points) < 2 else box_of(labels, label, rim=1)
    if box is None:
        return None
    block = labels[box] == label
    line = np.asarray(points, np.float64) - (box[1].start, box[0].start)
    cut = block & _drawn(_led_on(block, line, near, 2 * near), block.shape)
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
    return _Parted(box, np.where(block, _spread(parts, cut), 0).astype(np.int32), sizes, pieces)


def _drawn(line: NDArray[np.float64], shape: tuple[int, ...]) -> Mask:
    drawn = np.zeros(shape, np.uint8)
    path = np.floor(line).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(drawn, [path], isClosed=False, color=1, thickness=1, lineType=cv2.LINE_4)
    return drawn > 0


def _led_on(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    filled = _filled(block)
    before, after = (_beyond(filled, some, near, far) for some in (line[::-1], line))
    return np.concatenate([before, line, after])


def _filled(block: Mask) -> Mask:
    """A block with all that it goes around."""
    beyond = np.pad(block.astype(np.uint8), 1)
    cv2.floodFill(beyond, None, (0, 0), 2, flags=4)
    return np.asarray(beyond[1:-1, 1:-1] != 2, bool)


def _beyond(block: Mask, line: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    """The point off the block that a line's end is led on to; none where it needs none, or is too far from any.

    That straight on is up to twice as far as `near`; or else the nearest, up to `near`; or else that straight on, up to
    `far`.
    """
    end, nowhere = line[-1], np.empty((0, 2))
    if not _holds(block, end[None])[0]:
        return nowhere
    distance = np.hypot(*(line - end).T)
    direction = end - line[distance >= min(2 * near, distance.max())][-1]
    length = math.hypot(*direction)
    steps = np.arange(0.5, min(far, math.hypot(*block.shape)) + 0.5, 0.5) if length > 0 else np.empty(0)
    straight = end + steps[:, None] / max(length, 1e-9) * direction
    off = np.flatnonzero(~_holds(block, straight))[:1]
    if off.size and steps[off[0]] <= 2 * near:
        return straight[off]
    reach = math.ceil(near)
    down, right = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    around = np.stack([np.floor(end[0]) + right + 0.5, np.floor(end[1]) + down + 0.5], axis=-1).reshape(-1, 2)
    distance = np.hypot(*(around - end).T)
    distance[_holds(block, around)] = np.inf
    nearest = int(np.argmin(distance))
    return around[nearest : nearest + 1] if distance[nearest] <= near else straight[off]


def _holds(block: Mask, points: NDArray[np.float64]) -> Mask:
    """Which points (x, y), float (n, 2), lie in a block."""
    column, row = np.floor(points).astype(np.intp).T
    held = (row >= 0) & (row < block.shape[0]) & (column >= 0) & (column < block.shape[1])
    return held & block[np.where(held, row, 0), np.where(held, column, 0)]


def _spread(parts: NDArray[np.int32], cut: Mask) -> NDArray[np.int32]:
    """The parts with the line's pixels, each in the part that is nearest through other pixels of the line."""
    spread = np.pad(parts, 1)
    width = spread.shape[1]
    flat = spread.ravel()
    waiting = np.flatnonzero(np.pad(cut, 1))
    while waiting.size:
        found = np.zeros(waiting.size, flat.dtype)
        for step in (-1, 1, -width, width):
            found = np.where(found == 0, flat[waiting + step], found)
        if not found.any():
            break
        flat[waiting] = found
        waiting = waiting[found == 0]
    return spread[1:-1, 1:-1]


# Where a block that holds two surfaces could be cut.

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


# Pieces of blocks: what a click can give to another block.


def piece_at(
    labels: NDArray[np.int32], x: float, y: float, regions: NDArray[np.int32] | None = None
) -> NDArray[np.bool_]:
    """The piece of a block that lies under a point.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    x, y : float
        The point in image coordinates.
    regions : ndarray of int32, shape (H, W), optional
        Regions of the extraction (`Extraction.contracted`). With them, the piece ends where the region under the point
        does, unless there is none.

    Returns
    -------
    ndarray of bool, shape (H, W)
        4-connected pixels of the same label, which may be 0; empty if the point is off the frame.
    """
    piece = np.zeros(labels.shape, bool)
    row, column = int(np.floor(y)), int(np.floor(x))
    if not (0 <= row < labels.shape[0] and 0 <= column < labels.shape[1]):
        return piece
    alike = labels == labels[row, column]
    if regions is not None and regions[row, column] > 0:
        alike &= regions == regions[row, column]
    # filled with 2 from the point on
    filled = alike.astype(np.uint8)
    cv2.floodFill(filled, None, (column, row), 2, flags=4)
    np.equal(filled, 2, out=piece)
    return piece
