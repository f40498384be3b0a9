"""Motion by a known pose: points of the one frame seen from where the other was taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from .sources import Field, Mask, Motion
from .stillness import in_cells

Pose = NDArray[np.float64]

_LEAST_MOTION = 8.0
"""Motions that are smaller [px] are not told from errors of the flow."""

_LEAST_CELLS = 16
"""Of 64: the flow along a single edge tells nothing."""


def by_pose(before: RGBDFrame, after: RGBDFrame, pose: Pose, depth: Field, flow: Motion) -> Motion:
    """Where points with depth are seen after the camera has moved; what has none goes with the flow.

    Parameters
    ----------
    before, after : RGBDFrame
        Both with intrinsics.
    pose : ndarray of float64, shape (4, 4)
        Takes points [m] of the camera before to the camera after.
    depth : ndarray of float32, shape (H, W)
        Of the parts before [m], NaN where it is not known.
    flow : Motion
        For pixels without depth.
    """
    assert before.intrinsics is not None
    assert after.intrinsics is not None
    rows, columns = np.indices(before.shape)
    points = before.intrinsics.points(columns, rows, depth) @ pose[:3, :3].T + pose[:3, 3]
    camera = after.intrinsics
    with np.errstate(invalid="ignore", divide="ignore"):
        z = np.where(points[..., 2] > 1e-3, points[..., 2], np.nan)
        x = camera.fx * points[..., 0] / z + camera.cx
        y = camera.fy * points[..., 1] / z + camera.cy
    known = np.isfinite(depth)
    return Motion(
        np.where(known, x, flow.columns).astype(np.float32),
        np.where(known, y, flow.rows).astype(np.float32),
        z.astype(np.float32),
        np.where(known, np.isfinite(z), flow.sure),
    )


def off_flow(motion: Motion, flow: Field, told: Mask) -> float:
    """How far motion by a pose is off the flow, as a share of the flow's length: the median of cells of the picture.

    Parameters
    ----------
    motion : Motion
    flow : ndarray of float32, shape (H, W, 2)
        Offsets x, y [px].
    told : ndarray of bool, shape (H, W)
        Where it can be relied on. If that is in few cells, nothing is told, and the result is 0.
    """
    rows, columns = np.indices(told.shape)
    off = np.hypot(motion.columns - columns - flow[..., 0], motion.rows - rows - flow[..., 1])
    share = off / np.maximum(np.hypot(flow[..., 0], flow[..., 1]), _LEAST_MOTION)
    shares = [float(np.median(cell)) for cell in in_cells(share, told & ~np.isnan(off))]
    return float(np.median(shares)) if len(shares) >= _LEAST_CELLS else 0.0
