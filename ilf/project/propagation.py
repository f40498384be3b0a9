"""A frame with the blocks of another one: carried to it, with all that is known of them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..segmentation.propagation.propagate import Followed, follow
from ..segmentation.reextraction import made_by_hand
from ..sources.poses import motion_between
from .frame_state import BlockNotes, FrameState


@dataclass(frozen=True, eq=False)
class Carried:
    """What carrying gave.

    Attributes
    ----------
    state : FrameState
        The frame after, with the blocks, and without results.
    followed : Followed
        How the blocks were carried. Numbers of blocks are those of the frame before.
    """

    state: FrameState
    followed: Followed


def carry(before: FrameState, after: FrameState, how: str = "auto") -> Carried:
    """Give a frame the blocks of another, as `ilf.segmentation.propagation.propagate` carries them.

    Names, colours, locks, visibility, own values and drawn borders go along, and so do the common parameters and
    whether the rest is guessed. Blocks that are locked in the frame after stay there as they are, unless they had been
    carried there and nobody has edited them since; a carried block that has the number of one that stays gets another.

    Parameters
    ----------
    before : FrameState
        Whose blocks are carried.
    after : FrameState
        As it is; of the same size.
    how : str
        "auto", "copied" or "flow". "auto" goes by the camera's poses where files beside the frames tell them.

    Raises
    ------
    InputError
        If the frames differ in size, or `how` is unknown.
    """
    notes = before.notes
    followed = follow(
        before.frame,
        before.labels,
        after.frame,
        how=how,
        pose=motion_between(before.frame, after.frame) if how == "auto" else None,
        extraction=notes.extraction,
        drawn=notes.drawn,
        locked=[label for label, info in notes.infos.items() if info.locked],
        taken={*notes.infos, *notes.own},
    )
    stays = _staying(after)
    numbers = _numbers(followed.labels, stays, {*notes.infos, *notes.own})
    here = np.isin(after.labels, list(stays))
    labels = np.where(here, after.labels, numbers[followed.labels]).astype(np.int32)
    there = frozenset(np.flatnonzero(np.bincount(labels.ravel())).tolist()) - {0}

    def now(label: int) -> int:
        return int(numbers[label]) if label < numbers.size else label

    carried = there - stays
    handmade = notes.handmade | made_by_hand(before.labels, notes.extracted)
    reasons = {now(label): reason for label, reason in followed.reasons.items() if now(label) in carried}
    came = labels.copy()
    came.setflags(write=False)
    others = stays - set(range(numbers.size))  # they may have the numbers of blocks that are gone before
    known = BlockNotes(
        {now(label): info for label, info in notes.infos.items() if label not in others}
        | {label: info for label, info in after.notes.infos.items() if label in stays},
        {now(label): own for label, own in notes.own.items() if label not in others}
        | {label: own for label, own in after.notes.own.items() if label in stays},
        _drawn(followed, after, here),
        notes.extraction,
        notes.network,
        came,
        there,
        stays | {now(label) for label in handmade if now(label) in carried},
        before.frame.name,
        reasons,
    )
    state = replace(
        after,
        labels=labels,
        notes=known,
        common=before.common,
        dense=before.dense,
        own_parameters=before.own_parameters,
        results={},
        guess=None,
        to_check=frozenset(now(label) for label in followed.to_check) & carried,
        selected=tuple(label for label in map(now, before.selected) if label in carried),
    )
    return Carried(state, followed)


def _staying(after: FrameState) -> frozenset[int]:
    """Locked blocks that carried ones must leave as they are."""
    there = frozenset(np.flatnonzero(np.bincount(after.labels.ravel())).tolist()) - {0}
    locked = there & {label for label, info in after.notes.infos.items() if info.locked}
    return locked & made_by_hand(after.labels, after.notes.extracted) if after.notes.carried_from else locked


def _numbers(labels: NDArray[np.int32], stays: Collection[int], taken: Collection[int]) -> NDArray[np.int32]:
    """The number that each block of a map has from now on: another one where a block that stays has its own."""
    numbers = np.arange(int(labels.max()) + 1, dtype=np.int32)
    free = max(numbers.size, max(taken, default=0) + 1, max(stays, default=0) + 1)
    for label in stays:
        if 0 < label < numbers.size:
            numbers[label], free = free, free + 1
    return numbers


def _drawn(followed: Followed, after: FrameState, here: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    """Drawn borders of the carried blocks, and of those that stay."""
    old = after.notes.drawn
    if old is None or not (old & here).any():
        return None if followed.drawn is None else followed.drawn & ~here
    return (old & here) | (False if followed.drawn is None else followed.drawn & ~here)
