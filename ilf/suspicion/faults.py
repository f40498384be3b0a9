"""Blocks that hold more than one surface: depth that jumps inside of them, seen or hidden in missing depth."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from ..edges.pairs import Pairs, apart, long_lines, sides
from ..edges.relief import JUMP_LENGTH
from .ground import Ground
from .groups import Group, largest_groups, number_groups
from .place import Place

_REACH = 24
"""How far [px] from a fault filled depth is spoilt by it: all the way where it runs, and less and less away from it."""

_KNOWN = 0.03
"""What a pixel of known depth beside a fault counts, of one that is to be filled."""

_BESIDE = 2
"""How far [px] from a jump the depth on its sides is looked at: right beside it, pixels may lie on neither."""


_FAR = 20.0
"""Distance [px] between two known pixels at which a difference between their surfaces counts half: across a wide gap,
it may as well be a bend."""

_FOUND, _AROUND = 0.5, 7
"""Edge strength that bears out what lies hidden, and how far [px] from where it is thought to be."""

_UNSEEN = 0.3
"""What two surfaces count with no edge of colour between them."""


def find_faults(ground: Ground, strength: NDArray[np.float32]) -> Iterator[Place]:
    """Depth jumps inside blocks, and blocks with two surfaces that only missing depth parts."""
    jumps, hidden = _jumps(ground), _hidden(ground, strength)
    step = np.maximum(jumps, hidden)
    numbers = number_groups(step > 0, ground.labels)
    if not numbers.any():
        return
    for group in largest_groups(numbers, _harm(ground, numbers, step), ground.labels):
        seen = jumps[group.rows, group.columns]
        kind = "jump" if np.count_nonzero(seen) * 2 > seen.size else "surfaces"
        yield Place(kind, group.box, (group.label,), group.point, group.harm, _reason(ground, group, kind, step))


def _harm(ground: Ground, numbers: NDArray[np.int32], step: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of every group: what is to be filled around it, times the step [m] at the nearest of its pixels."""
    away, nearest = cv2.distanceTransformWithLabels(
        (numbers == 0).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    at = np.zeros(int(nearest.max()) + 1, np.int64)
    on = numbers > 0
    at[nearest[on]] = np.flatnonzero(on)
    reached = at[nearest[away < _REACH]]
    labels = ground.labels
    counts = (labels[away < _REACH] == labels.ravel()[reached]) * np.where(ground.missing[away < _REACH], 1.0, _KNOWN)
    faded = 1 - away[away < _REACH] / _REACH
    weights = counts * faded * step.ravel()[reached]
    harm = np.bincount(numbers.ravel()[reached], weights, minlength=int(numbers.max()) + 1)
    return np.asarray(harm, np.float64)


def _jumps(ground: Ground) -> NDArray[np.float64]:
    """Height [m] of the jumps in known depth inside blocks, 0 elsewhere."""
    height, width = ground.labels.shape
    found = np.zeros((height, width))
    jumps = ground.relief.jumps
    inner = long_lines((jumps[0] & ground.inner[:, :-1], jumps[1] & ground.inner[:-1]), JUMP_LENGTH)
    for side, (dy, dx) in enumerate(((0, 1), (1, 0))):
        rows, columns = np.nonzero(inner[side])
        one = (
            np.clip(rows - _BESIDE * dy, 0, height - 1),
            np.clip(columns - _BESIDE * dx, 0, width - 1),
        )
        other = (
            np.clip(rows + (1 + _BESIDE) * dy, 0, height - 1),
            np.clip(columns + (1 + _BESIDE) * dx, 0, width - 1),
        )
        step = np.abs(ground.depth[one].astype(np.float64) - ground.depth[other])
        found[rows, columns] = np.maximum(found[rows, columns], step)
    return found


def _hidden(ground: Ground, strength: NDArray[np.float32]) -> NDArray[np.float64]:
    """How far apart [m] the surfaces are that meet in missing depth inside a block, 0 elsewhere; less where it is in
    doubt that they do."""
    found = np.zeros(ground.labels.shape)
    pieces = ground.pieces.ravel()
    width = ground.labels.shape[1]
    square = np.ones((2 * _AROUND + 1,) * 2, np.uint8)
    edge = cv2.dilate(np.where(ground.inner, strength, np.float32(0)), square)
    seen = _UNSEEN + (1 - _UNSEEN) * np.minimum(edge / _FOUND, 1.0)
    for side, (one, other) in enumerate(sides(ground.source)):
        rows, columns = np.nonzero(_inside(ground)[side] & (one != other) & (one >= 0) & (other >= 0))
        near, far = one[rows, columns], other[rows, columns]
        parted = pieces[near] != pieces[far]
        rows, columns, near, far = rows[parted], columns[parted], near[parted], far[parted]
        gap = np.hypot(near // width - far // width, near % width - far % width)
        by = ground.apart(near, far) * seen[rows, columns] / (1 + (gap / _FAR) ** 2)
        found[rows, columns] = np.maximum(found[rows, columns], by)
    # what known depth says for itself is a jump or none
    return np.where(ground.missing, found, 0.0)


def _inside(ground: Ground) -> Pairs:
    right, below = apart(ground.labels)
    return ~right & (ground.labels[:, 1:] > 0), ~below & (ground.labels[1:] > 0)


def _reason(ground: Ground, group: Group, kind: str, step: NDArray[np.float64]) -> str:
    if kind == "jump":
        height = float(np.median(step[group.rows, group.columns]))
        return f"Depth jumps by {height:.2f} m inside Block {group.label}."
    near, far = _beside(ground, group)
    return f"Block {group.label} holds two surfaces, {near:.2f} m and {far:.2f} m."


def _beside(ground: Ground, group: Group) -> tuple[float, float]:
    """Depth [m] of the nearer and of the farther surface along a fault that lies hidden."""
    height, width = ground.labels.shape
    corners = []
    for down, right in ((0, 0), (0, 1), (1, 0)):
        rows, columns = np.minimum(group.rows + down, height - 1), np.minimum(group.columns + right, width - 1)
        depth = ground.depth.ravel()[ground.source[rows, columns]]
        corners.append(np.where(ground.labels[rows, columns] == group.label, depth, np.nan))
    return float(np.median(np.nanmin(corners, axis=0))), float(np.median(np.nanmax(corners, axis=0)))
