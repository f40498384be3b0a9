"""Which blocks a line runs through or begins near, and what is too thin to be meant."""

from __future__ import annotations

import math

import cv2
import numpy as np

from gui.tools.base import Point
from ilf.ebs.edit import LabelPatch, Labels

_THIN = 3
"""Pixels per pixel of the line that cuts it off up to which a part may be but its trembling."""


def crossed(labels: Labels, points: list[Point]) -> dict[int, int]:
    """How many pixels of a line are in each block that it crosses, the one that it crosses most first."""
    line = np.zeros(labels.shape, np.uint8)
    path = np.floor(np.asarray(points)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], False, 1)
    pixels = np.bincount(labels[line > 0], minlength=1)
    most = sorted(np.flatnonzero(pixels[1:]) + 1, key=lambda label: -pixels[label])
    return {int(label): int(pixels[label]) for label in most}


def is_thick(labels: Labels, label: int, patch: LabelPatch, pixels: int) -> bool:
    """Whether a cut by a line with so many pixels in a block leaves more on both of its sides than it trembles."""
    moved = np.count_nonzero(patch.before != patch.after)
    return bool(min(moved, np.count_nonzero(labels == label) - moved) > _THIN * pixels)


def around(labels: Labels, point: Point, reach: float) -> list[int]:
    """The blocks that have pixels within reach of a point, the nearest first."""
    (x, y), (height, width) = point, labels.shape
    top, left = (max(math.floor(at - reach), 0) for at in (y, x))
    seen = labels[top : min(math.ceil(y + reach), height), left : min(math.ceil(x + reach), width)]
    rows, columns = np.nonzero(seen)
    distance = np.hypot(columns + left + 0.5 - x, rows + top + 0.5 - y)
    order = np.argsort(distance, kind="stable")
    return list(dict.fromkeys(seen[rows, columns][order[distance[order] <= reach]].tolist()))
