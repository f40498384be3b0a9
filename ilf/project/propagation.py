"""Propagating the blocks of one frame to another, with their names, colours and parameters."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..data.arrays import frozen
from ..data.blocks import Blocks, labels_in
from ..segmentation.propagation.propagate import Followed, follow
from ..segmentation.reextraction import made_by_hand
from ..sources.trajectories import motion_between
from .frame_state import FrameState


@dataclass(frozen=True, eq=False)
class Propagated:
    """The result of a propagation.

    Attributes
    ----------
    state : FrameState
        The target frame with the propagated blocks, without results.
    followed : Followed
        Details of the propagation. Block labels are those of the source frame.
    """

    state: FrameState
    followed: Followed


def propagate_state(before: FrameState, after: FrameState, how: str = "auto") -> Propagated:
    """Propagate the blocks of a frame to another by `ilf.segmentation.propagation.propagate`.

    Names, colours, locks, visibility, own parameters, drawn borders, the common parameters and the extrapolation
    setting are propagated, too. Locked blocks of the target frame stay as they are, unless they were propagated
    themselves and not edited since; a propagated block whose label is taken by such a block gets a new one.

    Parameters
    ----------
    before : FrameState
        The source frame.
    after : FrameState
        The target frame; of the same size.
    how : str
        "auto", "copied" or "flow". "auto" uses the camera poses if files beside the frames contain them.

    Raises
    ------
    InputError
        If the frames differ in size, or `how` is unknown.
    """
    notes = before.blocks
    followed = follow(
        before.frame,
        before.blocks.labels,
        after.frame,
        how=how,
        pose=motion_between(before.frame, after.frame) if how == "auto" else None,
        extraction=notes.extraction,
        drawn=notes.drawn,
        locked=notes.locked,
        taken={*notes.infos, *notes.own},
    )
    stays = _staying(after)
    numbers = _numbers(followed.labels, stays, {*notes.infos, *notes.own})
    here = np.isin(after.blocks.labels, list(stays))
    labels = np.where(here, after.blocks.labels, numbers[followed.labels]).astype(np.int32)
    there = labels_in(labels)

    def now(label: int) -> int:
        return int(numbers[label]) if label < numbers.size else label

    propagated = there - stays
    handmade = notes.handmade | made_by_hand(before.blocks.labels, notes.extracted)
    reasons = {now(label): reason for label, reason in followed.reasons.items() if now(label) in propagated}
    others = stays - set(range(numbers.size))  # their labels may be those of removed blocks of the source frame
    known = Blocks(
        labels,
        {now(label): info for label, info in notes.infos.items() if label not in others}
        | {label: info for label, info in after.blocks.infos.items() if label in stays},
        {now(label): own for label, own in notes.own.items() if label not in others}
        | {label: own for label, own in after.blocks.own.items() if label in stays},
        _drawn(followed, after, here),
        after.blocks.by_hand,
        notes.extraction,
        notes.network,
        frozen(labels.copy()),
        there,
        stays | {now(label) for label in handmade if now(label) in propagated},
        before.frame.name,
        reasons,
    )
    state = replace(
        after,
        blocks=known,
        common=before.common,
        extrapolate=before.extrapolate,
        own_parameters=before.own_parameters,
        results={},
        extrapolation=None,
        to_check=frozenset(reasons),
        selected=tuple(label for label in map(now, before.selected) if label in propagated),
    )
    return Propagated(state, followed)


def _staying(after: FrameState) -> frozenset[int]:
    """Return the locked blocks of the target frame that the propagation must not change."""
    locked = labels_in(after.blocks.labels) & after.blocks.locked
    return (
        locked & made_by_hand(after.blocks.labels, after.blocks.extracted) if after.blocks.propagated_from else locked
    )


def _numbers(labels: NDArray[np.int32], stays: Collection[int], taken: Collection[int]) -> NDArray[np.int32]:
    """Return the new label of each block of a map: another one if a staying block has the same label."""
    numbers = np.arange(int(labels.max()) + 1, dtype=np.int32)
    free = max(numbers.size, max(taken, default=0) + 1, max(stays, default=0) + 1)
    for label in stays:
        if 0 < label < numbers.size:
            numbers[label], free = free, free + 1
    return numbers


def _drawn(followed: Followed, after: FrameState, here: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    """Return the drawn borders of the propagated and of the staying blocks."""
    old = after.blocks.drawn
    if old is None or not (old & here).any():
        return None if followed.drawn is None else followed.drawn & ~here
    return (old & here) | (False if followed.drawn is None else followed.drawn & ~here)
