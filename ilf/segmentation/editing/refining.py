"""Refining borders: the pixels of a band are divided anew among the blocks beside it.

Each pixel goes to the block that a random walker from it most probably reaches first (Grady 2006, with priors): it
crosses edges rarely, and is drawn to the blocks whose colour and depth around the band are most like the pixel's.
"""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ...data.blocks import Region, grown, within
from ...data.frame import RGBDFrame
from ...data.pixel_grids import connected_regions, flood, neighbours
from ..edges.frame_edges import filled_depth
from .patches import LabelPatch, Labels, Mask, patch_within, unlocked_pixels
from .snapping import smooth_lab

Array = NDArray[np.float64]

_EDGE, _LEAST = 10.0, 1e-3
"""Rate at which the walker's conductance falls with the evidence for a border, and its least value."""

_PRIOR = 0.02
"""Conductance from each pixel to the blocks, shared out by the pixel's likeness to them."""

_PRESENT = 0.3
"""Share of the present block in it, which keeps the border where nothing speaks for another."""

_AROUND = 14.0
"""Distance [px] over which the colour and depth of a block are averaged."""

_TOLERANCES = (12.0, 4.0, 4.0, 0.17)
"""Deviations that make no difference: 8-bit Lab, and log depth."""

_SHARPNESS = 0.2
"""Exponent of the likelihoods: neighbouring pixels repeat each other."""


def refine_borders(
    frame: RGBDFrame, evidence: NDArray[np.float32], labels: Labels, band: Region, locked: Collection[int] = ()
) -> LabelPatch | None:
    """Divide the pixels of a band anew among the blocks in it, by edges, colour and depth.

    Parameters
    ----------
    frame : RGBDFrame
    evidence : ndarray of float32, shape (H, W)
        Evidence for a border at every pixel, about 1 where it is certain (`border_evidence`).
    labels : ndarray of int32, shape (H, W)
        The label map; 0, no block, is divided like the blocks.
    band : Region
        The band. Pixels outside it do not change.
    locked : collection of int
        Blocks that must not change.

    Returns
    -------
    LabelPatch or None
        None if nothing changes, or if fewer than two blocks that are not locked are in the band. A block that lies
        wholly in the band keeps at least its innermost pixel.
    """
    box = grown(band.box, round(2 * _AROUND), labels.shape)
    before = labels[box]
    free = np.zeros(before.shape, bool)
    free[within(band.box, box)] = band.mask
    free &= unlocked_pixels(before, locked)
    blocks = [int(block) for block in np.unique(before[free])]
    if len(blocks) < 2:
        return None
    for block in blocks:
        inside = free & (before == block)
        if np.count_nonzero(inside) == np.count_nonzero(labels == block):
            free[np.unravel_index(np.argmax(distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]), inside.shape)] = 0
    numbers = np.searchsorted(blocks, before)
    known = np.isin(before, blocks) & ~free
    numbers = np.where(known | free, numbers, -1)
    likeness = _likeness(frame, box, numbers, known, len(blocks))
    likeness = (1 - _PRESENT) * likeness + _PRESENT * (np.arange(len(blocks)) == numbers[..., None])
    after = before.copy()
    after[free] = np.array(blocks, np.int32)[_first_reached(evidence[box], numbers, free, likeness[free])]
    return patch_within(box, before, _connected(after, free, known, evidence[box]))


def _likeness(frame: RGBDFrame, box: tuple[slice, slice], numbers: NDArray[np.intp], known: Mask, count: int) -> Array:
    """How well colour and depth of every pixel fit each block around it, float64 (h, w, count) with the sum 1."""
    depth = frame.depth[box]
    has_depth = np.isfinite(depth)
    filled = np.log(filled_depth(depth)) if has_depth.any() else np.zeros(depth.shape, np.float32)
    seen = np.dstack([smooth_lab(frame.edge_rgb)[box], filled]) / np.array(_TOLERANCES, np.float32)
    score = np.empty((*numbers.shape, count))
    for number in range(count):
        sample = (known & (numbers == number)).astype(np.float32)
        weight = _around(sample) + np.float32(1e-6)
        mean, square = (_around(values * sample[..., None]) / weight[..., None] for values in (seen, seen * seen))
        variance = np.maximum(square - mean * mean, 0) + 1
        off = (seen - mean) ** 2 / variance + np.log(variance)
        off[..., 3] *= has_depth
        score[..., number] = -0.5 * _SHARPNESS * off.sum(axis=2)
    score = np.exp(score - score.max(axis=2, keepdims=True))
    return np.asarray(score / score.sum(axis=2, keepdims=True), np.float64)


def _around(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(values, (0, 0), _AROUND), np.float32)


def _first_reached(
    evidence: NDArray[np.float32], numbers: NDArray[np.intp], free: Mask, likeness: Array
) -> NDArray[np.intp]:
    """The number of the block that a random walker from each free pixel most probably reaches first."""
    size = len(likeness)
    places = np.full(free.shape, -1)
    places[free] = np.arange(size)
    total = np.full(size, _PRIOR)
    reached = _PRIOR * likeness
    links = []
    for (one, other), (is_free, _), (_, number), ends in neighbours(evidence, free, numbers, places):
        conductance = np.exp(-_EDGE * (one.astype(np.float64) + other) / 2) + _LEAST
        open_to = is_free & (number >= 0)
        start, end, weight = ends[0][open_to], ends[1][open_to], conductance[open_to]
        total += np.bincount(start, weight, size)
        fixed = end < 0
        np.add.at(reached, (start[fixed], number[open_to][fixed]), weight[fixed])
        links.append((start[~fixed], end[~fixed], -weight[~fixed]))
    start, end, weight = (np.concatenate(part) for part in zip(*links, strict=True))
    diagonal = np.arange(size)
    matrix = coo_array(
        (np.append(weight, total), (np.append(start, diagonal), np.append(end, diagonal))), shape=(size, size)
    )
    return np.asarray(splu(matrix.tocsc()).solve(reached).argmax(axis=1), np.intp)


def _connected(after: Labels, free: Mask, known: Mask, evidence: NDArray[np.float32]) -> Labels:
    """The labels without parts in the band that are disconnected from the pixels of their block outside it."""
    parts = connected_regions(after, background=-1)
    anchored = np.isin(parts, np.unique(parts[known]))
    if anchored[free].all():
        return after
    # 0, no block, grows like the blocks
    regions = flood(evidence, np.where(anchored & (known | free), after + 1, 0).astype(np.int32), known | free)
    return np.where(free & (regions > 0), regions - 1, after).astype(np.int32)
