"""Conversion between polygons, run lengths and pixels. A pixel (row, column) spans column to column + 1 and row to
row + 1; it is inside if its centre is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from ..data.blocks import Region, cropped, enclosed, find_blocks
from ..data.pixel_grids import connected_regions
from ..errors import InputError

Points = NDArray[np.float64]
"""(n, 2): x, y."""

_Corner = tuple[int, int]
"""x, y."""

_REMEDY = "Is this the file of this frame? If so, correct the shape or export it again."


def points_of(values: Any, where: str, shape: tuple[int, int]) -> Points:
    """Return the checked vertices of a polygon, float64 (n, 2), from pairs or from x, y, x, y, ...

    Parameters
    ----------
    values : anything
        Value from the file.
    where : str
        Beginning of messages.
    shape : (int, int)
        (H, W) of the image.

    Raises
    ------
    InputError
        If these are not numbers, some are not finite or far outside the image, or all lie outside of it or seem to be
        fractions of it, or if there are more of them than pixel edges.
    """
    height, width = shape
    most = max(100_000, 4 * (height + 1) * (width + 1))
    if not isinstance(values, list):
        raise InputError(f"{where} has no list of points. {_REMEDY}")
    try:
        points = np.asarray(values[: 2 * most + 2], np.float64)
        points = points.reshape(-1, 2) if points.ndim < 2 else points
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"{where} has points that are not pairs of numbers. {_REMEDY}")
    if len(points) > most:
        raise InputError(f"{where} has more points than the image has pixel edges. {_REMEDY}")
    if not np.isfinite(points).all():
        raise InputError(f"{where} has a point that is not finite. {_REMEDY}")
    outside = (points.max(axis=0, initial=-np.inf) < 0) | (points.min(axis=0, initial=np.inf) > (width, height))
    if len(points) and (outside.any() or np.abs(points).max() > 10 * (height + width)):
        raise InputError(f"{where} lies outside the image, which is {width} x {height}. {_REMEDY}")
    if len(points) and ((points >= 0) & (points <= 1)).all() and (2 * points % 1).any():
        raise InputError(f"{where} has points that are fractions of the image, from 0 to 1. Export them in pixels.")
    return points


def filled_polygon(points: Points, where: str, shape: tuple[int, int]) -> Region | None:
    """Return the pixels whose centre lies inside a polygon, by the even-odd rule; None if there are none.

    A line that the polygon follows in both directions has no effect, so that one polygon can have holes.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        x, y of the vertices, from `points_of`; the last is connected to the first.
    where : str
        Beginning of messages.
    shape : (int, int)
        (H, W) of the image, to which the polygon is clipped.

    Raises
    ------
    InputError
        If it crosses the image so often that it must be damaged.

    Examples
    --------
    >>> part = filled_polygon(np.array([[1.0, 0], [3, 0], [3, 2], [1, 2]]), "", (4, 4))
    >>> part.box, part.mask.tolist()
    ((slice(0, 2, None), slice(1, 3, None)), [[True, True], [True, True]])
    """
    height, width = shape
    rows = np.clip(points[:, 1], 0, height)
    if np.abs(np.diff(rows, append=rows[:1])).sum() > 2 * height * width + 1_000_000:
        raise InputError(f"{where} crosses the image too often to be an outline. {_REMEDY}")
    return enclosed(points, shape)


# Label map to polygons that follow the edges of its pixels, so that filling them gives the same map again.


def outline_polygons(labels: NDArray[np.int32]) -> dict[int, list[NDArray[np.int64]]]:
    """Trace the outlines of all blocks: one closed polygon for every 4-connected part.

    A part with holes is also one polygon: a cut along a row of pixels leads to each hole and back.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block.

    Returns
    -------
    dict
        Label -> polygons of its parts, each an array (n, 2) of x, y of pixel corners; the last is connected to the
        first.

    Examples
    --------
    >>> outline_polygons(np.array([[0, 5, 5], [0, 0, 5]], np.int32))[5][0].tolist()
    [[1, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1]]
    """
    found: dict[int, list[NDArray[np.int64]]] = {label: [] for label in np.unique(labels[labels > 0]).tolist()}
    for part in find_blocks(connected_regions(labels)).values():
        label = labels[part.box][0, part.mask[0].argmax()]
        found[int(label)].append(_outline(part.mask) + np.array([part.box[1].start, part.box[0].start]))
    return found


def _outline(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The polygon of a part in its bounding box, clockwise from the first of its top edges."""
    start = int(mask[0].argmax()), 0
    around = np.pad(~mask, 1, constant_values=True).astype(np.uint8).repeat(2, axis=0).repeat(2, axis=1)
    # the pixels around the part, each as 2 x 2, are followed: the nearest corner of a pixel is on its edge
    borders, (tree,) = cv2.findContours(around, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    outer: list[_Corner] = []
    holes: dict[_Corner, list[_Corner]] = {}
    for border, (*_, parent) in zip(borders, tree.tolist(), strict=True):
        corners = (border[:, 0].astype(np.int64) - 1) // 2
        corners = corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]
        if parent >= 0:
            outer = _from(corners, corners.tolist().index([*start]))
        elif corners.min() >= 0:  # the other one goes around all
            downwards = np.flatnonzero(np.roll(corners[:, 1], -1) > corners[:, 1])
            hole = _from(corners, int(downwards[np.lexsort(corners[downwards].T[::-1])[0]]))
            column, row = hole[0]
            beside = np.flatnonzero(~mask[row, : column - 1])
            holes[int(beside[-1]) + 1 if beside.size else 0, row] = hole
    return _without_straight(np.array([*_joined(outer, holes)]))


def _from(corners: NDArray[np.int64], first: int) -> list[_Corner]:
    return [(x, y) for x, y in np.roll(corners, -first, axis=0).tolist()]


def _joined(outer: list[_Corner], holes: dict[_Corner, list[_Corner]]) -> Iterator[_Corner]:
    """The corners of an outline with a detour round each hole, along a row of pixels from the border at its left: from
    the upper end of the edge there, by which the hole is known."""
    ways, last = [iter(outer)], (-1, -1)
    while ways:
        for corner in ways[-1]:
            is_upwards = last == (corner[0], corner[1] + 1)
            yield (last := corner)
            if is_upwards and (hole := holes.pop(corner, None)):
                ways.append(iter([*hole, hole[0], corner]))
                break
        else:
            ways.pop()


def _without_straight(points: NDArray[np.int64]) -> NDArray[np.int64]:
    """The points of a closed loop without those on straight lines."""
    into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    straight = (into[:, 0] * out[:, 1] == into[:, 1] * out[:, 0]) & ((into * out).sum(axis=1) > 0)
    return points[~straight]


# Run lengths as in COCO: column by column, downwards, alternating between outside and inside, starting outside.

_RLE_REMEDY = "Export it again."
_LONGEST = 7
"""Maximum number of characters of a run: 35 bits, more than any image has pixels."""


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """Return the run lengths of a mask (H, W).

    Examples
    --------
    >>> run_lengths(np.array([[False, True], [True, True]]))
    [1, 3]
    """
    flat = mask.ravel(order="F")
    bounds = [0, *(np.flatnonzero(flat[1:] != flat[:-1]) + 1).tolist(), flat.size]
    counts = np.diff(bounds).tolist()
    return [0, *counts] if flat[0] else counts


def compressed(counts: list[int]) -> str:
    """Encode run lengths as text: from the fourth on minus the second to last, 5 bits per character, the lowest first.

    Examples
    --------
    >>> compressed([6, 1, 40, 4, 5])
    '61X13mN'
    """
    text = []
    for place, count in enumerate(counts):
        left = count - counts[place - 2] if place > 2 else count
        more = True
        while more:
            bits, left = left & 31, left >> 5
            more = left != (-1 if bits & 16 else 0)
            text.append(chr(48 + bits + 32 * more))
    return "".join(text)


def part_of_runs(segmentation: dict[str, Any], where: str, shape: tuple[int, int]) -> Region | None:
    """Return the pixels of {"size": [H, W], "counts": run lengths or their text}; None if there are none.

    Raises
    ------
    InputError
        If the size is not `shape` (H, W), or the run lengths are damaged or do not add up to it.
    """
    size, counts = segmentation.get("size"), segmentation.get("counts")
    height, width = shape
    if size != [height, width]:
        told = f"{where} is for an image of [height, width] = {size!s:.40}, but the frame is {width} x {height}"
        raise InputError(f"{told}. Use the masks of this frame.")
    if isinstance(counts, str):
        runs = _from_text(counts, where, height * width)
    elif isinstance(counts, list) and all(type(one) is int for one in counts):
        # values out of bounds are clipped to the range of the type and stay out of bounds
        runs = np.array([min(max(one, -1), height * width + 1) for one in counts[: height * width + 2]], np.int64)
    else:
        raise InputError(f"{where} has run lengths that are neither integers nor encoded text. {_RLE_REMEDY}")
    if len(runs) > height * width + 1 or (runs < 0).any() or runs.sum() != height * width:
        pixels = f"the image's {counted(height * width, 'pixel')}"
        raise InputError(f"{where} has run lengths that do not add up to {pixels}. {_RLE_REMEDY}")
    return cropped(np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape(width, height).T)


def _from_text(text: str, where: str, pixels: int) -> NDArray[np.int64]:
    """Decode run lengths from text."""
    damaged = InputError(f"{where} has damaged run lengths. {_RLE_REMEDY}")
    if not text or not text.isascii() or len(text) > _LONGEST * (pixels + 1):
        raise damaged
    codes = np.frombuffer(text.encode("ascii"), np.uint8).astype(np.int64) - 48
    last = np.flatnonzero((codes & 32) == 0)
    if codes.min() < 0 or codes.max() > 63 or last.size == 0 or last[-1] != codes.size - 1:
        raise damaged
    first = np.concatenate(([0], last[:-1] + 1))
    lengths = last - first + 1
    if lengths.max() > _LONGEST:
        raise damaged
    place = np.arange(codes.size) - np.repeat(first, lengths)
    runs = np.add.reduceat((codes & 31) << (5 * place), first)
    runs -= ((codes[last] & 16) > 0).astype(np.int64) << (5 * lengths)
    if np.abs(runs).max() > pixels:
        raise damaged
    runs[1::2], runs[2::2] = np.cumsum(runs[1::2]), np.cumsum(runs[2::2])
    return runs
