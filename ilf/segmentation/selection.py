"""Selecting a surface or object by points inside and outside of it, from the regions of a tree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from ..data.arrays import check_shape, plain_array
from ..data.blocks import Box, box_between
from ..data.frame import RGBDFrame, checked_frame
from ..data.pixel_grids import rim
from ..errors import InputError, told_as
from .editing.patches import Points
from .region_tree import RegionTree, region_tree

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

Strokes = Sequence[tuple[float, float]] | Sequence[Points]
"""Points (x, y), or sequences of points."""


def _several(points: Any) -> Any:
    """Points and strokes as a sequence: a single point (x, y) is one of these."""
    is_one = isinstance(points, Sequence) and len(points) == 2 and all(isinstance(number, Real) for number in points)
    return [points] if is_one else points


def _stroke(tree: RegionTree, given: tuple[float, float] | Points) -> tuple[Array, list[int]]:
    """A point or stroke: its points, float64 (N, 2), and the pieces under them."""
    with told_as(
        InputError, f"A point or stroke is (x, y), or several of these, not {given!r:.60}.", (TypeError, ValueError)
    ):
        points = np.asarray(plain_array(given), np.float64).reshape(-1, 2)
    height, width = tree.pieces.shape
    if not len(points):
        raise InputError("A stroke needs at least one point.")
    for x, y in points:
        if not (0 <= x < width and 0 <= y < height):
            raise InputError(f"The point ({x:g}, {y:g}) lies outside the frame of {width} x {height} pixels.")
    columns, rows = points.astype(int).T
    return points, np.unique(tree.pieces[rows, columns]).tolist()


# The selection: every point changes it by the likeliest of some parts.

_STEP, _LONG_STEP = 1.2, 2.0
"""Minimum ratio of the sizes of two parts that count as different steps from part to object, and the ratio up to which
the likeliest one is the next."""

_MAX_PARTS = 60
"""Approximate maximum number of parts among which that of a stroke is chosen."""

_INSIDE_BOX, _BOX_SHARE = 0.95, 0.1
"""Minimum share of a node inside a box for belonging to it, and the share of the box that it must cover if no point is
given."""


def select_region(
    frame: RGBDFrame,
    inside: Strokes,
    outside: Strokes = (),
    box: tuple[float, float, float, float] | None = None,
    *,
    steps: int | Sequence[int] = 0,
    start: Mask | None = None,
) -> Mask:
    """Select the surface or object at some points, by colour and depth.

    The frame is divided into small pieces along its edges, which merge step by step to a tree of regions; it is cached
    with the frame. Each point inside, in order, adds the likeliest region around it; then each point outside takes the
    likeliest part away. A part is the likelier the clearer its border, and the nearer the point is to its middle.

    Parameters
    ----------
    frame : RGBDFrame
    inside : sequence of (x, y), or of strokes
        Points of the object in image coordinates: pixel (row r, column c) covers x in [c, c + 1), y in [r, r + 1). A
        sequence of points in place of one is a stroke, which adds one part with all of its points.
    outside : sequence of (x, y), or of strokes, optional
        Points that do not belong to it.
    box : (left, top, right, bottom), optional
        A box around the object [px]; regions that continue beyond it are not selected. Without points inside, the large
        regions in it are.
    steps : int or sequence of int
        Steps from the likeliest region at the last point inside, or at each, or without any from what lies in the box:
        positive to larger regions (the object), negative to smaller ones (its parts).
    start : ndarray of bool, shape (H, W), optional
        A selection that the points change.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The selected pixels: those of every point inside, and of no point outside, unless both lie in one piece, which
        then is selected.

    Raises
    ------
    InputError
        If the input is not a frame, a point or the box lies outside of it, a stroke is empty, the start has another
        shape, there are neither points inside nor a box nor a start, or there are not as many steps as points inside.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> rgb = np.full((40, 60, 3), 60, np.uint8)
    >>> rgb[:, 20:] = 200
    >>> frame = ilf.RGBDFrame(rgb, np.where(rgb[..., 0] == 60, 1.0, 2.0))
    >>> mask = ilf.select_region(frame, [(40, 20)])
    >>> bool(mask[20, 40]), bool(mask[20, 10]), mask.shape
    (True, False, (40, 60))
    """
    checked_frame(frame)
    inside, outside = _several(inside), _several(outside)
    if box is None and start is None and not len(inside):
        raise InputError("Give at least one point inside, a box, or a selection to start with.")
    if start is not None:
        start = plain_array(start)
        check_shape("The selection to start with", start.shape, frame.shape)
    each = [0] * (len(inside) - 1) + [steps] if isinstance(steps, int) else steps
    if len(inside) and len(each) != len(inside):
        raise InputError(f"Give one number of steps for each of the {len(inside)} points inside.")
    shown = None if box is None else box_between(np.array(box[:2], float), np.array(box[2:], float), frame.shape)
    if box is not None and shown is None:
        raise InputError("The box contains no pixel of the frame.")
    tree = region_tree(frame)
    added, removed = ([_stroke(tree, points) for points in side] for side in (inside, outside))
    wanted, unwanted = (sorted({piece for _, pieces in side for piece in pieces}) for side in (added, removed))
    pixels = tree.pixels[: tree.order.size]
    before = np.zeros(pixels.size, bool)
    if start is not None:
        before = np.bincount(tree.pieces[start], minlength=pixels.size) > pixels / 2
    chosen, changed = before.copy(), np.zeros(pixels.size, bool)
    if shown is not None and not wanted:
        chosen |= _largest(tree, shown, steps if isinstance(steps, int) else 0)
        changed |= chosen & ~before
    for (points, pieces), stepped in zip(added, each[: len(added)], strict=True):
        parts = regions_around(tree, pieces, [], shown)
        known = chosen[pieces].all()
        scores = part_scores(tree, np.zeros_like(chosen) if known else chosen, parts, points, adds=True)
        found = int(np.argmax(scores))
        if known:  # the largest region that is selected already
            found = max(int(np.flatnonzero((chosen | ~parts).all(axis=1)).max(initial=0)), 0)
        part = parts[_stepped(parts @ pixels, parts, found, stepped, scores)]
        chosen, changed = chosen | part, changed | part
    for points, under in removed:
        pieces = [piece for piece in under if chosen[piece] and piece not in wanted]
        if pieces:
            parts = removable_parts(tree, chosen, pieces, wanted, unwanted)
            part = parts[np.argmax(part_scores(tree, chosen, parts, points, adds=False))]
            chosen, changed = chosen & ~part, changed | part
    chosen[wanted] = changed[wanted] = True
    mask = np.asarray(chosen[tree.pieces])
    return mask if start is None else np.where(changed[tree.pieces], mask, start)


def regions_around(tree: RegionTree, pieces: Sequence[int], others: Sequence[int], box: Box | None = None) -> Mask:
    """Return the parts that a point or stroke may add, bool (K, n), from small to large, in every order of merging.

    They are the regions around a piece that contain none of others; for more pieces, one region around each, of at most
    the same size.
    """
    parts = np.concatenate([_in_one_order(one, pieces, others, box) for one in (tree, *tree.others)])
    _, first = np.unique(np.packbits(parts, axis=1), axis=0, return_index=True)
    parts = parts[np.sort(first)]
    return parts[np.argsort(parts @ tree.pixels[: tree.order.size], kind="stable")]


def _in_one_order(tree: RegionTree, pieces: Sequence[int], others: Sequence[int], box: Box | None) -> Mask:
    fits = None if box is None else _fitting(tree, box)
    chains = [[k for k in _without(tree, piece, others) if fits is None or fits[k]] or [piece] for piece in pieces]
    limits = np.unique(np.concatenate([tree.pixels[chain] for chain in chains]))
    limits = limits[limits >= max(tree.pixels[chain[0]] for chain in chains)]
    limits = limits[:: -(-limits.size // _MAX_PARTS)] if len(chains) > 1 else limits
    places = np.stack([np.searchsorted(tree.pixels[chain], limits, side="right") - 1 for chain in chains])
    nodes = [{chain[k] for chain, k in zip(chains, column, strict=True)} for column in places.T]
    return np.stack([tree.masks(sorted(some)).any(axis=0) for some in nodes])


def _without(tree: RegionTree, piece: int, others: Sequence[int]) -> list[int]:
    """The nodes that contain a piece and none of others, from itself on; at least the piece."""
    places = tree.first[list(others)]  # of a piece: its place in the order
    nodes = tree.above(piece)
    return [k for k in nodes if not ((tree.first[k] <= places) & (places < tree.stop[k])).any()] or [piece]


def _stepped(sizes: Array, parts: Mask, found: int, steps: int, scores: Array | None = None) -> int:
    """The index some steps from another, among parts from small to large: each part lies in the larger ones.

    A step leads to the likeliest part of the next sizes, or to the nearest one without scores.
    """
    larger, number = steps > 0, np.arange(sizes.size)
    for _ in range(abs(steps)):
        here = parts[found]
        nested = ~(here & ~parts).any(axis=1) if larger else ~(parts & ~here).any(axis=1)
        ratio = sizes / sizes[found] if larger else sizes[found] / sizes
        last = sizes.size - 1 if larger else 0
        possible = nested & ((ratio >= _STEP) | (number == last)) & (number != found)
        if not possible.any():
            break
        nearest = ratio[possible].min()
        possible &= ratio <= max(_LONG_STEP, nearest)
        found = int(np.argmax(np.where(possible, -ratio if scores is None else scores, -np.inf)))
    return found


def _fitting(tree: RegionTree, shown: Box) -> Mask:
    """The nodes that lie in a box."""
    within = np.bincount(tree.pieces[shown].ravel(), minlength=tree.order.size)[tree.order]
    before = np.concatenate([[0], np.cumsum(within)])
    return np.asarray(before[tree.stop] - before[tree.first] >= _INSIDE_BOX * tree.pixels)


def _largest(tree: RegionTree, box: Box, steps: int) -> Mask:
    """The pieces of the largest regions in a box: of all that cover enough of it, or of one; steps add or leave out
    regions, in order of their size."""
    fits = _fitting(tree, box)
    whole = np.flatnonzero(fits & ~((tree.parents >= 0) & fits[tree.parents]))
    if not whole.size:
        return np.zeros(tree.order.size, bool)
    whole = whole[np.argsort(-tree.pixels[whole], kind="stable")]
    sizes = tree.pixels[whole]
    enough = _BOX_SHARE * (box[0].stop - box[0].start) * (box[1].stop - box[1].start)
    found = int(np.count_nonzero(sizes >= min(enough, sizes[0]))) - 1
    together = np.logical_or.accumulate(tree.masks(whole.tolist()))
    return np.asarray(together[_stepped(np.cumsum(sizes), together, found, steps)])


# What a point outside may take away.

_COLOUR_COST, _DEPTH_COST, _MAX_DEPTH_COST, _PIECE_COST = 1 / 40, 2.0, 1.0, 0.02
"""Cost of a way across a border, beside its mean edge: per difference of colour [CIELAB] and of log depth, the maximum
of the latter, and of any border."""

_NEARER = (0.33, 0.6, 1.0, 1.6, 3.0)
"""Ratios of the ways to a point outside and to the nearest point inside up to which pieces are taken away."""


def removable_parts(
    tree: RegionTree, chosen: Mask, pieces: Sequence[int], wanted: Sequence[int], unwanted: Sequence[int]
) -> Mask:
    """Return the parts of a selection that a point or stroke outside may take away, bool (K, n), each with its pieces.

    They are the regions around it without a point inside; all but a region with every point inside and none outside;
    and the pieces that are nearer to it than to the points inside, by ways that cross few edges, and little change of
    colour and depth.
    """
    parts = [regions_around(tree, pieces, wanted)]
    if len(wanted):
        kept = tree.masks(_without(tree, wanted[0], unwanted))
        parts.append(~kept[kept[:, list(wanted)].all(axis=1)])
        one, other = tree.ends.T
        depth = np.minimum(_DEPTH_COST * np.abs(tree.depth[one] - tree.depth[other]), _MAX_DEPTH_COST)
        colour = _COLOUR_COST * np.linalg.norm(tree.colour[one] - tree.colour[other], axis=1)
        costs = tree.borders[:, 1] / tree.borders[:, 0] + colour + depth + _PIECE_COST
        ways = csr_matrix((costs, (one, other)), (chosen.size, chosen.size))
        here, there = (dijkstra(ways, directed=False, indices=list(some), min_only=True) for some in (pieces, wanted))
        parts.append(here < np.array(_NEARER)[:, None] * there)
    return np.asarray(np.concatenate(parts) & chosen)


# How likely a part is: linear in its properties.

KINDS = ("first", "further", "outside")
"""Kinds of points: the first one, further ones inside, and those outside."""

COEFFICIENTS = np.array(
    [
        (7.021, 0.28, -1.962),  # mean edge along the border of the part
        (-8.341, -3.431, 0.152),  # share of the border that is weak
        (-1.202, 0.904, -1.837),  # its length in relation to the size
        (-0.95, -1.016, -0.791),  # share of the frame as a logarithm
        (-0.257, -0.018, 0.055),  # its square
        (-27.545, -10.809, -13.757),  # share of the frame
        (7.021, 3.062, 8.327),  # of the selection after the change: mean edge
        (-8.341, -7.96, -6.61),  # weak share
        (-1.202, 0.268, -0.498),  # length
        (20.245, -62.245, 125.267),  # mean step of log depth
        (20.245, 36.849, -5.342),  # of the part's border: mean step of log depth
        (5.473, 1.295, 1.447),  # share between pieces of other colours
        (-8.79, -9.646, -1.503),  # share of the frame's rim
        (0.0, 12.551, -2.576),  # share of the part's border to the rest of the selection
        (-0.0, -3.795, 9.047),  # mean edge there
        (0.0, -0.638, -0.986),  # ratio of the sizes
        (0.0, -0.185, -0.315),  # its square
        (0.7, -1.26, 0.488),  # difference of colour
        (-0.16, -0.444, 0.306),  # difference of depth
        (15.075, 6.975, 5.723),  # nearness of the points to the middle
        (0.274, 1.881, 2.872),  # its logarithm
        (-0.702, 0.83, 1.095),  # distance of the points from the border
    ]
)
"""Coefficient of every property of `part_properties` for each kind: fitted once on 60 generated scenes, so that with
parts weighted by the exponential of their score, the mean IoU with the object is largest."""

_COARSE = 19_200
"""Approximate number of pixels at which the middle of a part is searched."""


def part_scores(tree: RegionTree, chosen: Mask, parts: Mask, points: Array, adds: bool) -> Array:
    """Return how likely each part, bool (K, n), is what points add to a selection or take away, as a logarithm."""
    kind = "outside" if not adds else "further" if chosen.any() else "first"
    return np.asarray(part_properties(tree, chosen, parts, points, adds) @ COEFFICIENTS[:, KINDS.index(kind)])


def part_properties(tree: RegionTree, chosen: Mask, parts: Mask, points: Array, adds: bool) -> Array:
    """Return the properties of parts that points, float64 (N, 2), add to a selection or take away, float64 (K, 22).

    Of a part: mean edge along its border, share of the border that is weak, length of the border in relation to the
    size, logarithm of the share of the frame, its square, and the share. Of the selection after the change: the first
    three. Of both: share of the part's border that divides it from the rest of the selection, mean edge there,
    logarithm of the ratio of sizes and its square, difference of mean colour and of mean log depth as logarithms. Of
    the points: their distance from the border of the part in relation to the largest one inside, the logarithm of this,
    and that of the distance.
    """
    if adds:
        parts = parts & ~chosen
    after, pixels = parts ^ chosen, tree.pixels[: chosen.size]
    outer, size = _borders_of(tree, parts), np.maximum(parts @ pixels, 1)
    old, new = _borders_of(tree, chosen[None]), _borders_of(tree, after)
    shared = (outer + old - new if adds else outer + new - old) / 2
    rest = chosen[None] if adds else after
    rest_size = np.maximum(rest @ pixels, 1)
    means = [
        (which * pixels) @ np.column_stack([tree.colour, tree.depth]) / sizes[:, None]
        for which, sizes in ((parts, size), (rest, rest_size))
    ]
    apart = means[0] - means[1]
    ratio = np.log(size / max(chosen @ pixels, 1)) if chosen.any() else np.zeros(size.size)
    here, largest = _depths(tree, parts, points)
    share = np.log(size / tree.pixels[-1])
    return np.column_stack(
        [
            *_border_properties(outer, size),
            share,
            share**2,
            np.exp(share),
            *_border_properties(new, np.maximum(after @ pixels, 1)),
            new[:, 3] / np.maximum(new[:, 0], 1),
            *_beside(tree, parts, outer),
            shared[:, 0] / np.maximum(outer[:, 0], 1),
            np.where(shared[:, 0] > 0, shared[:, 1] / np.maximum(shared[:, 0], 1), 0.3),
            ratio,
            ratio**2,
            np.log(np.linalg.norm(apart[:, :3], axis=1) + 2),
            np.log(np.abs(apart[:, 3]) + 0.01),
            here / largest,
            np.log(here / largest),
            np.log(here),
        ]
    )


def _beside(tree: RegionTree, parts: Mask, outer: Array) -> list[Array]:
    """Of the border of parts: mean step of log depth, share where pieces differ in colour, and share of the frame's."""
    length = np.maximum(outer[:, 0], 1)
    apart = np.linalg.norm(tree.colour[tree.ends[:, 0]] - tree.colour[tree.ends[:, 1]], axis=1) > _OTHER_COLOUR
    crossed = parts[:, tree.ends[:, 0]] != parts[:, tree.ends[:, 1]]
    at_rim = parts @ np.bincount(rim(tree.pieces), minlength=tree.order.size).astype(np.float64)
    return [
        outer[:, 3] / length,
        crossed @ (apart * tree.borders[:, 0]).astype(np.float64) / length,
        at_rim / (length + at_rim),
    ]


_OTHER_COLOUR = 10.0


def _borders_of(tree: RegionTree, sets: Mask) -> Array:
    """What `borders` of the tree say of the border of sets of pieces, float64 (K, 4)."""
    return np.asarray((sets[:, tree.ends[:, 0]] != sets[:, tree.ends[:, 1]]) @ tree.borders.astype(np.float64))


def _border_properties(borders: Array, pixels: Array) -> list[Array]:
    length = np.maximum(borders[:, 0], 1)
    return [borders[:, 1] / length, borders[:, 2] / length, np.log(length / np.sqrt(pixels))]


def _depths(tree: RegionTree, parts: Mask, points: Array) -> tuple[Array, Array]:
    """Largest distance of points from the border of parts, and of all pixels inside, in coarse pixels; at least 0.5."""
    step = max(round(math.sqrt(tree.pieces.size / _COARSE)), 1)
    coarse = np.pad(tree.pieces[step // 2 :: step, step // 2 :: step], 1, constant_values=-1)
    columns, rows = np.minimum(points.astype(int) // step + 1, np.array(coarse.shape[::-1]) - 2).T
    found = []
    for part in parts:
        inside = np.append(part, False)[coarse].astype(np.uint8)
        inside[rows, columns] = 1
        distance = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
        found.append((distance[rows, columns].max(), distance.max()))
    here, largest = np.maximum(np.array(found, np.float64), 0.5).T
    return here, largest
