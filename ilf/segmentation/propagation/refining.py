"""Refining propagated blocks on the edges of the new frame: reliable pixels stay, the others are decided again."""

from __future__ import annotations

import itertools
from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from ...data.parameters import BlockParameters
from ...data.pixel_grids import connected_regions, mark, rim
from ..edges.detectors import colour_gradient, gradient_strength
from ..edges.frame_edges import find_edges, relief_of
from ..extraction import contract, extract, found_blocks
from .motion import BlockParts, Field, Labels, Mask, Sources, reach_of, ridge

# Naming blocks of another extraction by overlap.

_OVERLAP = 0.5
"""Minimum fraction of a new block on a propagated one to get its number."""


def free_numbers(taken: Collection[int]) -> itertools.count[int]:
    """Numbers above all taken ones."""
    return itertools.count(max(taken, default=0) + 1)


def named_by_overlap(fresh: Labels, propagated: Labels, taken: Collection[int]) -> Labels:
    """Newly extracted blocks with the numbers of the propagated blocks that they mostly overlap; the others are new.

    Parameters
    ----------
    fresh : ndarray of int32, shape (H, W)
        Label map of the new frame's extraction.
    propagated : ndarray of int32, shape (H, W)
        Propagated labels, 0 or less where there are none. Each goes to one block: the one with the largest overlap.
    taken : collection of int
        Numbers that no new block gets.
    """
    both = (fresh > 0) & (propagated > 0)
    pairs, counts = np.unique(np.stack([fresh[both], propagated[both]]), axis=1, return_counts=True)
    sizes = np.bincount(fresh.ravel())
    number_of = np.zeros(sizes.size, np.int32)
    given: set[int] = set()
    for place in np.argsort(-counts, kind="stable").tolist():
        block, label = pairs[:, place].tolist()
        if number_of[block] == 0 and label not in given and counts[place] >= _OVERLAP * sizes[block]:
            number_of[block] = label
            given.add(label)
    free = free_numbers(taken)
    for block in np.flatnonzero(sizes).tolist():
        if block > 0 and number_of[block] == 0:
            number_of[block] = next(free)
    return number_of[fresh]


# Refining propagated borders on edges.

_MAX_MOVE = 1.5
"""Maximum move [px] of a propagated border to an edge beside it; over several frames, it stays with the edge."""

_MAX_MOVE_UNRELIABLE = 8.0
"""The same where the motion is not reliable."""

_HOLD, _HOLD_OF_DRAWN = 0.25, 1.0
"""Minimum edge strength that moves a propagated border, and a drawn one."""

_HOLD_WIDTH = 1.0
"""Blur [px] of the hold of borders."""

_FINE, _JUMPS = 0.7, 0.4
"""Blur [px] of the colours before their gradient is taken, and weight of depth jumps."""

_FOREIGN, _HIDDEN = 0.05, 0.5
"""Maximum reliably propagated fraction, and minimum previously invisible fraction, of a newly visible surface."""

_MIN_PIECE_SHARE = 0.25
"""Minimum fraction of a propagated part in its largest piece, for that to stay although it is small."""


def refine(
    parts: BlockParts,
    sources: Sources,
    after: RGBDFrame,
    chosen: BlockParameters,
    drawn: Mask | None = None,
    taken: Collection[int] = (),
) -> tuple[Labels, Labels]:
    """Propagate the parts of blocks along their sources and refine them.

    Parts without block are propagated like others. Parts are propagated, rather than blocks, so that parts that break
    up on the way can be distinguished from those that were separate before.

    Parameters
    ----------
    parts : BlockParts
        Parts of the frame before.
    sources : Sources
    after : RGBDFrame
    chosen : BlockParameters
        Parameters for extracting new blocks.
    drawn : ndarray of bool, shape (H, W), optional
        Borders that were drawn before; only stronger edges move them.
    taken : collection of int
        Numbers that no new block gets.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Blocks on the new frame.
    ndarray of int32, shape (H, W)
        Labels propagated from the sources, -1 where there are none.
    """
    landscape = _landscape(after, chosen)
    smallest = chosen.smallest_block(parts.map.size)
    propagated = np.where(sources.seen, parts.map.ravel()[sources.pixel], np.int32(0))
    reach = reach_of(propagated)
    deep = (reach > _MAX_MOVE) | ridge(reach)
    sure = sources.still | (sources.seen & (reach > _MAX_MOVE_UNRELIABLE))
    # where no edge is near, borders stay as propagated
    edgeless = cv2.dilate(landscape, np.ones((5, 5), np.uint8)) < _HOLD
    sure |= sources.sure & (deep | edgeless)

    fine = extract(after, chosen.replace(min_size=0.0, min_known_share=0.0, existence_rate=0.0))
    foreign = _newly_visible(fine.blocks, parts, propagated, sure, sources.seen, smallest)
    waiting = len(parts.label)
    markers = np.where(foreign > 0, foreign + waiting, np.where(sure, propagated, 0)).astype(np.int32)
    label_of = _numbers(parts.label, foreign, smallest, taken)
    hold = _hold(propagated, sources, drawn)
    grown = contract(markers, np.maximum(landscape, hold))
    grown = _merge_fragments(grown, landscape, parts.map, smallest, sources.still)
    refined = label_of[grown]
    refined[(fine.contracted == 0) & ~sources.still] = 0  # the margin
    return refined, np.where(propagated > 0, label_of[propagated], np.int32(-1))


def extract_again(
    parts: BlockParts, sources: Sources, after: RGBDFrame, chosen: BlockParameters, taken: Collection[int] = ()
) -> Labels:
    """Extract blocks of the new frame, and name them by overlap with the propagated ones."""
    propagated = np.where(sources.seen, parts.label[parts.map.ravel()[sources.pixel]], np.int32(-1))
    return named_by_overlap(found_blocks(after, chosen).labels, propagated, {*parts.label.tolist(), *taken})


def _newly_visible(
    fine: Labels, parts: BlockParts, propagated: Labels, sure: Mask, seen: Mask, smallest: float
) -> Labels:
    """Newly visible surfaces of the new frame, 1, 2, ...: hardly any of their pixels are reliably propagated.

    Surfaces that enter at the image rim are at first too small for a block, and belong to none until they are large
    enough. So pixels without block at the rim count as not visible before, if the surface continues there. Small
    surfaces that appear inside the image go to the blocks around them.
    """
    at_rim = np.zeros(len(parts.label), bool)
    at_rim[rim(parts.map)] = True
    open_ground = ~seen | (at_rim & (parts.label == 0))[propagated]
    count = int(fine.max()) + 1
    size = np.bincount(fine.ravel(), minlength=count)
    held = np.bincount(fine[sure & ~open_ground], minlength=count)
    hidden = np.bincount(fine[open_ground], minlength=count)
    comes_in = np.bincount(fine[~seen], minlength=count) > 0
    foreign = comes_in & (held <= _FOREIGN * size) & (hidden >= _HIDDEN * size)
    touching = np.zeros(count, bool)
    touching[rim(fine)] = True
    foreign &= touching | (hidden >= smallest)
    foreign[0] = False
    return np.where(foreign[fine] & open_ground, fine, 0).astype(np.int32)


def _numbers(
    label_of: NDArray[np.int32], foreign: Labels, smallest: float, taken: Collection[int]
) -> NDArray[np.int32]:
    """Part or surface -> label: newly visible surfaces get a new label if large enough, else none for now."""
    sizes = np.bincount(foreign.ravel())
    sizes[0] = 0
    free = free_numbers({*label_of.tolist(), *taken})
    of_surface = np.zeros(sizes.size, np.int32)
    for surface in np.flatnonzero(sizes >= smallest):
        of_surface[surface] = next(free)
    return np.concatenate([label_of, of_surface]).astype(np.int32)


def _hold(propagated: Labels, sources: Sources, drawn: Mask | None) -> Field:
    """Edge strength assigned to propagated borders to keep them in place."""
    number = propagated.astype(np.float32)
    square = np.ones((2, 2), np.uint8)
    border = (cv2.erode(number, square) != cv2.dilate(number, square)) & sources.seen
    height = np.where(border, np.float32(_HOLD), np.float32(0))
    if drawn is not None:
        height[border & drawn.ravel()[sources.pixel]] = _HOLD_OF_DRAWN
    blurred = cv2.GaussianBlur(height, (0, 0), _HOLD_WIDTH)
    return np.maximum(height, blurred)


def _merge_fragments(grown: Labels, landscape: Field, parts: Labels, smallest: float, still: Mask) -> Labels:
    """Give small pieces that broke off their part to their neighbours."""
    pieces = connected_regions(grown)
    sizes = np.bincount(pieces.ravel())
    part_of = np.zeros(sizes.size, np.int32)
    part_of[pieces] = grown
    largest = np.zeros(int(part_of.max()) + 1, np.int64)
    np.maximum.at(largest, part_of, sizes)
    former = np.bincount(parts.ravel(), minlength=largest.size)[: largest.size]
    main = sizes == largest[part_of]
    keeps = (sizes >= smallest) | (main & (sizes >= _MIN_PIECE_SHARE * np.minimum(former[part_of], smallest)))
    keeps[0] = False
    keeps[np.unique(pieces[still])] = True
    kept = np.where(keeps[pieces], grown, 0).astype(np.int32)
    return contract(kept, landscape) if kept.any() else grown


def _landscape(frame: RGBDFrame, chosen: BlockParameters) -> Field:
    """Landscape whose crests the borders follow: edge strength, which finds the relevant edges, and colour gradient,
    which locates them to the pixel. Depth jumps lie slightly off the true borders, and count where colour is weak."""
    edges = find_edges(frame, chosen)
    gradient = gradient_strength(*colour_gradient(frame.edge_rgb, _FINE))
    jumps = mark(relief_of(frame, chosen).jumps)
    return np.maximum((edges.detected + gradient) / 2, np.float32(_JUMPS) * jumps).astype(np.float32)
