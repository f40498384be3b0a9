"""Carried blocks settled on the edges of the new frame: what is sure stays, what is not is decided anew."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ...data.frame import RGBDFrame
from ...data.parameters import BlockParameters
from ...data.pixel_grids import mark
from ..edges.detectors import colour_gradient, gradient_strength
from ..edges.frame_edges import find_edges, relief_of
from ..extraction import contract, extract, found_blocks
from .motion import Field, Labels, Mask, Parts, Sources, reach_of, ridge

# Blocks of another extraction, named after those that they lie on.

_OVERLAP = 0.5
"""Share of a fresh block that must lie on a carried one to be it."""


def free_numbers(taken: Collection[int]) -> itertools.count[int]:
    """Numbers above all that are taken."""
    return itertools.count(max(taken, default=0) + 1)


def named_by_overlap(fresh: Labels, carried: Labels, taken: Collection[int]) -> tuple[Labels, frozenset[int]]:
    """Fresh blocks with the numbers of the carried blocks on which most of each lies, and which of them are new.

    Parameters
    ----------
    fresh : ndarray of int32, shape (H, W)
        Label map of the new frame's extraction.
    carried : ndarray of int32, shape (H, W)
        Labels that were carried there, 0 or less where none was. Each goes to one block: the one with most of it.
    taken : collection of int
        Numbers that no new block gets.
    """
    both = (fresh > 0) & (carried > 0)
    pairs, counts = np.unique(np.stack([fresh[both], carried[both]]), axis=1, return_counts=True)
    sizes = np.bincount(fresh.ravel())
    number_of = np.zeros(sizes.size, np.int32)
    given: set[int] = set()
    for place in np.argsort(-counts, kind="stable").tolist():
        block, label = pairs[:, place].tolist()
        if number_of[block] == 0 and label not in given and counts[place] >= _OVERLAP * sizes[block]:
            number_of[block] = label
            given.add(label)
    free = free_numbers(taken)
    new = [block for block in np.flatnonzero(sizes).tolist() if block > 0 and number_of[block] == 0]
    for block in new:
        number_of[block] = next(free)
    return number_of[fresh], frozenset(number_of[new].tolist())


# Carried borders settled on edges.

_LOOSE = 1.5
"""How far [px] a carried border may move to an edge beside it: often enough, and it stays with the edge."""

_LOOSE_UNSURE = 8.0
"""The same where the motion is not sure."""

_HOLD, _HOLD_DRAWN = 0.25, 1.0
"""Edge strength beside a carried border below which it stays as it is; of one that was drawn."""

_HOLD_WIDTH = 1.0
"""Blur [px] of that hold."""

_FINE, _JUMPS = 0.7, 0.4
"""Blur [px] of the colours before their gradient is taken, and what jumps of the depth count."""

_FOREIGN, _HIDDEN = 0.05, 0.5
"""Share of a surface that is surely carried up to which it counts as newly seen, and share of it that was not seen from
which on."""

_LEFT = 0.25
"""Share of a carried part that its largest piece has at least, to be left as it is though it is small."""


@dataclass(frozen=True, eq=False)
class Settled:
    """Blocks on the new frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
    carried : ndarray of int32, shape (H, W)
        Labels as the sources have them, -1 where there is none.
    uncertain : ndarray of bool, shape (H, W)
        Pixels that were decided by the new frame alone, or against what was carried.
    new : frozenset of int
        Blocks that were not there before.
    """

    labels: Labels
    carried: Labels
    uncertain: Mask
    new: frozenset[int]


def settle(
    parts: Parts,
    sources: Sources,
    after: RGBDFrame,
    chosen: BlockParameters,
    drawn: Mask | None = None,
    taken: Collection[int] = (),
) -> Settled:
    """Carry the parts of blocks along their sources and settle them.

    Parts of no block are carried like others. Since it is parts that are carried, what falls apart on the way is told
    from what was apart before.

    Parameters
    ----------
    parts : Parts
        Of the frame before.
    sources : Sources
    after : RGBDFrame
    chosen : BlockParameters
        What new blocks are extracted with.
    drawn : ndarray of bool, shape (H, W), optional
        Borders that were drawn before; they hold against stronger edges.
    taken : collection of int
        Numbers that no new block gets.
    """
    landscape = _landscape(after, chosen)
    smallest = chosen.smallest_block(parts.map.size)
    carried = np.where(sources.seen, parts.map.ravel()[sources.pixel], np.int32(0))
    reach = reach_of(carried)
    deep = (reach > _LOOSE) | ridge(reach)
    sure = sources.still | (sources.seen & (reach > _LOOSE_UNSURE))
    # where no edge is near, borders stay as they are carried
    edgeless = cv2.dilate(landscape, np.ones((5, 5), np.uint8)) < _HOLD
    sure |= sources.sure & (deep | edgeless)

    fine = extract(after, chosen.replace(min_size=0.0, min_known_share=0.0, existence_rate=0.0))
    foreign = _foreign(fine.blocks, parts, carried, sure, sources.seen, smallest)
    waiting = len(parts.label)
    markers = np.where(foreign > 0, foreign + waiting, np.where(sure, carried, 0)).astype(np.int32)
    label_of, is_new = _numbers(parts.label, foreign, smallest, taken)
    hold = _hold(carried, sources, drawn)
    grown = contract(markers, np.maximum(landscape, hold))
    grown = _without_crumbs(grown, landscape, parts.map, smallest, sources.still)
    settled = label_of[grown]
    settled[(fine.contracted == 0) & ~sources.still] = 0  # the margin
    was = np.where(carried > 0, label_of[carried], np.int32(-1))
    uncertain = (settled != was) | ~sources.seen
    return Settled(settled, was, uncertain, labels_in(settled) & is_new)


def extracted_anew(
    parts: Parts, sources: Sources, after: RGBDFrame, chosen: BlockParameters, taken: Collection[int] = ()
) -> Settled:
    """Blocks of the new frame's own extraction, named after the carried ones that they lie on."""
    carried = np.where(sources.seen, parts.label[parts.map.ravel()[sources.pixel]], np.int32(-1))
    labels, new = named_by_overlap(found_blocks(after, chosen).blocks, carried, {*parts.label.tolist(), *taken})
    return Settled(labels, carried, np.ones(labels.shape, bool), new)


def labels_in(labels: Labels) -> frozenset[int]:
    """The blocks of a label map."""
    return frozenset(np.unique(labels).tolist()) - {0}


def _foreign(fine: Labels, parts: Parts, carried: Labels, sure: Mask, seen: Mask, smallest: float) -> Labels:
    """Surfaces of the new frame, 1, 2, ..., on which hardly anything is carried for sure: where they were not seen.

    What comes in at the picture's rim is too small for a block at first. It belongs to none until it is large enough:
    so what belongs to none at the rim is taken for unseen, if it goes on there. What comes to light inside the picture
    and is too small goes to the blocks around it.
    """
    at_rim = np.zeros(len(parts.label), bool)
    at_rim[_rim(parts.map)] = True
    open_ground = ~seen | (at_rim & (parts.label == 0))[carried]
    count = int(fine.max()) + 1
    size = np.bincount(fine.ravel(), minlength=count)
    held = np.bincount(fine[sure & ~open_ground], minlength=count)
    hidden = np.bincount(fine[open_ground], minlength=count)
    comes_in = np.bincount(fine[~seen], minlength=count) > 0
    foreign = comes_in & (held <= _FOREIGN * size) & (hidden >= _HIDDEN * size)
    touching = np.zeros(count, bool)
    touching[_rim(fine)] = True
    foreign &= touching | (hidden >= smallest)
    foreign[0] = False
    return np.where(foreign[fine] & open_ground, fine, 0).astype(np.int32)


def _rim(values: Labels) -> Labels:
    """What stands along the picture's rim."""
    return np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])


def _numbers(
    label_of: NDArray[np.int32], foreign: Labels, smallest: float, taken: Collection[int]
) -> tuple[NDArray[np.int32], frozenset[int]]:
    """Part or surface -> label: what is newly seen and large enough has a new one, what is not has none for now."""
    sizes = np.bincount(foreign.ravel())
    sizes[0] = 0
    free = free_numbers({*label_of.tolist(), *taken})
    of_surface = np.zeros(sizes.size, np.int32)
    for surface in np.flatnonzero(sizes >= smallest):
        of_surface[surface] = next(free)
    numbers = np.concatenate([label_of, of_surface]).astype(np.int32)
    return numbers, frozenset(of_surface[of_surface > 0].tolist())


def _hold(carried: Labels, sources: Sources, drawn: Mask | None) -> Field:
    """Edge strength that carried borders have by themselves."""
    number = carried.astype(np.float32)
    square = np.ones((2, 2), np.uint8)
    border = (cv2.erode(number, square) != cv2.dilate(number, square)) & sources.seen
    height = np.where(border, np.float32(_HOLD), np.float32(0))
    if drawn is not None:
        height[border & drawn.ravel()[sources.pixel]] = _HOLD_DRAWN
    blurred = cv2.GaussianBlur(height, (0, 0), _HOLD_WIDTH)
    return np.maximum(height, blurred)


def _without_crumbs(grown: Labels, landscape: Field, parts: Labels, smallest: float, still: Mask) -> Labels:
    """Pieces that have come off their part on the way, and are too small, go to what is beside them."""
    pieces = np.asarray(connected_regions(grown, background=0, connectivity=1), np.int32)
    sizes = np.bincount(pieces.ravel())
    part_of = np.zeros(sizes.size, np.int32)
    part_of[pieces] = grown
    largest = np.zeros(int(part_of.max()) + 1, np.int64)
    np.maximum.at(largest, part_of, sizes)
    former = np.bincount(parts.ravel(), minlength=largest.size)[: largest.size]
    main = sizes == largest[part_of]
    keeps = (sizes >= smallest) | (main & (sizes >= _LEFT * np.minimum(former[part_of], smallest)))
    keeps[0] = False
    keeps[np.unique(pieces[still])] = True
    kept = np.where(keeps[pieces], grown, 0).astype(np.int32)
    return contract(kept, landscape) if kept.any() else grown


def _landscape(frame: RGBDFrame, chosen: BlockParameters) -> Field:
    """Along its crests, borders are drawn: edge strength, which knows what matters, and the gradient of colour, which
    knows to a pixel where it is. Jumps of the depth lie beside the true borders, and count where colour says little."""
    edges = find_edges(frame, chosen)
    gradient = gradient_strength(*colour_gradient(frame.rgb, _FINE))
    jumps = mark(relief_of(frame, chosen).jumps)
    return np.maximum((edges.detected + gradient) / 2, np.float32(_JUMPS) * jumps).astype(np.float32)
