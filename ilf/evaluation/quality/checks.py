"""The quality checks of a frame: several surfaces in a block, weak borders, islands, slivers, high expected errors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from ..._runtime.long_work import check_cancelled
from ...data.arrays import check_shape
from ...data.blocks import Box, checked_labels, find_blocks
from ...data.frame import RGBDFrame
from ...data.pixel_grids import (
    Pairs,
    connected_regions,
    different_labels,
    long_lines,
    mark,
    mark_both,
    nearest_values,
    neighbours,
    rim,
    sides,
)
from ...segmentation.edges.frame_edges import JUMP_LENGTH
from .places import CheckInput, Place, largest_groups, make_check_input, number_groups, point_in

# Blocks with more than one surface: depth jumps inside them, in known or in missing depth.

_REACH = 24
"""Distance [px] up to which an error affects filled depth, decreasing with distance; also the maximum displacement of
a wrong border."""

_KNOWN_WEIGHT = 0.03
"""Weight of a known pixel near an error, relative to a pixel to be filled."""

BESIDE = 2
"""Distance [px] from a jump at which the depth on its sides is read, since pixels right beside it may be mixed; also
the distance up to which an edge belongs to a border."""


_FAR = 20.0
"""Distance [px] between two known pixels at which a difference between their surfaces has half weight: across a wide
gap, it may also be a bend."""

_FOUND, _AROUND = 0.5, 7
"""Edge strength that confirms a jump in missing depth, and the distance [px] in which it is searched."""

_WEIGHT_WITHOUT_EDGE = 0.3
"""Weight of a difference between two surfaces without a colour edge between them."""


def find_multiple_surfaces(inputs: CheckInput) -> Iterator[Place]:
    """Find depth jumps inside blocks, and blocks with two surfaces separated only by missing depth."""
    jumps, hidden = find_steps(inputs)
    step = np.maximum(jumps, hidden)
    numbers = number_groups(step > 0, inputs.labels)
    if not numbers.any():
        return
    for box, inside, harm in largest_groups(numbers, _harm(inputs, numbers, step)):
        label, seen = int(inputs.labels[box][inside][0]), jumps[box][inside]
        if np.count_nonzero(seen) * 2 > seen.size:
            height = float(np.median(step[box][inside]))
            kind, reason = "jump", f"Depth jumps by {height:.2f} m inside Block {label}."
        else:
            near, far = _beside(inputs, label, box, inside)
            kind, reason = "surfaces", f"Block {label} contains two surfaces, at {near:.2f} m and {far:.2f} m."
        yield Place(kind, box, (label,), point_in(box, inside), harm, reason)


def find_steps(inputs: CheckInput) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heights [m] of the jumps in known depth inside blocks, and distances [m] of surfaces that meet in missing depth
    inside a block; float64 (H, W), 0 elsewhere."""
    return _jumps(inputs), _hidden(inputs)


def _harm(inputs: CheckInput, numbers: NDArray[np.int32], step: NDArray[np.float64]) -> NDArray[np.float64]:
    """For every group, the pixels to be filled around it, weighted by the step [m] at the nearest of its pixels."""
    away, nearest = nearest_values(np.arange(numbers.size).reshape(numbers.shape), numbers > 0)
    reached = nearest[away < _REACH]
    labels = inputs.labels
    counts = (labels[away < _REACH] == labels.ravel()[reached]) * np.where(
        inputs.missing[away < _REACH], 1.0, _KNOWN_WEIGHT
    )
    faded = 1 - away[away < _REACH] / _REACH
    weights = counts * faded * step.ravel()[reached]
    harm = np.bincount(numbers.ravel()[reached], weights, minlength=int(numbers.max()) + 1)
    return np.asarray(harm, np.float64)


def _jumps(inputs: CheckInput) -> NDArray[np.float64]:
    """Height [m] of jumps in known depth inside blocks, 0 elsewhere."""
    found, depth = np.zeros(inputs.labels.size), inputs.depth.ravel()
    jumps = inputs.relief.jumps
    inner = long_lines((jumps[0] & inputs.inner[:, :-1], jumps[1] & inputs.inner[:-1]), JUMP_LENGTH)
    for (down, right), pairs in zip(((0, 1), (1, 0)), inner, strict=True):
        at = np.pad(pairs, ((0, down), (0, right)))
        one, other = (flat_indices(at, (down, right), by) for by in (-BESIDE, 1 + BESIDE))
        step = np.abs(depth[one].astype(np.float64) - depth[other])
        found[at.ravel()] = np.maximum(found[at.ravel()], step)
    return found.reshape(inputs.labels.shape)


def flat_indices(mask: NDArray[np.bool_], step: tuple[int, int], by: int) -> NDArray[np.intp]:
    """Flat indices of the pixels of a mask, moved by a number of steps (down, right), inside the frame."""
    rows, columns = (
        np.clip(at + by * along, 0, size - 1)
        for at, along, size in zip(np.nonzero(mask), step, mask.shape, strict=True)
    )
    return np.asarray(rows * mask.shape[1] + columns, np.intp)


def _hidden(inputs: CheckInput) -> NDArray[np.float64]:
    """Distance [m] between surfaces that meet in missing depth inside a block, 0 elsewhere; reduced where that is
    uncertain."""
    found = np.zeros(inputs.labels.shape)
    pieces = inputs.pieces.ravel()
    width = inputs.labels.shape[1]
    square = np.ones((2 * _AROUND + 1,) * 2, np.uint8)
    edge = cv2.dilate(np.where(inputs.inner, inputs.strength, np.float32(0)), square)
    seen = _WEIGHT_WITHOUT_EDGE + (1 - _WEIGHT_WITHOUT_EDGE) * np.minimum(edge / _FOUND, 1.0)
    for side, (one, other) in enumerate(sides(inputs.source)):
        rows, columns = np.nonzero(_inside(inputs)[side] & (one != other) & (one >= 0) & (other >= 0))
        near, far = one[rows, columns], other[rows, columns]
        parted = pieces[near] != pieces[far]
        rows, columns, near, far = rows[parted], columns[parted], near[parted], far[parted]
        gap = np.hypot(near // width - far // width, near % width - far % width)
        by = inputs.separation(near, far) * seen[rows, columns] / (1 + (gap / _FAR) ** 2)
        found[rows, columns] = np.maximum(found[rows, columns], by)
    # in known depth, jumps are found directly
    return np.where(inputs.missing, found, 0.0)


def _inside(inputs: CheckInput) -> Pairs:
    right, below = different_labels(inputs.labels)
    return ~right & (inputs.labels[:, 1:] > 0), ~below & (inputs.labels[1:] > 0)


def _beside(inputs: CheckInput, label: int, box: Box, inside: NDArray[np.bool_]) -> tuple[float, float]:
    """Depth [m] of the nearer and of the farther surface along a jump of a block in missing depth."""
    height, width = inputs.labels.shape
    top, left = np.nonzero(inside)
    corners = []
    for down, right in ((0, 0), (0, 1), (1, 0)):
        rows, columns = (
            np.minimum(top + box[0].start + down, height - 1),
            np.minimum(left + box[1].start + right, width - 1),
        )
        depth = inputs.depth.ravel()[inputs.source[rows, columns]]
        corners.append(np.where(inputs.labels[rows, columns] == label, depth, np.nan))
    return float(np.median(np.nanmin(corners, axis=0))), float(np.median(np.nanmax(corners, axis=0)))


# Borders between surfaces at different depths without an edge in the image.

_STRONG, _WEAK = 0.5, 0.25
"""Edge strength from which on a border is plausible, and below which it is not."""

_WRONG_BORDER_PROBABILITY = 0.3
"""Probability that a border without an edge is wrong: in missing depth, two surfaces may have similar colours."""

_DEFAULT_DISPLACEMENT = 4
"""Assumed displacement [px] of a border if there is no edge within `_REACH`."""


def find_weak_borders(inputs: CheckInput) -> Iterator[Place]:
    """Find parts of borders in missing depth, away from edges, between blocks whose depths differ there."""
    off, apart_by, one, other = _stretches(inputs)
    harm = _WRONG_BORDER_PROBABILITY * off * apart_by
    pair = np.where(harm > 0, one * (int(other.max()) + 1) + other, 0)
    numbers = connected_regions(pair, diagonal=True)
    totals = np.bincount(numbers.ravel(), harm.ravel(), minlength=int(numbers.max()) + 1)
    for box, inside, score in largest_groups(numbers, totals):
        label, beyond = int(one[box][inside][0]), int(other[box][inside][0])
        difference = float(np.median(apart_by[box][inside]))
        reason = (
            f"Block {label} and Block {beyond} are {difference:.2f} m apart, but there is no edge of colour or depth "
            "at their border."
        )
        yield Place("border", box, (label, beyond), point_in(box, inside), score, reason)


def _stretches(
    inputs: CheckInput,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """At the pixels of weak borders: possible displacement [px], distance [m] between their blocks, and the lower and
    the higher label of these; 0 elsewhere."""
    square = np.ones((2 * BESIDE + 1,) * 2, np.uint8)
    under = cv2.dilate(inputs.strength, square)
    weak = (under < _WEAK) & ~inputs.relief.near
    edges = (inputs.strength >= _STRONG).astype(np.uint8)
    away = cv2.distanceTransform(1 - edges, cv2.DIST_L2, 5) if edges.any() else np.full(edges.shape, np.inf)
    share = cv2.blur(inputs.missing.astype(np.float64), (_REACH + 1,) * 2)
    off = share * np.where(away <= _REACH, away, _DEFAULT_DISPLACEMENT)
    found, difference = np.zeros(weak.shape), np.zeros(weak.shape)
    lower, higher = np.zeros(weak.shape, np.int64), np.zeros(weak.shape, np.int64)
    for parted, labels, sources, weaknesses in zip(
        different_labels(inputs.labels), sides(inputs.labels), sides(inputs.source), sides(weak), strict=True
    ):
        both = parted & (labels[0] > 0) & (labels[1] > 0) & weaknesses[0] & weaknesses[1]
        rows, columns = np.nonzero(both)
        by = inputs.separation(sources[0][rows, columns], sources[1][rows, columns])
        better = by > difference[rows, columns]
        rows, columns = rows[better], columns[better]
        difference[rows, columns] = by[better]
        found[rows, columns] = off[rows, columns]
        lower[rows, columns] = np.minimum(*labels)[rows, columns]
        higher[rows, columns] = np.maximum(*labels)[rows, columns]
    return found, difference, lower, higher


# Parts apart from their block or inside another one, and parts too thin to be a surface.

_MIN_ISLAND_ERROR = 0.2
"""Minimum error [m] per pixel of an island: its shape is wrong whatever its depth."""

_OWN_SHARE, _FRAME_SHARE = 0.2, 0.01
"""Maximum size of an island: as a share of its block (or of the block around it), and of the frame."""

_ENCLOSED = 0.9
"""Minimum share of a block's border shared with the block that encloses it."""

_EDGE = 0.35
"""Mean edge strength along the border of an enclosed block above which it is a separate object."""

_THIN = 2.5
"""Maximum distance [px] of a sliver's pixels from its border."""

_MIN_PART = 6
"""Minimum number of pixels of a flagged part."""


def find_islands(inputs: CheckInput) -> Iterator[Place]:
    """Find islands, holes and slivers."""
    parts, labels, pixels, width = _find_parts(inputs)
    part, beyond, edges, apart = _find_part_borders(inputs, parts)
    count = labels.size
    length = np.maximum(np.bincount(part, minlength=count), 1)
    edge = np.bincount(part, edges, minlength=count) / length
    step = np.bincount(part, apart, minlength=count) / length
    main_beyond, beyond_share = _main_neighbour(part, beyond, count)
    missing = np.bincount(parts[inputs.missing], minlength=count)
    total = np.bincount(labels, pixels)
    largest = np.zeros(total.size, np.int64)
    np.maximum.at(largest, labels, pixels)
    small = np.minimum(_OWN_SHARE * total, _FRAME_SHARE * parts.size)
    away_from_rim = np.ones(count, bool)
    away_from_rim[rim(parts)] = False
    stray = (pixels < largest[labels]) & (pixels < small[labels])
    stray |= (labels == 0) & away_from_rim
    inside = ~stray & (beyond_share >= _ENCLOSED) & (edge < _EDGE) & (main_beyond > 0)
    inside &= away_from_rim & (pixels < small[main_beyond])
    thin = ~stray & ~inside & (width <= _THIN) & (labels > 0) & (edge < _EDGE)
    harm = _MIN_ISLAND_ERROR * pixels + step * missing
    flagged = (stray | inside | thin) & (pixels >= _MIN_PART)
    flagged[0] = False
    boxes = find_objects(parts)
    for number in np.flatnonzero(flagged).tolist():
        kind = "sliver" if width[number] <= _THIN else "island"
        label, other = int(labels[number]), int(main_beyond[number])
        down, along = boxes[number - 1]
        point = point_in((down, along), parts[down, along] == number)
        reason = _island_reason(kind, label, int(pixels[number]), other, bool(stray[number]))
        # for a hole, the block around it is selected
        shown = tuple(one for one in (label, other) if one)
        yield Place(kind, (down, along), shown, point, float(harm[number]), reason)


def _island_reason(kind: str, label: int, pixels: int, other: int, stray: bool) -> str:
    around = f"Block {other}" if other else "no block"
    if label == 0:
        return f"A hole of {pixels:,} px in {around} belongs to no block."
    if kind == "sliver":
        return f"A sliver of {pixels:,} px of Block {label} lies along {around}."
    if stray:
        return f"An island of {pixels:,} px of Block {label} lies in {around}, apart from the rest."
    return f"Block {label}, {pixels:,} px, lies inside {around} without an edge between them."


def _find_parts(
    inputs: CheckInput,
) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """4-connected parts of equal label, 1, 2, ...; and their labels, pixels, and largest distances to a border [px], by
    number."""
    numbers = connected_regions(inputs.labels, background=-1)
    count = int(numbers.max()) + 1
    label = np.zeros(count, np.int64)
    label[numbers] = inputs.labels
    depth = cv2.distanceTransform((~mark_both(different_labels(numbers))).astype(np.uint8), cv2.DIST_L2, 3)
    width = np.zeros(count)
    np.maximum.at(width, numbers.ravel(), depth.ravel())
    return numbers, label, np.bincount(numbers.ravel(), minlength=count), width + 1


def _find_part_borders(inputs: CheckInput, parts: NDArray[np.int32]) -> list[NDArray[Any]]:
    """Borders between parts, from both sides: the part, the label on the other side, the strength of the edge (1 where
    depth jumps), and the distance between the depths of both sides [m]."""
    columns = []
    jumps = np.maximum(cv2.dilate(inputs.strength, np.ones((3, 3), np.uint8)), mark(inputs.relief.jumps))
    for (part, other), (_, beyond), (one, another), edges in neighbours(parts, inputs.labels, inputs.source, jumps):
        parted = part != other
        by = inputs.separation(one[parted], another[parted])
        columns.append((part[parted], beyond[parted], np.maximum(*edges)[parted], by))
    return [np.concatenate(column) for column in zip(*columns, strict=True)]


def _main_neighbour(
    part: NDArray[np.int64], beyond: NDArray[np.int64], count: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The label along most of every part's border, and its share of the border."""
    main, share = np.zeros(count, np.int64), np.zeros(count)
    if part.size == 0:
        return main, share
    top = int(beyond.max()) + 1
    keys, lengths = np.unique(part.astype(np.int64) * top + beyond, return_counts=True)
    order = np.argsort(lengths, kind="stable")
    main[keys[order] // top] = keys[order] % top
    share[keys[order] // top] = lengths[order]
    return main, share / np.maximum(np.bincount(part, minlength=count), 1)


# Filled depth with a high expected error.

_HIGH, _HIGH_SHARE = 0.1, 0.05
"""Threshold of a high expected error: the larger of the two [m, share of the depth around]."""

_BLOCK_SHARE_OF_ERROR = 0.1
"""Share of a high expected error attributed to blocks: most of it is due to missing depth."""


def find_high_errors(inputs: CheckInput, error: NDArray[np.float32]) -> Iterator[Place]:
    """Find areas of high expected error [m], float32 (H, W), NaN where nothing was filled."""
    high = inputs.missing & (np.nan_to_num(error) > np.maximum(_HIGH, _HIGH_SHARE * inputs.depth))
    numbers = number_groups(high, inputs.labels)
    totals = np.bincount(numbers[high], error[high], minlength=int(numbers.max()) + 1)
    for box, inside, harm in largest_groups(numbers, _BLOCK_SHARE_OF_ERROR * totals):
        label, there = int(inputs.labels[box][inside][0]), error[box][inside]
        reason = f"Expected error {1000 * float(np.median(there)):.0f} mm over {there.size:,} px of Block {label}."
        yield Place("error", box, (label,), point_in(box, inside), harm, reason)


# All checks of a frame.

MIN_SCORE = 1.0
"""Minimum score of a place to check: ten pixels with an error of ten centimetres."""

_MERGE_DISTANCE = 20.0
"""Places of one block that are closer [px] than this are merged."""


def find_places(
    frame: RGBDFrame,
    labels: NDArray[np.integer],
    strength: NDArray[np.float32],
    error: NDArray[np.float32] | None = None,
    *,
    least: float = MIN_SCORE,
) -> list[Place]:
    """Find places where the blocks of a frame, or its filled depth, look wrong; highest scores first.

    The score is the effect on the depth to be filled: a border between two parts of one plane has none and is not
    flagged.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1], from `ilf.edge_strength`.
    error : ndarray of float32, shape (H, W), optional
        Expected error [m] of filled depth, NaN where nothing was filled; not checked if left out.
    least : float
        Minimum score of a place.

    Returns
    -------
    list of Place

    Raises
    ------
    InputError
        If shapes do not fit.

    Examples
    --------
    >>> depth = np.full((40, 60), 1.0)
    >>> depth[:, 30:] = 1.5
    >>> depth[10:30, 26:34] = np.nan
    >>> frame = RGBDFrame(np.zeros((40, 60, 3), np.uint8), depth)
    >>> for place in find_places(frame, np.ones((40, 60), np.int32), np.zeros((40, 60), np.float32)):
    ...     print(place.kind, place.reason)
    jump Depth jumps by 0.50 m inside Block 1.
    """
    blocks = checked_labels(labels, frame.shape)
    for array, name in ((strength, "edge strength"), (error, "expected error")):
        if array is not None:
            check_shape(f"The {name}", array.shape, frame.shape)
    inputs = make_check_input(frame, blocks, strength)
    found: list[Place] = []
    for find in (find_multiple_surfaces, find_weak_borders, find_islands):
        check_cancelled()
        found += find(inputs)
    if error is not None:
        found += find_high_errors(inputs, error)
    return _distinct(place for place in found if place.score >= least)


def _distinct(places: Iterable[Place]) -> list[Place]:
    """Places by decreasing score, without those merged into one with a higher score."""
    kept: list[Place] = []
    for place in sorted(places, key=lambda place: (-place.score, place.point)):
        if not any(
            math.dist(place.point, other.point) < _MERGE_DISTANCE and {*place.labels} & {*other.labels}
            for other in kept
        ):
            kept.append(place)
    return kept


# Blocks that were propagated from another frame and need a check.

_NO_REASON = "it came from another frame."


def propagated_places(labels: NDArray[np.int32], reasons: Mapping[int, str]) -> list[Place]:
    """The propagated blocks to check as places, the largest first; they come before all others.

    Parameters
    ----------
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    reasons : mapping of int to str
        Block label -> reason, a sentence; "" if unknown. Labels without a block are left out.

    Examples
    --------
    >>> place = propagated_places(np.array([[1, 1, 2]]), {2: "It is new.", 3: ""})[0]
    >>> place.kind, place.point, place.reason
    ('propagated', (2.5, 0.5), 'Block 2 was propagated: it is new.')
    """
    blocks = find_blocks(labels, list(reasons)).values()
    places = []
    for block in sorted(blocks, key=lambda block: -np.count_nonzero(block.mask)):
        reason = reasons[block.label]
        why = reason[:1].lower() + reason[1:] if reason else _NO_REASON
        text = f"Block {block.label} was propagated: {why}"
        point = point_in(block.box, block.mask)
        places.append(Place("propagated", block.box, (block.label,), point, math.inf, text))
    return places
