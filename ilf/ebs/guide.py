"""What the extraction takes from a frame's edges: their strength, binarised edges, and what guides the contraction."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..edges.detectors import otsu_edges
from ..edges.frame_edges import FrameEdges
from ..edges.pairs import mark
from ..edges.relief import Relief
from ..parameters import BlockParameters

_CANNY_RAISE, _JUMP_HEIGHT, _CREASE_HEIGHT = 0.3, 1.5, 0.9
"""What Canny's lines add to the network's strength as the guide of the contraction, and how high jumps and the
sharpest creases stand in it."""

_MIDDLING_BEND = 1.5
"""Bend at which a crease stands half as high as the sharpest."""


@dataclass(frozen=True, eq=False)
class Boundaries:
    """Where blocks may end.

    Attributes
    ----------
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1]; depth jumps, those in long lines, stand at 1. Where creases are edges and the detector
        tells of them, the larger of both.
    edges : ndarray of bool, shape (H, W)
        The same, binarised.
    guide : ndarray of float32, shape (H, W)
        Along its crests, boundaries are drawn.
    relief : Relief or None
        What the known depth says, where it counts.
    """

    strength: NDArray[np.float32]
    edges: NDArray[np.bool_]
    guide: NDArray[np.float32]
    relief: Relief | None


def find_boundaries(
    found: FrameEdges, lines: NDArray[np.bool_], relief: Relief, parameters: BlockParameters
) -> Boundaries:
    """The boundaries that a frame's edges suggest.

    Parameters
    ----------
    found : FrameEdges
    lines : ndarray of bool, shape (H, W)
        Canny's.
    relief : Relief
    parameters : BlockParameters
        With which `find_edges`, `lines_of` and `relief_of` have found these.
    """
    strength, edges, guide = found.detected, lines, found.detected
    if parameters.use_depth and parameters.use_creases and found.crease is not None:
        strength = np.maximum(strength, found.crease)
    if found.network is not None:
        edges = otsu_edges(strength, parameters.threshold)
        guide = strength + np.where(lines, np.float32(_CANNY_RAISE), np.float32(0))
    if not parameters.use_depth:
        return Boundaries(strength, edges, guide, None)
    if parameters.use_creases and found.crease is None:
        # single pixels are noise
        edges = edges | (cv2.morphologyEx((relief.bend > 1).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3))) > 0)
        sharpness = relief.bend / (relief.bend + np.float32(_MIDDLING_BEND))
        guide = np.maximum(guide, np.float32(_CREASE_HEIGHT) * sharpness).astype(np.float32)
    jumps = mark(relief.jumps)
    return Boundaries(
        np.where(jumps, np.float32(1), strength),
        edges | jumps,
        np.where(jumps, np.float32(_JUMP_HEIGHT), guide),
        relief,
    )
