"""Preview of the effect of a line in progress."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtGui import QPainterPath

from ilf._runtime.formatting import grouped
from ilf.segmentation.editing.patches import LabelPatch

from ..state.document import Document
from ..views.pixel_items import boundary_path
from .base import Host

_NAMED = 2
"""Maximum number of pairs of blocks that are listed by name; more are counted."""


@dataclass(frozen=True, eq=False)
class LinePreview:
    """The effect of a line if it ended now.

    Attributes
    ----------
    text : str
        Its description.
    path : QPainterPath
        Its dashed outline.
    """

    text: str
    path: QPainterPath = field(default_factory=QPainterPath)


def preview_of_patch(document: Document, patch: LabelPatch | None, apart: int = 0) -> LinePreview:
    """Return the preview of a change of the label map: the moved pixels and their outline.

    Parameters
    ----------
    document : Document
    patch : LabelPatch or None
        The change; None for none. If a lock forbids it, the text contains only the locked block.
    apart : int
        Number of pixels that would be disconnected from the block that gets them.
    """
    if patch is None:
        return LinePreview("no pixel changes")
    changed = patch.before != patch.after
    moves = np.stack([patch.before[changed], patch.after[changed]], axis=1)
    pairs, counts = np.unique(moves, axis=0, return_counts=True)
    locked = sorted(document.locked & set(pairs.ravel().tolist()))
    if locked:
        return LinePreview(f"{document.info(locked[0]).name} is locked")
    if len(pairs) > _NAMED:
        text = f"{grouped(int(counts.sum()))} px from {len(pairs)} blocks to {_name(document, int(pairs[0, 1]))}"
    else:
        text = ", ".join(
            f"{grouped(count)} px from {_name(document, giver)} to {_name(document, taker)}"
            for count, (giver, taker) in zip(counts.tolist(), pairs.tolist(), strict=True)
        )
    rows, columns = patch.box
    path = boundary_path(changed, columns.start, rows.start)
    if apart:
        text += f", {'' if apart == counts.sum() else f'{grouped(apart)} px of them '}disconnected from the rest of it"
    return LinePreview(text, path)


def tell_if_apart(host: Host, label: int, apart: int, remedy: str = "") -> None:
    """Show a message with a remedy if a block has got disconnected pixels."""
    if apart:
        name = host.document.info(label).name
        host.show_message(f"{name} now has {grouped(apart)} px that are disconnected from the rest of it.{remedy}")


def _name(document: Document, label: int) -> str:
    """Return the name of a block, without registering a new one."""
    if label == 0:
        return "no block"
    return document.info(label).name if label in document.blocks.infos or label in document.counts() else "a new block"
