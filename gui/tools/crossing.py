"""Which blocks a line runs through."""

from __future__ import annotations

import cv2
import numpy as np

from gui.tools.base import Point
from ilf.ebs.edit import Labels


def crossed(labels: Labels, points: list[Point]) -> dict[int, int]:
    """How many pixels of a line are in each block that it crosses, the one that it crosses most first."""
    line = np.zeros(labels.shape, np.uint8)
    path = np.floor(np.asarray(points)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], False, 1)
    pixels = np.bincount(labels[line > 0], minlength=1)
    most = sorted(np.flatnonzero(pixels[1:]) + 1, key=lambda label: -pixels[label])
    return {int(label): int(pixels[label]) for label in most}
