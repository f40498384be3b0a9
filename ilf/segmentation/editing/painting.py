"""Giving areas to a block, by brush stroke, outline or piece, and erasing."""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Box, Region, box_between, cropped, enclosed, grown, within
from ...data.frame import RGBDFrame
from ...data.pixel_grids import flood
from ..edges.detectors import colour_gradient
from ..edges.frame_edges import filled_depth
from .patches import LabelPatch, Labels, Mask, Points, patch_within, unlocked_pixels

# The brush: the pixels of a stroke.


def brush_stroke(shape: tuple[int, int], points: Points, radius: float) -> Region | None:
    """Pixels whose centre lies within `radius` [px] of the line through `points`; None if all are outside the frame.

    The pixel under each end of a segment always belongs to it, so a tiny brush still paints.
    """
    path = np.asarray(points, np.float64)
    box = box_between(path.min(axis=0) - (radius + 1), path.max(axis=0) + (radius + 1), shape)
    if box is None:
        return None
    centre_y, centre_x = np.mgrid[box] + 0.5
    mask = np.zeros(centre_x.shape, bool)
    for start, end in zip(path, path[1:] if len(path) > 1 else path, strict=False):
        along = end - start
        from_x, from_y, length = centre_x - start[0], centre_y - start[1], float(along @ along)
        share = 0.0 if length == 0 else np.clip((from_x * along[0] + from_y * along[1]) / length, 0, 1)
        mask |= (from_x - share * along[0]) ** 2 + (from_y - share * along[1]) ** 2 <= radius**2
    for x, y in path:
        row, column = int(np.floor(y)) - box[0].start, int(np.floor(x)) - box[1].start
        if 0 <= row < mask.shape[0] and 0 <= column < mask.shape[1]:
            mask[row, column] = True
    return Region(box, mask) if mask.any() else None


def paint(labels: Labels, stroke: Region, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give the stroke's pixels to a block (0: to no block), except those of locked blocks."""
    before = labels[stroke.box]
    return patch_within(stroke.box, before, np.where(stroke.mask & unlocked_pixels(before, locked), label, before))


def give(labels: Labels, piece_mask: Mask, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give a piece, bool (H, W), to a block (0: to no block), except pixels of locked blocks.

    None also if the block itself is locked.
    """
    piece = cropped(piece_mask)
    return None if piece is None or label in locked else paint(labels, piece, label, locked)


def assign_outline(labels: Labels, points: Points, label: int, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give all pixels inside a closed line to a block, except pixels of locked blocks.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    points : sequence of (x, y)
        The line; its last point is connected to its first. Pixels whose centre it encloses count; where it crosses
        itself, those that it encloses an odd number of times. It may leave the frame.
    label : int
        The block, which may be a new one; 0 for none.
    locked : collection of int
        Blocks that must not change; None if `label` is one.
    """
    if label in locked:
        return None
    inside = enclosed(points, labels.shape)
    return None if inside is None else paint(labels, inside, label, locked)


# Erasing pixels from a block: they go to no block, or to the best-fitting neighbours.

_SIGMA = 1.0
"""Blur [px] of the colour image before its gradient is taken."""

_DEPTH_WEIGHT = 400.0
"""Weight of the gradient of log depth, in units of the colour gradient."""

_AROUND = 4
"""Width [px] of the crop around the stroke."""


def erase(
    labels: Labels, stroke: Region, label: int, locked: Collection[int] = (), frame: RGBDFrame | None = None
) -> LabelPatch | None:
    """Remove the stroke's pixels from one block.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    stroke : Region
    label : int
        The block.
    locked : collection of int
        Blocks that must not change.
    frame : RGBDFrame, optional
        With it, the pixels go to the neighbouring blocks, which grow into them, first where colour and depth are
        smooth, and meet where either changes most. Pixels that no neighbour can reach belong to no block, and neither
        do any pixels without a frame.
    """
    if label in locked:
        return None
    box = grown(stroke.box, _AROUND if frame is not None else 0, labels.shape)
    before = labels[box]
    taken = np.zeros(before.shape, bool)
    taken[within(stroke.box, box)] = stroke.mask
    taken &= before == label
    if not taken.any():
        return None
    after = np.where(taken, 0, before).astype(np.int32)
    growing = np.where((after > 0) & (after != label) & unlocked_pixels(after, locked), after, 0)
    if frame is not None and growing.any():
        taken_by = flood(_steps(frame, box), growing, taken | (growing > 0))
        after = np.where(taken, taken_by, after).astype(np.int32)
    return patch_within(box, before, after)


def _steps(frame: RGBDFrame, box: Box) -> NDArray[np.float32]:
    """Gradient of colour and depth at every pixel of a box."""
    dx, dy = colour_gradient(frame.edge_rgb[box], _SIGMA)
    steps = np.hypot(dx.astype(np.float32), dy.astype(np.float32))
    depth = frame.depth[box]
    if np.isfinite(depth).any():
        filled = filled_depth(depth)
        inverse = np.log(filled)
        across, down = (cv2.Sobel(inverse, cv2.CV_32F, *way, borderType=cv2.BORDER_REFLECT) for way in ((1, 0), (0, 1)))
        steps += _DEPTH_WEIGHT * np.minimum(np.hypot(across, down), 1.0)
    return np.asarray(steps, np.float32)
