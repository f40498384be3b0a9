"""Deliberate faults in blocks, where missing depth depends on them and ground truth shows an effect."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.frame import RGBDFrame
from ilf.data.pixel_grids import different_labels, mark
from ilf.segmentation.edges.frame_edges import find_relief

Labels = NDArray[np.int32]
Mask = NDArray[np.bool_]

KINDS = ("merge", "move", "island", "swallow")
"""Kinds of fault: two blocks merged; a stretch of border moved by 6 to 20 px; a piece from the middle of a block given
to another; a part beyond a border added."""

APART, APART_SHARE = 0.1, 0.05
"""Borders count where the true depths on their sides differ by more than the larger of the two [m, share]."""

MIN_AFFECTED = 50
"""Minimum number of missing pixels that a fault affects."""

ZONE = 12
"""Maximum distance [px] of a flagged place from its fault."""

_TRIES = 300


@dataclass(frozen=True, eq=False)
class Fault:
    """One fault: its kind, the pixels where a flagged place counts as found, and the blocks before and after it."""

    kind: str
    zone: Mask
    before: Labels
    after: Labels

    def overlap(self, spoilt: Labels, blocks: Labels) -> float:
        """Mean IoU of blocks with those that the fault has changed, as they were before it; NaN if nothing of it is
        left.

        Parameters
        ----------
        spoilt : ndarray of int32, shape (H, W)
            The label map with this and other faults, which do not count.
        blocks : ndarray of int32, shape (H, W)
            The blocks to evaluate: for each block before the fault, the one with the largest IoU.
        """
        changed = (self.before != self.after) & (spoilt == self.after)
        right = np.where(changed, self.before, spoilt)
        there = {*self.before[changed].tolist(), *self.after[changed].tolist()} & set(np.unique(right).tolist()) - {0}
        return float(np.mean([_best_iou(right == label, blocks) for label in there])) if there else float("nan")


def _best_iou(block: Mask, blocks: Labels) -> float:
    shared = np.bincount(blocks[block], minlength=int(blocks.max()) + 1)
    return float(np.max(shared / (np.count_nonzero(block) + np.bincount(blocks.ravel()) - shared + 1e-9)))


def with_holes(ground_truth: RGBDFrame, rng: np.random.Generator, areas: int = 25, shadow: int = 8) -> RGBDFrame:
    """Return the frame with missing depth as from a sensor: in patches, and in shadows on the far side of jumps.

    Parameters
    ----------
    ground_truth : RGBDFrame
        Frame without missing depth.
    rng : Generator
    areas : int
        Number of elliptic patches.
    shadow : int
        Maximum width of the shadows [px]; that of each band of rows is random.
    """
    depth = ground_truth.depth.copy()
    height, width = depth.shape
    for _ in range(areas):
        centre = int(rng.integers(width)), int(rng.integers(height))
        axes = tuple(int(axis) for axis in rng.uniform(0.015, 0.08, 2) * width)
        cv2.ellipse(depth, centre, axes, float(rng.uniform(0, 180)), 0, 360, float("nan"), -1)
    right, _ = find_relief(ground_truth.depth, APART, APART_SHARE).jumps
    rows, columns = np.nonzero(right)
    widths = rng.integers(1, shadow + 1, height // 16 + 1)[rows // 16]
    far_right = ground_truth.depth[rows, columns + 1] > ground_truth.depth[rows, columns]
    for step in range(shadow):
        here = widths > step
        beside = np.where(far_right, columns + 1 + step, columns - step)
        depth[rows[here], np.clip(beside[here], 0, width - 1)] = np.nan
    return RGBDFrame(ground_truth.rgb, depth, ground_truth.intrinsics, ground_truth.name)


def make_faults(
    labels: Labels, ground_truth: NDArray[np.float32], missing: Mask, kinds: list[str], rng: np.random.Generator
) -> tuple[Labels, list[Fault]]:
    """Return a label map with one fault of each of `kinds`, apart from each other; those without a place are skipped.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Correct blocks.
    ground_truth : ndarray of float32, shape (H, W)
        True depth [m].
    missing : ndarray of bool, shape (H, W)
        Missing pixels.
    kinds : list of str
        Of `KINDS`.
    rng : Generator
    """
    spoilt, faults = labels.copy(), list[Fault]()
    taken = np.zeros(labels.shape, bool)
    for kind in kinds:
        for _ in range(_TRIES):
            tried = _SPOILERS[kind](spoilt, ground_truth, rng)
            if tried is None:
                continue
            after, harmed = tried
            zone = widened(harmed, ZONE)
            if np.count_nonzero(missing & harmed) >= MIN_AFFECTED and not (zone & taken).any():
                faults.append(Fault(kind, zone, spoilt, after))
                spoilt, taken = after, taken | zone
                break
    return spoilt, faults


def widened(mask: Mask, radius: float) -> Mask:
    """Return pixels within a distance of a mask."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5) <= radius)


def _merge(labels: Labels, ground_truth: NDArray[np.float32], rng: np.random.Generator) -> tuple[Labels, Mask] | None:
    border = _border(labels, ground_truth, rng)
    if border is None:
        return None
    one, other, line = border
    return np.where(labels == other, one, labels).astype(np.int32), widened(line, 6) & np.isin(labels, (one, other))


def _move(labels: Labels, ground_truth: NDArray[np.float32], rng: np.random.Generator) -> tuple[Labels, Mask] | None:
    border = _border(labels, ground_truth, rng)
    if border is None:
        return None
    one, other, line = border
    rows, columns = np.nonzero(line)
    pick = int(rng.integers(rows.size))
    away = np.hypot(rows - rows[pick], columns - columns[pick])
    near = away < rng.uniform(20, 60)
    stretch = np.zeros_like(line)
    stretch[rows[near], columns[near]] = True
    swept = widened(stretch, rng.uniform(6, 20)) & (labels == other)
    return np.where(swept, one, labels).astype(np.int32), swept


def _island(labels: Labels, ground_truth: NDArray[np.float32], rng: np.random.Generator) -> tuple[Labels, Mask] | None:
    row, column = (int(rng.integers(size)) for size in labels.shape)
    piece = np.zeros(labels.shape, np.uint8)
    axes = tuple(int(axis) for axis in rng.uniform(6, 20, 2))
    cv2.ellipse(piece, (column, row), axes, float(rng.uniform(0, 180)), 0, 360, 1, -1)
    home = int(labels[row, column])
    if home == 0 or (labels[widened(piece > 0, 3)] != home).any():
        return None
    others = np.setdiff1d(labels, (0, home))
    new = int(labels.max()) + 1
    label = new if rng.random() < 0.5 or not others.size else int(rng.choice(others))
    return np.where(piece > 0, label, labels).astype(np.int32), piece > 0


def _swallow(labels: Labels, ground_truth: NDArray[np.float32], rng: np.random.Generator) -> tuple[Labels, Mask] | None:
    border = _border(labels, ground_truth, rng)
    if border is None:
        return None
    one, other, line = border
    rows, columns = np.nonzero(line)
    pick = int(rng.integers(rows.size))
    y, x = np.indices(labels.shape)
    radius = rng.uniform(25, 70)
    near = (labels == other) & (np.hypot(y - rows[pick], x - columns[pick]) < radius)
    if np.count_nonzero(near) > 0.5 * np.count_nonzero(labels == other):
        return None
    return np.where(near, one, labels).astype(np.int32), near


def _border(
    labels: Labels, ground_truth: NDArray[np.float32], rng: np.random.Generator
) -> tuple[int, int, Mask] | None:
    """Return two neighbouring blocks, and the part of their border along which true depth jumps: 40 px or more."""
    height, width = labels.shape
    lines = mark(different_labels(labels)) & (labels > 0)
    rows, columns = np.nonzero(lines)
    pick = int(rng.integers(rows.size))
    row, column = rows[pick], columns[pick]
    beyond = [labels[min(row + 1, height - 1), column], labels[row, min(column + 1, width - 1)]]
    pair = [int(label) for label in beyond if label not in (0, labels[row, column])]
    if not pair:
        return None
    one, other = (int(label) for label in rng.permutation([int(labels[row, column]), pair[0]]))
    near_one, near_other = widened(labels == one, 1.5), widened(labels == other, 1.5)
    line = near_one & near_other & np.isin(labels, (one, other))
    # true depth a few pixels inside each of the two
    lower, upper = (
        cv2.erode(np.where(np.isin(labels, (one, other)), ground_truth, np.inf).astype(np.float32), np.ones((7, 7))),
        cv2.dilate(np.where(np.isin(labels, (one, other)), ground_truth, 0).astype(np.float32), np.ones((7, 7))),
    )
    line &= upper - lower > np.maximum(APART, APART_SHARE * lower)
    return (one, other, line) if np.count_nonzero(line) >= 80 else None


_SPOILERS = {"merge": _merge, "move": _move, "island": _island, "swallow": _swallow}
