"""Whole blocks: dissolved or joined."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import cv2
import numpy as np

from .cracks import have_border
from .patches import LabelPatch, Labels, bounds, grown, patch_between


def delete(labels: Labels, chosen: Collection[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Dissolve blocks: their pixels belong to no block afterwards."""
    doomed = [label for label in chosen if label not in locked and label > 0]
    return patch_between(labels, np.where(np.isin(labels, doomed), 0, labels).astype(np.int32))


def merge(labels: Labels, chosen: Sequence[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Join blocks under the first label of `chosen`. Locked blocks take no part."""
    free = [label for label in chosen if label not in locked and label > 0]
    if len(free) < 2:
        return None
    return patch_between(labels, np.where(np.isin(labels, free), free[0], labels).astype(np.int32))


def parts_touch(labels: Labels, chosen: Collection[int]) -> bool:
    """Whether the pixels of some blocks are one 4-connected region, as a block should be once they are merged."""
    together = np.isin(labels, [label for label in chosen if label > 0])
    box = bounds(together)
    return box is None or cv2.connectedComponents(together[box].astype(np.uint8), connectivity=4)[0] <= 2


def pixels_apart(labels: Labels, patch: LabelPatch | None, label: int) -> int:
    """How many of the pixels that a change gives a block have no border with the pixels that it has.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Before the change.
    patch : LabelPatch or None
        The change; None for none.
    label : int
        The block; one without pixels has none apart.
    """
    if patch is None or not (labels == label).any():
        return 0
    gained = np.zeros(labels.shape, np.uint8)
    gained[patch.box] = (patch.before != label) & (patch.after == label)
    box = grown(patch.box, 1, labels.shape)
    areas = cv2.connectedComponents(gained[box], connectivity=4)[1].astype(np.int32)
    apart = ~have_border(areas, labels[box] == label)
    apart[0] = False
    return int(np.count_nonzero(apart[areas]))
