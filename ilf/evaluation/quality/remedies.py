"""Remedies for flagged places: the change of blocks, of invalid depth or of depth by hand that mends a place."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.formatting import grouped
from ..._runtime.long_work import check_cancelled
from ...completion.continuation import continue_plane
from ...data.blocks import checked_labels, grown
from ...data.frame import RGBDFrame
from ...data.pixel_grids import connected_regions, flood, neighbours
from ...errors import InputError
from ...segmentation.editing.cleaning import merge
from ...segmentation.editing.cutting import piece_at
from ...segmentation.editing.painting import give
from ...segmentation.editing.patches import LabelPatch
from .checks import BESIDE, find_places, find_steps, flat_indices
from .invalid_depth import suggest_invalid
from .places import JUMP, JUMP_SHARE, CheckInput, Place, make_check_input

Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]

REMEDIES = ("split", "give", "merge", "invalid", "plane", "checked")
"""Cut a part off a block as a new one; give a part to a neighbour; merge two blocks; mark measured depth as invalid;
continue the plane of a block's known depth into its hole; mark a propagated block as checked."""

_NEAR = 24
"""Distance [px] from a high expected error up to which wrong measured depth may be its cause."""

_MIN_REDUCTION = 0.5
"""Minimum reduction of the score of all places by a remedy, as a share of the place's score."""


@dataclass(frozen=True, eq=False)
class Remedy:
    """A change that mends a flagged place.

    Attributes
    ----------
    kind : str
        One of `REMEDIES`.
    text : str
        What it does, as "Split Block 5"; blocks are named by their numbers.
    patch : LabelPatch or None
        The change of the label map, if there is one.
    invalid : ndarray of bool, shape (H, W), or None
        The pixels with measured depth to mark as invalid, if there are any.
    by_hand : ndarray of float32, shape (H, W), or None
        Depth by hand [m] to add, NaN for none, if there is any.
    """

    kind: str
    text: str
    patch: LabelPatch | None = None
    invalid: Mask | None = None
    by_hand: NDArray[np.float32] | None = None


def find_remedy(
    place: Place,
    frame: RGBDFrame,
    labels: NDArray[np.integer],
    strength: NDArray[np.float32],
    *,
    locked: Collection[int] = (),
    first_new: int | None = None,
) -> Remedy | None:
    """Find the remedy for a place.

    A block with a step inside is divided along the step. The part goes to the neighbour that it continues if there is
    no edge between them, and is a new block otherwise. If most of its measured depth is likely invalid, that is marked
    instead. A change is only a remedy if the quality checks confirm it: afterwards, the score of all places together
    must be lower by at least half of the place's score.

    For a high expected error, measured depth near by that is likely invalid is marked; without any, the plane of the
    block's known depth is continued into the hole. The checks cannot confirm these: look at what they change.

    Parameters
    ----------
    place : Place
        As found by `find_places` in these blocks.
    frame, labels, strength
        As for `find_places`.
    locked : collection of int
        Blocks that must not change.
    first_new : int, optional
        Number of a new block; one more than the largest label if left out.

    Returns
    -------
    Remedy or None
        None if there is none.

    Raises
    ------
    InputError
        If shapes do not fit.

    Examples
    --------
    >>> depth = np.full((40, 60), 1.0)
    >>> depth[:, 30:] = 1.5
    >>> depth[10:30, 26:34] = np.nan
    >>> frame, strength = RGBDFrame(np.zeros((40, 60, 3), np.uint8), depth), np.zeros((40, 60), np.float32)
    >>> blocks = np.ones((40, 60), np.int32)
    >>> remedy = find_remedy(find_places(frame, blocks, strength)[0], frame, blocks, strength)
    >>> remedy.kind, remedy.text, remedy.patch.box[1]
    ('split', 'Split Block 1', slice(0, 30, None))
    """
    blocks = checked_labels(labels, frame.shape)
    if place.kind == "propagated":
        return Remedy("checked", f"Mark Block {place.labels[0]} as checked")
    new = int(blocks.max()) + 1 if first_new is None else first_new
    before: float | None = None
    for remedy in _candidates(place, frame, blocks, strength, new):
        if remedy.patch is not None and remedy.patch.touched.intersection(locked):
            continue
        if place.kind == "error":
            return remedy
        before = _score(frame, blocks, strength) if before is None else before
        if before - _score_after(remedy, frame, blocks, strength) >= _MIN_REDUCTION * place.score:
            return remedy
    return None


def _score_after(remedy: Remedy, frame: RGBDFrame, labels: Labels, strength: NDArray[np.float32]) -> float:
    after = labels.copy()
    if remedy.patch is not None:
        remedy.patch.apply(after)
    return _score(frame if remedy.invalid is None else frame.with_more_invalid(remedy.invalid), after, strength)


def _score(frame: RGBDFrame, labels: Labels, strength: NDArray[np.float32]) -> float:
    """Score of all places, even of the least."""
    check_cancelled()
    return sum(place.score for place in find_places(frame, labels, strength, least=0.0))


def _candidates(
    place: Place, frame: RGBDFrame, labels: Labels, strength: NDArray[np.float32], new: int
) -> Iterator[Remedy]:
    """The remedies to try for a place, the best first."""
    match place.kind:
        case "jump" | "surfaces":
            yield from _of_step(place, frame, labels, strength, new)
        case "island" | "sliver":
            yield from _of_island(place, labels)
        case "error":
            yield from _of_error(place, frame, labels, strength)


def _of_step(
    place: Place, frame: RGBDFrame, labels: Labels, strength: NDArray[np.float32], new: int
) -> Iterator[Remedy]:
    label = place.labels[0]
    inputs = make_check_input(frame, labels, strength)
    parts = _divided(inputs, place)
    smaller, larger = sorted((parts == 1, parts == 2), key=np.count_nonzero)
    if not smaller.any():
        return
    wrong = smaller & frame.known
    if np.count_nonzero(wrong & suggest_invalid(frame, strength)) * 2 > np.count_nonzero(wrong):
        yield _marking(wrong)
    for part in (smaller, larger):
        taker = _continued(inputs, part, label)
        if taker:
            patch = give(labels, part, taker)
            yield Remedy("give", f"Give a part of Block {label} to Block {taker}", patch)
    yield Remedy("split", f"Split Block {label}", give(labels, smaller, new))


def _of_island(place: Place, labels: Labels) -> Iterator[Remedy]:
    piece = piece_at(labels, *place.point)
    label, taker = int(labels[piece][0]), place.labels[-1]
    if taker == label:  # no block is beside it
        return
    if label and np.count_nonzero(piece) == np.count_nonzero(labels == label):
        yield Remedy("merge", f"Merge Block {label} into Block {taker}", merge(labels, [taker, label]))
        return
    what = f"a part of Block {label}" if label else "a hole"
    yield Remedy("give", f"Give {what} to Block {taker}", give(labels, piece, taker))


def _of_error(place: Place, frame: RGBDFrame, labels: Labels, strength: NDArray[np.float32]) -> Iterator[Remedy]:
    label, missing = place.labels[0], ~frame.known
    suggested, wrong = suggest_invalid(frame, strength), np.zeros(missing.shape, bool)
    near = grown(place.box, _NEAR, missing.shape)
    wrong[near] = suggested[near]
    if wrong.any():
        yield _marking(wrong)
    inside = labels == label
    x, y = place.point
    holes = connected_regions((inside & missing).astype(np.int32), diagonal=True)
    hole = holes == holes[int(y), int(x)]
    try:
        depth, share = continue_plane(frame.depth, inside & ~suggested, hole & inside & missing)
    except InputError:  # too little known depth, or it is no plane there
        return
    if share >= _SAME_SHARE:
        yield Remedy("plane", f"Continue the plane of Block {label}", by_hand=depth)


def _marking(wrong: Mask) -> Remedy:
    return Remedy("invalid", f"Mark {grouped(int(np.count_nonzero(wrong)))} px as invalid", invalid=wrong)


# The parts of a block on both sides of a step.

_SLOPE = 0.04
"""Change of the depth per pixel, as a share of it, that counts as much as the strongest edge."""

_MARKED = 3
"""Distance [px] from the step up to which pixels are sure to be on one side of it."""


def _divided(inputs: CheckInput, place: Place) -> NDArray[np.int32]:
    """The pixels of the place's block on the nearer side of its step, 1, and on the farther one, 2; 0 elsewhere.

    Beside a jump in known depth, pixels are sure to be on their side of it. Across missing depth, only the known pixels
    at both ends of the gap are.
    """
    labels, label = inputs.labels, place.labels[0]
    jumps, hidden = (np.zeros(labels.shape, bool) for _ in range(2))
    for here, steps in zip((jumps, hidden), find_steps(inputs), strict=True):
        here[place.box] = (steps[place.box] > 0) & (labels[place.box] == label)
    depth, markers = inputs.depth.ravel(), np.zeros(labels.size, np.int32)

    def mark_sides(ends: list[NDArray[np.intp]], seen: list[NDArray[np.intp]]) -> None:
        """Mark pairs of pixels by the depth at others, all as flat indices, where they are in the block and a step
        apart."""
        near, far = depth[seen[0]], depth[seen[1]]
        least = np.minimum(near, far)
        apart = np.abs(near - far) > np.maximum(JUMP, JUMP_SHARE * least)
        for end in ends:  # -1 for none
            apart &= (end >= 0) & (labels.ravel()[end] == label)
        for end, this in zip(ends, (near, far), strict=True):
            markers[end[apart]] = np.where(this == least, 1, 2)[apart]

    for step in ((0, 1), (1, 0)):
        beside = [flat_indices(jumps, step, by) for by in (-BESIDE, 1 + BESIDE)]
        for distance in range(1, _MARKED + 1):
            mark_sides([flat_indices(jumps, step, by) for by in (1 - distance, distance)], beside)
        sources = [inputs.source.ravel()[flat_indices(hidden, step, by)] for by in (0, 1)]
        mark_sides(sources, sources)
    return flood(_heights(inputs), markers.reshape(labels.shape), labels == label)


def _heights(inputs: CheckInput) -> NDArray[np.float32]:
    """How much a pixel looks like a border: its edge strength and, near known depth, the slope of the depth."""
    log = np.log(inputs.depth)
    across, down = (cv2.Sobel(log, cv2.CV_32F, *way, scale=1 / 8) for way in ((1, 0), (0, 1)))
    slope = np.where(inputs.relief.near, np.minimum(np.hypot(across, down) / _SLOPE, 1), 0)
    return np.asarray(inputs.strength + slope, np.float32)


# The neighbour that a part continues: without an edge at the border, and on the same surface.

_CONTRAST, _AT, _AROUND = 0.55, 3, 9
"""A border without an edge: mean ratio of the edge strength at it (in squares of this side [px]) to that around it (in
squares of that side)."""

_SAME_SHARE = 0.5
"""Minimum share of the border of two parts along which their surfaces continue each other."""

_BORDER_SHARE, _WIDTH = 0.5, 25.0
"""Minimum share of a part's border that is shared with the neighbour, and maximum mean width [px] of the part from it:
what a wrong border adds to a block is a band along it."""


def _continued(inputs: CheckInput, part: Mask, label: int) -> int:
    """The block beside a part of block `label` that the part belongs to; 0 for none."""
    others, same, contrast = _find_beside(inputs, part, label)
    if not same.any():
        return 0
    taker = int(np.argmax(np.bincount(others[same])))
    its = others == taker
    length = np.count_nonzero(its)
    band = length >= _BORDER_SHARE * its.size and np.count_nonzero(part) <= _WIDTH * length
    alike = same[its].mean() >= _SAME_SHARE and contrast[its].mean() <= _CONTRAST
    return taker if band and alike else 0


def _find_beside(inputs: CheckInput, part: Mask, label: int) -> list[NDArray[Any]]:
    """Pairs of a pixel of a part and its neighbour in another block: that block, whether the surfaces continue each
    other, and the contrast of the edge between them."""
    at, around = (cv2.dilate(inputs.strength, np.ones((side, side), np.uint8)) for side in (_AT, _AROUND))
    contrast = at / (around + np.float32(0.02))
    found = []
    for (inside, _), (_, beyond), (source, other), contrasts in neighbours(
        part, inputs.labels, inputs.source, contrast
    ):
        pairs = inside & (beyond > 0) & (beyond != label)
        apart = inputs.separation(source[pairs], other[pairs])
        found.append((beyond[pairs], apart == 0, np.maximum(*contrasts)[pairs]))
    return [np.concatenate(column) for column in zip(*found, strict=True)]
