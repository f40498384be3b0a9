"""Carried blocks settled on the edges of the new frame: what is sure stays, what is not is decided anew."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ...edges.detectors import colour_gradient, gradient_strength
from ...edges.frame_edges import find_edges
from ...frame import RGBDFrame
from ...parameters import BlockParameters
from ..boundaries import contract
from ..extraction import extract
from .parts import Labels, Parts, reach_of, ridge
from .sources import Field, Mask, Sources

_LOOSE = 1.5
"""How far [px] a carried border may move to an edge beside it: often enough, and it stays with the edge."""

_LOOSE_UNSURE = 8.0
"""The same where the motion is not sure."""

_HOLD, _HOLD_DRAWN = 0.25, 0.8
"""Edge strength beside a carried border below which it stays as it is; of one that was drawn."""

_HOLD_WIDTH = 1.0
"""Blur [px] of that hold."""

_FINE = 0.7
"""Blur [px] of the colours before their gradient is taken."""

_FOREIGN = 0.05
"""Share of a surface that is surely carried up to which it counts as newly seen."""

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
    whole = extract(after, chosen)
    landscape = _landscape(after, chosen)
    smallest = chosen.smallest_block(parts.map.size)
    carried = np.where(sources.seen, parts.map.ravel()[sources.pixel], np.int32(0))
    reach = reach_of(carried)
    deep = (reach > _LOOSE) | ridge(reach)
    sure = sources.still | (sources.sure & deep & (carried > 0)) | (reach > _LOOSE_UNSURE) & sources.seen

    fine = extract(after, chosen.replace(min_size=0.0, min_known_share=0.0, existence_rate=0.0)).blocks
    foreign = _foreign(fine, carried, sure, sources.seen)
    waiting = len(parts.label)
    markers = np.where(foreign > 0, foreign + waiting, np.where(sure, carried, 0)).astype(np.int32)
    label_of, is_new = _numbers(parts.label, foreign, smallest, taken)
    hold = _hold(carried, sources, drawn)
    grown = contract(markers, np.maximum(landscape, hold))
    grown = _without_crumbs(grown, landscape, parts.map, smallest, sources.still)
    settled = label_of[grown]
    settled[(whole.contracted == 0) & ~sources.still] = 0
    was = np.where(carried > 0, label_of[carried], np.int32(-1))
    uncertain = (settled != was) | ~sources.seen
    new = frozenset(np.unique(settled).tolist()) & is_new
    return Settled(settled, was, uncertain, new)


def _foreign(fine: Labels, carried: Labels, sure: Mask, seen: Mask) -> Labels:
    """Surfaces of the new frame, 1, 2, ..., on which hardly anything is carried for sure: where they were not seen."""
    count = int(fine.max()) + 1
    size = np.bincount(fine.ravel(), minlength=count)
    held = np.bincount(fine[sure & (carried > 0)], minlength=count)
    hidden = np.bincount(fine[~seen], minlength=count)
    foreign = (held <= _FOREIGN * size) & (hidden >= 0.5 * size)
    foreign[0] = False
    return np.where(foreign[fine] & ~seen, fine, 0).astype(np.int32)


def _numbers(
    label_of: NDArray[np.int32], foreign: Labels, smallest: float, taken: Collection[int]
) -> tuple[NDArray[np.int32], frozenset[int]]:
    """Part or surface -> label: what is newly seen and large enough has a new one, what is not has none for now."""
    sizes = np.bincount(foreign.ravel())
    sizes[0] = 0
    used = {*label_of.tolist(), *taken}
    free = itertools.filterfalse(used.__contains__, itertools.count(max(used, default=0) + 1))
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
    knows to a pixel where it is. Depth has had its say in the sources, and its jumps lie beside the true borders."""
    strength = find_edges(frame, chosen).colour
    gradient = gradient_strength(*colour_gradient(frame.rgb, _FINE))
    return np.asarray((strength + gradient) / 2, np.float32)
