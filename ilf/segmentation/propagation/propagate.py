"""Blocks of one frame on the next: same camera position, moving camera, known pose."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._runtime.cancellation import check_stopped
from ...data.blocks import checked_drawn, checked_labels
from ...data.frame import RGBDFrame
from ...data.parameters import BlockParameters
from ...errors import InputError
from ..edges.frame_edges import find_edges
from ..editing.patches import border_pixels
from .motion import (
    ALL_STILL,
    Labels,
    Mask,
    Sources,
    around,
    by_flow,
    by_pose,
    camera_is_still,
    changed,
    depth_of_parts,
    detailed,
    flows_between,
    off_flow,
    parts_of,
    sources_of,
)
from .settling import Settled, extracted_anew, labels_in, settle

# Which carried blocks need a look, and why.

_UNSEEN, _WON, _KEPT = 0.1, 0.07, 0.85
"""Share of a block that was not seen before, and that was carried as another's, from which on it needs a look, and
share of what was carried of it that it keeps at least."""


def doubts(labels: Labels, settled: Settled) -> dict[int, str]:
    """Blocks that need a look, with a sentence each.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Of the frame before.
    settled : Settled
    """
    now, was = settled.labels, settled.carried
    count = int(max(now.max(), labels.max())) + 1
    size = np.bincount(now.ravel(), minlength=count)
    unseen = np.bincount(now[was < 0], minlength=count)
    won = np.bincount(now[(was >= 0) & (was != now)], minlength=count)
    kept = np.bincount(now[was == now], minlength=count)
    carried = np.bincount(was[was >= 0], minlength=count)
    reasons: dict[int, str] = {}
    for label in (np.flatnonzero(size[1:]) + 1).tolist():
        if label in settled.new:
            reasons[label] = "It was not in the picture before."
        elif unseen[label] >= _UNSEEN * size[label]:
            reasons[label] = f"{unseen[label] / size[label]:.0%} of it could not be seen before."
        elif won[label] >= _WON * size[label]:
            reasons[label] = f"{won[label] / size[label]:.0%} of it was another block's before."
        elif kept[label] < _KEPT * carried[label]:
            reasons[label] = f"It has lost {1 - kept[label] / carried[label]:.0%} of what it was before to its edges."
    return reasons


# Carrying blocks to the next frame.

WAYS = ("auto", "copied", "flow", "pose")
"""How blocks can be carried; auto takes the pose where it is known, else copies what is still and follows the rest."""

_LEAST = 0.15
"""Share of the picture whose flow must agree with itself: 0.8 and more from frame to frame of a video, 0.3 after two
thirds of the picture have changed, less than 0.05 between pictures of different places."""

_LOST = (
    "Only {share:.0%} of the picture could be followed from the frame before, so its blocks were extracted anew and "
    "named after what they lie on: look at all of them."
)

_POSE_OFF = 0.3
"""Half of the picture may be off its motion by the pose by more than this share of that motion, or of 8 px if it is
smaller: a pose that is turned around, or in other units, is off by 0.3 to 2, a true one by less than 0.05."""

_WRONG_POSE = (
    "The camera's pose does not fit the pictures: half of what they show is off by {off:.0%} or more of its motion. So "
    "the blocks were carried by optical flow. Poses must take points of the camera [m] to the world."
)

_OTHER = 0.1
"""Share of a copied block that shows something else from which on it needs a look."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Blocks carried to the next frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map on the frame after; the same numbers are the same blocks.
    drawn : ndarray of bool, shape (H, W), or None
        Borders that were drawn by hand, where they are now; None if there are none.
    how : str
        What was done: "copied", "flow" or "pose".
    uncertain : ndarray of bool, shape (H, W)
        Pixels whose block was decided by the new frame, not carried.
    to_check : frozenset of int
        Blocks of the new map that need a look.
    reasons : mapping of int to str
        Why, a sentence for each of them.
    new : frozenset of int
        Blocks that were not there before: surfaces that have come into the picture. They need a look, too.
    gone : frozenset of int
        Blocks that are no longer in the picture.
    notes : tuple of str
        What the user should know of how it went.
    """

    labels: NDArray[np.int32]
    drawn: Mask | None
    how: str
    uncertain: Mask
    to_check: frozenset[int] = frozenset()
    reasons: Mapping[int, str] = field(default_factory=dict)
    new: frozenset[int] = frozenset()
    gone: frozenset[int] = frozenset()
    notes: tuple[str, ...] = ()


def follow(
    before: RGBDFrame,
    labels: NDArray[np.integer],
    after: RGBDFrame,
    *,
    how: str = "auto",
    pose: ArrayLike | None = None,
    extraction: BlockParameters | None = None,
    drawn: ArrayLike | None = None,
    locked: Collection[int] = (),
    taken: Collection[int] = (),
) -> Followed:
    """Carry the blocks of a frame to the next one of the same camera.

    Parameters
    ----------
    before : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Its label map, 0 = no block.
    after : RGBDFrame
        The next frame, of the same size.
    how : str
        "copied": every pixel keeps its block, as from the same camera position. "flow": along optical flow. "pose":
        along a known motion of the camera, with flow where depth is missing. "auto": by the pose if it is given;
        else what has not changed is copied, and what has moved is carried by flow. A pose that the pictures contradict
        is left aside, which is said.
    pose : array_like of float, shape (4, 4), optional
        Takes points [m] of the camera before to the camera after (x to the right, y down, z forward). Both frames must
        have intrinsics.
    extraction : BlockParameters, optional
        What newly seen surfaces are extracted with, and what says how small a block may be.
    drawn : array_like of bool, shape (H, W), optional
        Pixels whose border was drawn by hand: it stays as it is carried, whatever edges lie beside it.
    locked : collection of int
        Blocks of which all borders do.
    taken : collection of int
        Numbers that no new block gets, beside those of the label map: of blocks that are gone but not forgotten.

    Returns
    -------
    Followed

    Raises
    ------
    InputError
        If sizes differ, `how` is unknown, or a pose is needed and missing, none, or without intrinsics.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> scene = np.kron(rng.integers(0, 255, (12, 20, 3)), np.ones((4, 4, 1))).astype(np.uint8)
    >>> labels = np.ones((48, 64), np.int32)
    >>> labels[16:32, 24:40] = 2
    >>> before, after = (RGBDFrame(scene[:, left : left + 64], np.full((48, 64), 1.5)) for left in (0, 4))
    >>> found = follow(before, labels, after)
    >>> found.how, found.labels[24, [19, 21, 34, 38]].tolist()
    ('flow', [1, 2, 2, 1])
    """
    if how not in WAYS:
        raise InputError(f"Blocks cannot be carried by {how!r}. Choose one of {', '.join(WAYS)}.")
    if before.shape != after.shape:
        raise InputError(
            f"The frames differ in size: {before.shape[1]} x {before.shape[0]} and {after.shape[1]} x "
            f"{after.shape[0]} pixels. Blocks can be carried between frames of the same size only."
        )
    present = checked_labels(labels, before.shape)
    hand = checked_drawn(drawn, before.shape)
    known = _pose(how, pose, before, after)
    if how == "copied":
        return _copied(present, hand, changed(before, after))
    flow, agrees = flows_between(before, after)
    still = None
    if how == "auto" and known is None and camera_is_still(before, flow):
        moved = changed(before, after)
        if moved.mean() <= ALL_STILL:
            return _copied(present, hand, moved)
        still = ~around(moved)
    parts = parts_of(present)
    check_stopped()
    depth = depth_of_parts(before, parts)
    check_stopped()
    motion, done = by_flow(flow, agrees, parts, depth), "flow"
    share = float(agrees.mean())
    chosen = extraction or BlockParameters()
    notes = find_edges(after, chosen).notes
    if known is not None:
        by_known = by_pose(before, after, known, depth, motion)
        off = off_flow(by_known, flow, agrees & detailed(before))
        if how == "pose" or off <= _POSE_OFF:
            motion, done, share = by_known, "pose", 1.0
        else:
            notes = (*notes, _WRONG_POSE.format(off=off))
    check_stopped()
    sources = sources_of(motion, after, still)
    check_stopped()
    if share < _LEAST:
        settled = extracted_anew(parts, sources, after, chosen, taken)
        reasons = dict.fromkeys(labels_in(settled.labels), "Too little of the picture is like the frame before.")
        notes = (*notes, _LOST.format(share=share))
    else:
        settled = settle(parts, sources, after, chosen, _firm(present, hand, locked), taken)
        reasons = doubts(present, settled)
    return Followed(
        settled.labels,
        _drawn_now(hand, settled.labels, sources),
        done,
        settled.uncertain,
        frozenset(reasons),
        reasons,
        settled.new,
        labels_in(present) - labels_in(settled.labels),
        notes,
    )


def _pose(how: str, pose: ArrayLike | None, before: RGBDFrame, after: RGBDFrame) -> NDArray[np.float64] | None:
    """The pose as a matrix; None where there is none and none is asked for."""
    if how in ("copied", "flow"):
        return None
    if pose is None:
        if how == "pose":
            raise InputError("Carrying blocks by the pose needs the camera's motion as a 4 x 4 matrix.")
        return None
    matrix = np.asarray(pose, np.float64)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3]) - 1) > 0.01:
        raise InputError("A pose must be a 4 x 4 matrix of a rotation and a shift in metres.")
    if before.intrinsics is None or after.intrinsics is None:
        if how == "pose":
            raise InputError("Carrying blocks by the pose needs the camera intrinsics of both frames.")
        return None
    return matrix


def _copied(labels: NDArray[np.int32], drawn: Mask | None, moved: Mask) -> Followed:
    """The label map as it is; blocks of which much shows something else need a look."""
    size = np.bincount(labels.ravel())
    off = np.bincount(labels[moved], minlength=size.size)
    reasons = {
        label: f"{off[label] / size[label]:.0%} of it show something else than before."
        for label in np.flatnonzero(off > _OTHER * size).tolist()
        if label > 0
    }
    return Followed(
        labels.copy(), None if drawn is None else drawn.copy(), "copied", moved, frozenset(reasons), reasons
    )


def _firm(labels: NDArray[np.int32], drawn: Mask | None, locked: Collection[int]) -> Mask | None:
    """Borders that hold: drawn ones, and those of locked blocks."""
    if not locked:
        return drawn
    of_locked = border_pixels(labels) & np.isin(labels, list(locked))
    return of_locked if drawn is None else of_locked | drawn


def _drawn_now(drawn: Mask | None, labels: NDArray[np.int32], sources: Sources) -> Mask | None:
    """Borders of blocks beside which a drawn one was carried to."""
    if drawn is None:
        return None
    carried = sources.seen & drawn.ravel()[sources.pixel]
    near = cv2.dilate(carried.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return checked_drawn(np.where(sources.still, carried, near & border_pixels(labels)), labels.shape)
