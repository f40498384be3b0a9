"""Connected parts of blocks, each of which moves as its inside does."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ...blocks import find_blocks
from .sources import Field, Mask

Labels = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Parts:
    """Connected parts of a label map's blocks, and of what belongs to none.

    Attributes
    ----------
    map : ndarray of int32, shape (H, W)
        Parts 1, 2, ...
    label : ndarray of int32, shape (N + 1,)
        Part -> the block that it is of; 0 for none, and of the part 0, which there is not.
    reach : ndarray of float32, shape (H, W)
        Distance [px] to the nearest pixel of another part.
    """

    map: Labels
    label: NDArray[np.int32]
    reach: Field


def parts_of(labels: Labels) -> Parts:
    """The parts of a label map, int32 (H, W)."""
    parts = np.asarray(connected_regions(labels, background=-1, connectivity=1), np.int32)
    label_of = np.zeros(int(parts.max()) + 1, np.int32)
    label_of[parts] = labels
    return Parts(parts, label_of, reach_of(parts))


def reach_of(parts: Labels) -> Field:
    """Distance [px] of every pixel to the nearest of another part."""
    number = parts.astype(np.float32)
    square = np.ones((3, 3), np.uint8)
    inner = cv2.erode(number, square) == cv2.dilate(number, square)
    return np.asarray(cv2.distanceTransform(inner.astype(np.uint8), cv2.DIST_L2, 5), np.float32) + 1


def ridge(reach: Field) -> Mask:
    """Pixels in the middle of what is thin, or of anything."""
    return (reach >= cv2.dilate(reach, np.ones((3, 3), np.uint8))) & (reach > 1)


def nearest_in_part(parts: Labels, good: Mask) -> NDArray[np.intp]:
    """For every pixel, the index of the nearest good pixel of the same part; -1 where a part has none."""
    height, width = parts.shape
    own = np.arange(height * width).reshape(height, width)
    nearest = np.where(good, own, -1)
    for part in find_blocks(parts).values():
        here = part.mask & good[part.box]
        if not here.any() or not (part.mask & ~here).any():
            continue
        _, which = cv2.distanceTransformWithLabels(
            (~here).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
        )
        index_of = np.zeros(int(which.max()) + 1, np.intp)
        index_of[which[here]] = own[part.box][here]
        nearest[part.box][part.mask] = index_of[which[part.mask]]
    return nearest
