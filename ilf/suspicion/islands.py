"""Parts that lie apart from their block or inside another one, and parts too thin to be a surface."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects
from skimage.measure import label as connected_regions

from ..edges.pairs import apart, mark, sides
from .ground import Ground
from .groups import Group
from .place import Place

_KNOWN = 0.2
"""Error [m] that a pixel of an island is charged with at least: its shape is wrong whatever its depth is."""

_OWN_SHARE, _FRAME_SHARE = 0.2, 0.01
"""A part of a block that is larger than this share of it, or of the frame, is no island but a half of it; nor is a
block that is larger than this share of the one around it, or of the frame."""

_ENCLOSED = 0.9
"""A block lies inside another one if that is beyond so much of its border."""

_EDGE = 0.35
"""Mean edge strength along the border of an enclosed block above which it is a thing of its own."""

_THIN = 2.5
"""Nowhere farther [px] from a border than that, and it is a sliver."""

_SMALLEST = 6
"""Parts of fewer pixels are not worth going to, one by one."""


class _Parts(NamedTuple):
    """4-connected parts of equal label, by number from 1 on."""

    numbers: NDArray[np.int32]
    label: NDArray[np.int64]
    pixels: NDArray[np.int64]
    width: NDArray[np.float64]
    """Largest distance to a border [px]."""


class _Shores(NamedTuple):
    """Borders between parts, each from both sides."""

    part: NDArray[np.int64]
    beyond: NDArray[np.int64]
    """Label beyond."""
    edge: NDArray[np.float64]
    """Edge strength, 1 where depth jumps."""
    apart: NDArray[np.float64]
    """How far apart the two sides' depths are [m]."""


def find_islands(ground: Ground, strength: NDArray[np.float32]) -> Iterator[Place]:
    """Islands, holes and slivers."""
    parts = _find_parts(ground)
    shores = _find_shores(ground, parts, strength)
    count = parts.label.size
    length = np.maximum(np.bincount(shores.part, minlength=count), 1)
    edge = np.bincount(shores.part, shores.edge, minlength=count) / length
    step = np.bincount(shores.part, shores.apart, minlength=count) / length
    main_beyond, beyond_share = _main_neighbour(shores, count)
    missing = np.bincount(parts.numbers[ground.missing], minlength=count)
    total = np.bincount(parts.label, parts.pixels)
    largest = np.zeros(total.size, np.int64)
    np.maximum.at(largest, parts.label, parts.pixels)
    small = np.minimum(_OWN_SHARE * total, _FRAME_SHARE * parts.numbers.size)
    stray = (parts.pixels < largest[parts.label]) & (parts.pixels < small[parts.label])
    stray |= (parts.label == 0) & ~_at_rim(parts)
    inside = ~stray & (beyond_share >= _ENCLOSED) & (edge < _EDGE) & (main_beyond > 0)
    inside &= ~_at_rim(parts) & (parts.pixels < small[main_beyond])
    thin = ~stray & ~inside & (parts.width <= _THIN) & (parts.label > 0) & (edge < _EDGE)
    harm = _KNOWN * parts.pixels + step * missing
    boxes = find_objects(parts.numbers)
    for number in np.flatnonzero((stray | inside | thin) & (parts.pixels >= _SMALLEST)).tolist():
        if number == 0:
            continue
        kind = "sliver" if parts.width[number] <= _THIN else "island"
        label, pixels, other = int(parts.label[number]), int(parts.pixels[number]), int(main_beyond[number])
        down, along = boxes[number - 1]
        box = down, along
        rows, columns = np.nonzero(parts.numbers[box] == number)
        group = Group(label, box, rows + down.start, columns + along.start, float(harm[number]))
        reason = _reason(kind, label, pixels, other, bool(stray[number]))
        # of what belongs to no block, the block around it is the one to choose
        labels = (label, other) if label else (other,)
        yield Place(kind, box, tuple(one for one in labels if one), group.point, group.harm, reason)


def _reason(kind: str, label: int, pixels: int, other: int, stray: bool) -> str:
    around = f"Block {other}" if other else "no block"
    if label == 0:
        return f"A hole of {pixels:,} px in {around} belongs to no block."
    if kind == "sliver":
        return f"A sliver of {pixels:,} px of Block {label} lies along {around}."
    if stray:
        return f"An island of {pixels:,} px of Block {label} lies in {around}, apart from the rest."
    return f"Block {label}, {pixels:,} px, lies inside {around}, and nothing parts them."


def _find_parts(ground: Ground) -> _Parts:
    numbers = np.asarray(connected_regions(ground.labels, background=-1, connectivity=1), np.int32)
    count = int(numbers.max()) + 1
    label = np.zeros(count, np.int64)
    label[numbers] = ground.labels
    borders = mark(apart(numbers))
    borders[:, 1:] |= apart(numbers)[0]
    borders[1:] |= apart(numbers)[1]
    depth = cv2.distanceTransform((~borders).astype(np.uint8), cv2.DIST_L2, 3)
    width = np.zeros(count)
    np.maximum.at(width, numbers.ravel(), depth.ravel())
    return _Parts(numbers, label, np.bincount(numbers.ravel(), minlength=count), width + 1)


def _find_shores(ground: Ground, parts: _Parts, strength: NDArray[np.float32]) -> _Shores:
    columns = []
    jumps = np.maximum(cv2.dilate(strength, np.ones((3, 3), np.uint8)), mark(ground.relief.jumps))
    for numbers, labels, sources, edges in zip(
        sides(parts.numbers), sides(ground.labels), sides(ground.source), sides(jumps), strict=True
    ):
        parted = numbers[0] != numbers[1]
        by = ground.apart(sources[0][parted], sources[1][parted])
        edge = np.maximum(edges[0][parted], edges[1][parted])
        for this, that in ((0, 1), (1, 0)):
            columns.append((numbers[this][parted], labels[that][parted], edge, by))
    part, beyond, edge, by = (np.concatenate(column) for column in zip(*columns, strict=True))
    return _Shores(part, beyond, edge, by)


def _main_neighbour(shores: _Shores, count: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The label along most of every part's border, and along which share of it."""
    main, share = np.zeros(count, np.int64), np.zeros(count)
    if shores.part.size == 0:
        return main, share
    top = int(shores.beyond.max()) + 1
    keys, lengths = np.unique(shores.part.astype(np.int64) * top + shores.beyond, return_counts=True)
    order = np.argsort(lengths, kind="stable")
    main[keys[order] // top] = keys[order] % top
    share[keys[order] // top] = lengths[order]
    return main, share / np.maximum(np.bincount(shores.part, minlength=count), 1)


def _at_rim(parts: _Parts) -> NDArray[np.bool_]:
    numbers = parts.numbers
    rim = np.zeros(parts.label.size, bool)
    rim[np.concatenate([numbers[0], numbers[-1], numbers[:, 0], numbers[:, -1]])] = True
    return rim
