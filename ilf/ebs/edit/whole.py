"""Whole blocks: dissolved or joined."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import cv2
import numpy as np

from .patches import LabelPatch, Labels, bounds, patch_between


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
