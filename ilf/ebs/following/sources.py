"""Where the pixels of a frame come from in the one before it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]

_CRACK = 0.5
"""Share of the 3 x 3 pixels around one that something has moved to, above which it shows the same: what is stretched
gets cracks, while what comes to light behind something is open to one side."""

_JUMP, _JUMP_SHARE = 0.05, 0.04
"""How far [m] depth may be off what has moved there, and the same as a share of the depth: the larger of the two."""

_AROUND, _ENOUGH = 31, 0.05
"""Side [px] of the squares over which the motion in depth is averaged, and share of them that must take part."""

_NEARBY, _NEARBY_SHARE = 0.2, 0.1
"""Pixels take part in it whose motion is off the usual by less than this [m], or this share of the depth."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Where every pixel of the frame before is in the frame after.

    Attributes
    ----------
    columns, rows : ndarray of float32, shape (H, W)
        Its place [px]; NaN where it is not known.
    depth : ndarray of float32, shape (H, W)
        Its depth there [m], as far as it is known; else NaN.
    sure : ndarray of bool, shape (H, W)
        Where that can be relied on.
    """

    columns: Field
    rows: Field
    depth: Field
    sure: Mask


@dataclass(frozen=True, eq=False)
class Sources:
    """For every pixel of the frame after, the pixel before that shows the same point, and how sure that is.

    Attributes
    ----------
    pixel : ndarray of intp, shape (H, W)
        Index of the pixel in the frame before; that of one beside it where `seen` is False.
    seen : ndarray of bool, shape (H, W)
        False where the frame before does not show the point: beyond its rim, or behind something else.
    sure : ndarray of bool, shape (H, W)
        Part of `seen`: pixels that can be relied on.
    still : ndarray of bool, shape (H, W)
        Part of `sure`: pixels that have not changed at all, whose blocks are copied as they are.
    """

    pixel: NDArray[np.intp]
    seen: Mask
    sure: Mask
    still: Mask


def sources_of(motion: Motion, after: RGBDFrame, still: Mask | None = None) -> Sources:
    """What has moved to every pixel: the nearest by depth, unless the depth that is seen there is another.

    Parameters
    ----------
    motion : Motion
    after : RGBDFrame
    still : ndarray of bool, shape (H, W), optional
        Pixels that come from their own place, whatever the motion says.
    """
    height, width = after.shape
    columns, rows = motion.columns, motion.rows
    with np.errstate(invalid="ignore"):
        inside = (columns > -0.5) & (columns < width - 0.5) & (rows > -0.5) & (rows < height - 0.5)
    moved = np.flatnonzero(inside)
    # the last of those that fall on a pixel stays: the nearest, and before all the known
    moved = moved[np.argsort(-np.nan_to_num(motion.depth.ravel()[moved], nan=np.inf), kind="stable")]
    target = np.rint(rows.ravel()[moved]).astype(np.intp) * width
    target += np.rint(columns.ravel()[moved]).astype(np.intp)
    pixel = np.full((height, width), -1, np.intp)
    pixel.flat[target] = moved
    seen = pixel >= 0
    if seen.any() and not seen.all():
        around = cv2.blur(seen.astype(np.float32), (3, 3), borderType=cv2.BORDER_CONSTANT)
        pixel = _from_the_nearest(pixel, seen)
        seen = seen | (around > _CRACK)
    pixel = np.maximum(pixel, 0)
    seen &= ~_other_surface(motion.depth.ravel()[pixel], np.where(seen, after.depth, np.float32(np.nan)))
    sure = seen & motion.sure.ravel()[pixel]
    if still is None:
        return Sources(pixel, seen, sure, np.zeros(after.shape, bool))
    own = np.arange(height * width).reshape(height, width)
    return Sources(np.where(still, own, pixel), seen | still, sure | still, still)


def _from_the_nearest(values: NDArray[np.intp], there: Mask) -> NDArray[np.intp]:
    """Values where there are some, else that of the nearest pixel."""
    _, which = cv2.distanceTransformWithLabels(
        (~there).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    value_of = np.zeros(int(which.max()) + 1, np.intp)
    value_of[which[there]] = values[there]
    return value_of[which]


def _other_surface(expected: Field, depth: Field) -> Mask:
    """Where the depth says that another surface is seen than the one that has moved there."""
    off = depth - expected
    known = np.isfinite(off)
    if not known.any():
        return known
    # what the camera's own motion changes is much alike among neighbours
    usual = np.float32(np.median(off[known]))
    near = known & (np.abs(off - usual) <= np.maximum(_NEARBY, _NEARBY_SHARE * np.nan_to_num(depth)))
    weight = cv2.blur(near.astype(np.float32), (_AROUND, _AROUND))
    local = cv2.blur(np.where(near, off, np.float32(0)), (_AROUND, _AROUND)) / np.maximum(weight, np.float32(1e-6))
    with np.errstate(invalid="ignore"):
        off = np.abs(off - np.where(weight > _ENOUGH, local, usual))
        found = off > np.maximum(_JUMP, _JUMP_SHARE * np.fmin(expected, depth))
    return cv2.morphologyEx(found.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
