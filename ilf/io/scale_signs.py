"""Signs that a depth file holds another unit than it is read in, or no depth: names, sizes, steps and slopes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .depth_files import UINT16_MAX
from .encodings import ENCODINGS

_REPLICA_SHAPE = 680, 1200
_REPLICA_NAME = re.compile(r"depth\d{6}\.png")
_KITTI_NAME = re.compile(r"kitti.*|velodyne_raw|groundtruth_depth|proj_depth", re.IGNORECASE)
_KITTI_ASPECT = 3.0
"""Width over height that no depth camera has."""

_NEAR_FOLDERS = 4
"""Names at the end of a path, with the file's own, that a data set gives."""

_MOST_FEW = 20
"""Pixels of a value that may be noise."""

_FEWEST_GAPS = 20
_DISPARITY_STEPS = 270.0, 700.0
"""[1/m]; steps of depth are depth squared over this: 345 for a Kinect v1, about 600 for a RealSense D400."""

_RISES = 0.5
"""Correlation of rows and depth; it is negative for nearly all frames, since the floor comes nearer downwards."""

_NEAR, _NEARLY, _FAR = 0.5, 1.0, 6.0
"""Median depth [m] of hardly any frame; of few; and beyond which there are few again."""

_GRID = 320
"""Pixels of the longer side that are looked at."""

_LEVEL, _STEEP = 0.005, 0.2
"""What still counts as straight, and what no longer as level, relative to the value."""


def data_set_of(values: NDArray[Any], units: float, path: Path | None, is_unusual: bool) -> tuple[str, str] | None:
    """The encoding of the data set that integers (H, W) seem to be of by their size and the names of the file and its
    folders, and the sign of it. `is_unusual` is whether the scale that they are read in is."""
    if values.dtype != np.uint16 or units != 1000:
        return None
    height, width = values.shape
    folders = () if path is None else path.parts[-_NEAR_FOLDERS:]
    if width >= _KITTI_ASPECT * height or any(map(_KITTI_NAME.fullmatch, folders)):
        return "kitti", "Size or names are those of KITTI"
    is_named = path is not None and _REPLICA_NAME.fullmatch(path.name) is not None
    if is_unusual and (
        is_named or values.shape == _REPLICA_SHAPE or any(folder.lower().startswith("replica") for folder in folders)
    ):
        return "replica", "Size or names are those of Replica"
    return None


def sensor_scale(values: NDArray[Any], units: float) -> tuple[str, str] | None:
    """The encoding by which integers, of the disparity steps of a depth camera, would have steps as such cameras have,
    and the sign of it; None if they have them as they are read, or show no such steps."""
    if values.dtype != np.uint16:
        return None
    counts = np.bincount(values.ravel(), minlength=UINT16_MAX + 1)
    counts[[0, UINT16_MAX]] = 0
    levels = np.flatnonzero(counts >= _MOST_FEW)
    gaps = np.diff(levels)
    is_gap = gaps >= 3  # smaller ones are rounded too coarsely
    if np.count_nonzero(is_gap) < max(_FEWEST_GAPS, 0.2 * gaps.size):
        return None
    low, steps, high = np.quantile(levels[1:][is_gap] ** 2 / gaps[is_gap] / units, (0.2, 0.5, 0.8))
    if high > 1.6 * low or steps >= _DISPARITY_STEPS[0]:
        return None
    for name, other in ENCODINGS.items():
        if other.name is None and _DISPARITY_STEPS[0] <= steps * units / other.units <= _DISPARITY_STEPS[1]:
            return name, "Depth has steps that are too coarse for a depth camera so near"
    return None


def is_inverse(metres: NDArray[np.float32]) -> bool:
    """Whether values (H, W), NaN = missing, that are read as depth [m] seem to be disparity or inverse depth: they rise
    downwards, and their median is one of hardly any depth, or planes are straight in them."""
    median = float(np.nanmedian(metres))
    if _NEARLY <= median <= _FAR:
        return False
    step = -(-max(metres.shape) // _GRID)
    grid = metres[::step, ::step].astype(np.float64)
    rows = np.flatnonzero(np.isfinite(grid).any(axis=1))
    if rows.size < 8:
        return False
    depth = np.nanmedian(grid[rows], axis=1)
    if np.ptp(depth) == 0 or np.corrcoef(rows, depth)[0, 1] < _RISES:
        return False
    return median < _NEAR or median > _FAR or _has_straight_planes(grid)


def _has_straight_planes(grid: NDArray[np.float64]) -> bool:
    """Whether slopes are straight in the values rather than in their inverse: planes are straight in inverse depth."""
    straight = slopes = 0
    for lines in (grid, grid.T):
        half = max(lines.shape[0] // 32, 1)
        one, two, mid, three, four = (lines[i * half : lines.shape[0] - (4 - i) * half] for i in range(5))
        with np.errstate(invalid="ignore"):
            bends = [
                np.max([abs((a + c) / (2 * b) - 1) for a, b, c in triples], axis=0)
                for triples in (
                    ((one, mid, four), (one, two, mid), (mid, three, four)),
                    ((1 / one, 1 / mid, 1 / four), (1 / one, 1 / two, 1 / mid), (1 / mid, 1 / three, 1 / four)),
                )
            ]
            counts = (np.minimum(*bends) < _LEVEL) & (abs(four - one) > _STEEP * mid)
        slopes += int(np.count_nonzero(counts))
        straight += int(np.count_nonzero(counts & (bends[0] < bends[1])))
    return slopes >= 0.0005 * grid.size and straight > 0.6 * slopes
