"""Taking pixels from a block: to no block, or to the neighbours that they fit best."""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from ...blocks import Box
from ...edges.detectors import colour_gradient
from ...edges.relief import filled_depth
from ...frame import RGBDFrame
from ..flooding import flood
from .brush import Stroke
from .patches import LabelPatch, Labels, Mask, free_of, grown, patch_within

_SIGMA = 1.0
"""Blur [px] of the colour image before its gradient is taken."""

_DEPTH_WEIGHT = 400.0
"""What a step of depth by its own size counts, in units of the colour gradient."""

_AROUND = 4
"""How far [px] around the stroke is looked at."""


def erase(
    labels: Labels, stroke: Stroke, label: int, locked: Collection[int] = (), frame: RGBDFrame | None = None
) -> LabelPatch | None:
    """Take the stroke's pixels from one block.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    stroke : Stroke
    label : int
        The block.
    locked : collection of int
        Blocks that must not change.
    frame : RGBDFrame, optional
        With it, the pixels go to the neighbouring blocks: these grow into them, first where colour and depth go on,
        and meet where either changes most. What no neighbour can reach belongs to no block, and so does all without a
        frame.
    """
    if label in locked:
        return None
    box = grown(stroke.box, _AROUND if frame is not None else 0, labels.shape)
    before = labels[box]
    taken = np.zeros(before.shape, bool)
    rows, columns = (slice(s.start - b.start, s.stop - b.start) for s, b in zip(stroke.box, box, strict=True))
    taken[rows, columns] = stroke.mask
    taken &= before == label
    if not taken.any():
        return None
    after = np.where(taken, 0, before).astype(np.int32)
    if frame is not None:
        after = _grown_into(after, taken, label, locked, _steps(frame, box))
    return patch_within(box, before, after)


def _grown_into(labels: Labels, taken: Mask, label: int, locked: Collection[int], steps: NDArray[np.float32]) -> Labels:
    growing = np.where((labels > 0) & (labels != label) & free_of(labels, locked), labels, 0)
    if not growing.any():
        return labels
    grown_labels = flood(steps, growing, taken | (growing > 0))
    return np.where(taken, grown_labels, labels).astype(np.int32)


def _steps(frame: RGBDFrame, box: Box) -> NDArray[np.float32]:
    """How much colour and depth change at every pixel of a box."""
    dx, dy = colour_gradient(frame.rgb[box], _SIGMA)
    steps = np.hypot(dx.astype(np.float32), dy.astype(np.float32))
    depth = frame.depth[box]
    if np.isfinite(depth).any():
        filled, _ = filled_depth(depth)
        inverse = np.log(filled)
        across, down = (cv2.Sobel(inverse, cv2.CV_32F, *way, borderType=cv2.BORDER_REFLECT) for way in ((1, 0), (0, 1)))
        steps += _DEPTH_WEIGHT * np.minimum(np.hypot(across, down), 1.0)
    return np.asarray(steps, np.float32)
