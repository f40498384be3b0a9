"""What would come of a line that is under way: what is said of it, and what is shown."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtGui import QPainterPath

from ilf._runtime.formatting import grouped
from ilf.segmentation.editing.patches import LabelPatch

from ..state.session import Session
from ..views.pixel_items import boundary_path

_NAMED = 2
"""Blocks that give pixels which are named one by one; more are counted."""


@dataclass(frozen=True, eq=False)
class Outlook:
    """What would come of a line if it ended where it is.

    Attributes
    ----------
    text : str
        What is said of it.
    path : QPainterPath
        What is drawn dashed.
    """

    text: str
    path: QPainterPath = field(default_factory=QPainterPath)


def of_patch(session: Session, patch: LabelPatch | None, apart: int = 0) -> Outlook:
    """The outlook on a change of the label map: whose pixels go where, and around them.

    Parameters
    ----------
    session : Session
    patch : LabelPatch or None
        The change; None for none. Of one that a lock forbids, the locked block is named alone.
    apart : int
        How many of the pixels would lie apart from the block that gets them.
    """
    if patch is None:
        return Outlook("no pixel changes hands")
    changed = patch.before != patch.after
    moves = np.stack([patch.before[changed], patch.after[changed]], axis=1)
    pairs, counts = np.unique(moves, axis=0, return_counts=True)
    locked = sorted(session.locked & set(pairs.ravel().tolist()))
    if locked:
        return Outlook(f"{session.info(locked[0]).name} is locked")
    if len(pairs) > _NAMED:
        text = f"{grouped(int(counts.sum()))} px from {len(pairs)} blocks to {_name(session, int(pairs[0, 1]))}"
    else:
        text = ", ".join(
            f"{grouped(count)} px from {_name(session, giver)} to {_name(session, taker)}"
            for count, (giver, taker) in zip(counts.tolist(), pairs.tolist(), strict=True)
        )
    rows, columns = patch.box
    path = boundary_path(changed, columns.start, rows.start)
    if apart:
        text += f", {'' if apart == counts.sum() else f'{grouped(apart)} px of them '}apart from the rest of it"
    return Outlook(text, path)


def say_apart(name: str, apart: int) -> str:
    """What is said once a block has got pixels that lie apart from it."""
    return f"{name} has got {grouped(apart)} px that lie apart from the rest of it."


def _name(session: Session, label: int) -> str:
    """What a block is called, without making a new one known by that."""
    if label == 0:
        return "no block"
    return session.info(label).name if label in session.infos or label in session.counts() else "a new block"
