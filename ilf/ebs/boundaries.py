"""From edges to watertight boundaries: dilation, and contraction with the edges as the guide (section 2)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ..compiling import compiled
from ..edges.pairs import Pairs, apart, mark
from .flooding import flood

_NECKS = (32, 16, 8, 4, 2)
"""Dilations [px] beyond the first at which regions are looked for, too: what only a neck connects comes apart."""

_SNAP = 5
"""How far [px] a boundary may be off a jump of the depth to be moved to it."""

_SPECK = 4
"""Pixels that a region has at least, before it grows."""


def dilate(edges: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """Edges dilated by a disk, so that gaps of up to two radii close.

    Parameters
    ----------
    edges : ndarray of bool, shape (H, W)
    radius : float
        Radius of the disk [px].
    """
    return distance_to(edges) <= radius


def regions_between(edges: NDArray[np.bool_], radius: float, inside: NDArray[np.bool_]) -> NDArray[np.int32]:
    """4-connected regions that dilated edges leave: of the widest dilation, and of narrower ones what those missed.

    The edges of a surface are rarely closed all around; a gap is a neck between two regions, which closes at some
    dilation. What looks parted only because of that is one again after the regions have been merged.

    Parameters
    ----------
    edges : ndarray of bool, shape (H, W)
    radius : float
        The narrowest dilation [px].
    inside : ndarray of bool, shape (H, W)
        Where regions may be.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions 1, 2, ...; 0 on the dilated edges and outside. All of the inside where edges leave nothing.
    """
    distance = np.where(inside, distance_to(edges), -1)
    regions = np.zeros(edges.shape, np.int32)
    largest = 0
    for further in (*_NECKS, 0):
        parts = _parts(distance > radius + further)
        largest = _take_in(parts.ravel(), regions.ravel(), largest)
    if not regions.any():
        # edges everywhere tell nothing apart
        regions = _parts(inside)
    return regions


def _take_in_one_by_one(parts: NDArray[np.int32], regions: NDArray[np.int32], largest: int) -> int:
    sizes = np.zeros(parts.max() + 1, np.int64)
    for pixel in range(parts.size):
        sizes[parts[pixel]] += 1 if regions[pixel] == 0 else -parts.size
    numbers = np.zeros(sizes.size, np.int32)
    for part in range(1, sizes.size):
        if sizes[part] >= _SPECK:
            largest += 1
            numbers[part] = largest
    for pixel in range(parts.size):
        if numbers[parts[pixel]] > 0:
            regions[pixel] = numbers[parts[pixel]]
    return largest


@compiled(_take_in_one_by_one)
def _take_in(parts: NDArray[np.int32], regions: NDArray[np.int32], largest: int) -> int:
    """Make regions of the parts in which there is none, in place; the largest number of a region before and after.

    Part 0 is none, nor is a speck.
    """
    new = np.bincount(parts) >= _SPECK
    new[0] = False
    new[parts[regions > 0]] = False
    numbers = np.where(new, np.cumsum(new, dtype=np.int32) + np.int32(largest), 0)
    np.copyto(regions, numbers[parts], where=new[parts])
    return int(numbers.max(initial=largest))


def distance_to(edges: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Distance to the nearest edge [px], float32 (H, W); beyond all bounds where there is none."""
    if not edges.any():
        return np.full(edges.shape, np.inf, np.float32)
    return np.asarray(cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, 5), np.float32)


def _parts(mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    return np.asarray(cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)[1], np.int32)


def contract(
    regions: NDArray[np.int32], strength: NDArray[np.float32], inside: NDArray[np.bool_] | None = None
) -> NDArray[np.int32]:
    """Let the regions grow into the dilated boundary until they meet where the edges are strongest.

    A watershed from the regions over the edge strength: every pixel ends in one region, so the result is
    watertight by construction.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0 to grow, 0 elsewhere.
    strength : ndarray of float32, shape (H, W)
        Edge strength; edges that shall guide the contraction are at the top.
    inside : ndarray of bool, shape (H, W), optional
        Where regions may grow; everywhere if left out.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions that touch each other, 0 outside; all 0 where there was no region to start from.
    """
    if not regions.any():
        return regions.copy()
    # what lies deep inside a region has no say in it, and would only wait in the queue
    open_ground = (regions == 0) if inside is None else (regions == 0) & inside
    shore = cv2.dilate(open_ground.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    grown = flood(strength, np.where(shore, regions, 0), shore if inside is None else shore & inside)
    return np.where(open_ground, grown, regions).astype(np.int32, copy=False)


def snap_to_jumps(regions: NDArray[np.int32], jumps: Pairs) -> NDArray[np.int32]:
    """Boundaries that run a few pixels beside a jump of the depth, moved to it.

    Edges of colour lie a little off those of depth. Around jumps inside a region, the regions let go of a narrow band
    and grow into it again, from all sides and not across a jump.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0, 0 for none.
    jumps : pair of ndarray of bool
        Neighbours between which depth jumps.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions, each of them 4-connected, in any order.
    """
    parted = apart(regions)
    inner = mark((jumps[0] & ~parted[0], jumps[1] & ~parted[1])) & (regions > 0)
    if not inner.any():
        return regions
    band = distance_to(inner) <= _SNAP
    # a rim of no region, so that every pixel has four neighbours
    old = np.pad(regions, 1)
    grown = np.where(np.pad(band, 1), 0, old).ravel()
    free = np.pad(~jumps[0], ((1, 1), (1, 2))).ravel(), np.pad(~jumps[1], ((1, 2), (1, 1))).ravel()
    width = old.shape[1]
    waiting = np.flatnonzero(np.pad(band & (regions > 0), 1))
    for _ in range(2 * _SNAP):
        found = np.zeros(waiting.size, grown.dtype)
        for way, step in zip((free[0], free[1]), (1, width), strict=True):
            for neighbour, passage in ((waiting - step, way[waiting - step]), (waiting + step, way[waiting])):
                found = np.where((found == 0) & passage, grown[neighbour], found)
        grown[waiting] = found
        waiting = waiting[found == 0]
    grown[waiting] = old.ravel()[waiting]
    snapped = grown.reshape(old.shape)[1:-1, 1:-1]
    return np.asarray(connected_regions(snapped, background=0, connectivity=1), np.int32)


def outlines(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Pixels whose right or lower neighbour has another label: the picture of a label map's boundaries."""
    return mark(apart(labels))
