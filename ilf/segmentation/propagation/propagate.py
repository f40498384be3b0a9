"""Propagating blocks from one frame to the next: same camera position, moving camera, known pose."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._runtime.long_work import check_cancelled
from ...data.arrays import check_shape
from ...data.blocks import checked_drawn, checked_labels, labels_in
from ...data.camera import checked_transform
from ...data.frame import RGBDFrame
from ...data.parameters import BlockParameters
from ...errors import InputError
from ..edges.frame_edges import find_edges
from ..editing.patches import border_pixels
from .motion import (
    MAX_STATIC_CHANGE,
    Labels,
    Mask,
    Sources,
    around,
    camera_is_static,
    changed,
    consistent_flow,
    depth_of_parts,
    detailed,
    difference_from_flow,
    motion_by_flow,
    motion_by_pose,
    parts_of,
    sources_of,
)
from .refining import extract_again, refine

# Propagated blocks that should be checked, and why.

_UNSEEN, _WON, _KEPT = 0.1, 0.07, 0.85
"""A block is to be checked from these fractions of it on: pixels not visible in the previous frame, and pixels
propagated from another block; or if it keeps less than the last fraction of its propagated pixels."""


def reasons_to_check(labels: Labels, now: Labels, was: Labels) -> dict[int, str]:
    """Blocks to check, with the reason as a sentence each.

    Parameters
    ----------
    labels, now : ndarray of int32, shape (H, W)
        Label maps of the previous and of the new frame.
    was : ndarray of int32, shape (H, W)
        Labels propagated to the new frame, -1 where there are none.
    """
    before = labels_in(labels)
    count = int(max(now.max(), labels.max())) + 1
    size = np.bincount(now.ravel(), minlength=count)
    unseen = np.bincount(now[was < 0], minlength=count)
    won = np.bincount(now[(was >= 0) & (was != now)], minlength=count)
    kept = np.bincount(now[was == now], minlength=count)
    propagated = np.bincount(was[was >= 0], minlength=count)
    reasons: dict[int, str] = {}
    for label in (np.flatnonzero(size[1:]) + 1).tolist():
        if label not in before:
            reasons[label] = "It is not in the previous frame."
        elif unseen[label] >= _UNSEEN * size[label]:
            reasons[label] = f"{unseen[label] / size[label]:.0%} of it is not visible in the previous frame."
        elif won[label] >= _WON * size[label]:
            reasons[label] = f"{won[label] / size[label]:.0%} of it belonged to another block in the previous frame."
        elif kept[label] < _KEPT * propagated[label]:
            reasons[label] = (
                f"It lost {1 - kept[label] / propagated[label]:.0%} of its pixels in the refinement on edges."
            )
    return reasons


# Propagating blocks to the next frame.

METHODS = ("auto", "copied", "flow", "pose")
"""Methods of propagation; auto uses the pose if it is known, else copies static pixels and uses flow for the rest."""

_MIN_CONSISTENT_SHARE = 0.15
"""Minimum fraction of the image with consistent flow: it is 0.8 and more between frames of a video, 0.3 after two
thirds of the image have changed, less than 0.05 between images of different places."""

_LOW_MATCH_NOTE = (
    "Only {share:.0%} of the image could be tracked from the previous frame, so its blocks were extracted again and "
    "named by overlap with the propagated ones: check all of them."
)

_MAX_POSE_ERROR = 0.3
"""Maximum median difference of the motion by the pose from the flow, as a fraction of the motion, or of 8 px if that is
larger: an inverted pose, or one in other units, differs by 0.3 to 2, a correct one by less than 0.05."""

_WRONG_POSE_NOTE = (
    "The camera pose does not fit the images: the median error is {off:.0%} of the motion. The blocks were propagated "
    "by optical flow instead. Poses must transform points of the camera [m] to the world."
)

_MAX_CHANGED_SHARE = 0.1
"""A copied block is to be checked if more than this fraction of it has changed."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Blocks propagated to the next frame.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map of the new frame; the same numbers are the same blocks.
    drawn : ndarray of bool, shape (H, W), or None
        Drawn borders at their new positions; None if there are none.
    how : str
        The method used: "copied", "flow" or "pose".
    reasons : mapping of int to str
        Block to check, such as a new one -> the reason, a sentence.
    notes : tuple of str
        Notes for the user.
    """

    labels: NDArray[np.int32]
    drawn: Mask | None
    how: str
    reasons: Mapping[int, str] = field(default_factory=dict)
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
    """Propagate the blocks of a frame to the next one of the same camera.

    Parameters
    ----------
    before : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Its label map, 0 = no block.
    after : RGBDFrame
        The next frame, of the same size.
    how : str
        "copied": every pixel keeps its block, for a static camera. "flow": along optical flow. "pose": along a known
        motion of the camera, with flow where depth is missing. "auto": by the pose if it is given; else static pixels
        are copied, and moved ones are propagated by flow. A pose that contradicts the images is ignored, with a note.
    pose : array_like of float, shape (4, 4), optional
        Transform of points [m] from the camera before to the camera after (x to the right, y down, z forward). Both
        frames must have intrinsics.
    extraction : BlockParameters, optional
        Parameters for extracting newly visible surfaces, including the minimum size of a block.
    drawn : array_like of bool, shape (H, W), optional
        Pixels whose border was drawn by hand: it stays as propagated, even beside edges.
    locked : collection of int
        Blocks whose borders all stay as propagated.
    taken : collection of int
        Numbers that no new block gets, besides those of the label map: blocks that are gone but still stored.

    Returns
    -------
    Followed

    Raises
    ------
    InputError
        If sizes differ, `how` is unknown, or a pose is needed but missing, invalid, or without intrinsics.

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
    if how not in METHODS:
        raise InputError(f"Blocks cannot be propagated by {how!r}. Select one of {', '.join(METHODS)}.")
    remedy = "Blocks can only be propagated between frames of the same size."
    check_shape("The frame with blocks", before.shape, after.shape, "the other one", remedy)
    present = checked_labels(labels, before.shape)
    hand = checked_drawn(drawn, before.shape)
    known = _pose(how, pose, before, after)
    if how == "copied":
        return _copied(present, hand, changed(before, after))
    flow, agrees = consistent_flow(before, after)
    still = np.zeros(after.shape, bool)
    if how == "auto" and known is None and camera_is_static(before, flow):
        moved = changed(before, after)
        if moved.mean() <= MAX_STATIC_CHANGE:
            return _copied(present, hand, moved)
        still = ~around(moved)
    parts = parts_of(present)
    check_cancelled()
    depth = depth_of_parts(before, parts)
    check_cancelled()
    motion, done = motion_by_flow(flow, agrees, parts, depth), "flow"
    share = float(agrees.mean())
    chosen = extraction or BlockParameters()
    notes = find_edges(after, chosen).notes
    if known is not None:
        by_known = motion_by_pose(before, after, known, depth, motion)
        off = difference_from_flow(by_known, flow, agrees & detailed(before))
        if how == "pose" or off <= _MAX_POSE_ERROR:
            motion, done, share = by_known, "pose", 1.0
        else:
            notes = (*notes, _WRONG_POSE_NOTE.format(off=off))
    check_cancelled()
    sources = sources_of(motion, after, still)
    check_cancelled()
    if share < _MIN_CONSISTENT_SHARE:
        found = extract_again(parts, sources, after, chosen, taken)
        reasons = dict.fromkeys(labels_in(found), "Too little of the image matches the previous frame.")
        notes = (*notes, _LOW_MATCH_NOTE.format(share=share))
    else:
        found, propagated = refine(parts, sources, after, chosen, _fixed_borders(present, hand, locked), taken)
        reasons = reasons_to_check(present, found, propagated)
    return Followed(found, _drawn_now(hand, found, sources), done, reasons, notes)


def _pose(how: str, pose: ArrayLike | None, before: RGBDFrame, after: RGBDFrame) -> NDArray[np.float64] | None:
    """The pose as a matrix; None if there is none and none is required."""
    if how in ("copied", "flow"):
        return None
    matrix = None if pose is None else checked_transform(pose, "A pose")
    has_cameras = before.intrinsics is not None and after.intrinsics is not None
    if how == "pose" and matrix is None:
        raise InputError("Propagation by pose needs the camera's motion as a 4 x 4 matrix.")
    if how == "pose" and not has_cameras:
        raise InputError("Propagation by pose needs the camera intrinsics of both frames.")
    return matrix if has_cameras else None


def _copied(labels: NDArray[np.int32], drawn: Mask | None, moved: Mask) -> Followed:
    """The unchanged label map; blocks with many changed pixels are to be checked."""
    size = np.bincount(labels.ravel())
    off = np.bincount(labels[moved], minlength=size.size)
    reasons = {
        label: f"{off[label] / size[label]:.0%} of it has changed since the previous frame."
        for label in np.flatnonzero(off > _MAX_CHANGED_SHARE * size).tolist()
        if label > 0
    }
    return Followed(labels.copy(), None if drawn is None else drawn.copy(), "copied", reasons)


def _fixed_borders(labels: NDArray[np.int32], drawn: Mask | None, locked: Collection[int]) -> Mask | None:
    """Borders that stay as propagated: drawn ones, and those of locked blocks."""
    if not locked:
        return drawn
    of_locked = border_pixels(labels) & np.isin(labels, list(locked))
    return of_locked if drawn is None else of_locked | drawn


def _drawn_now(drawn: Mask | None, labels: NDArray[np.int32], sources: Sources) -> Mask | None:
    """Borders of blocks near the propagated position of a drawn one."""
    if drawn is None:
        return None
    propagated = sources.seen & drawn.ravel()[sources.pixel]
    near = cv2.dilate(propagated.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return checked_drawn(np.where(sources.still, propagated, near & border_pixels(labels)), labels.shape)
