"""Sources by a known motion of the camera: points of the one frame seen from where the other was taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...camera import CameraIntrinsics
from ...frame import RGBDFrame
from .sources import Field, Mask, Sources, nearest

Pose = NDArray[np.float64]

_JUMP, _JUMP_SHARE = 0.05, 0.04
"""How far [m] a point's depth may be off what was measured there before, and the same as a share of the depth: the
larger of the two."""


def by_pose(before: RGBDFrame, after: RGBDFrame, pose: Pose, otherwise: Sources) -> Sources:
    """Known depth after leads to the pixel before; where it is missing, known depth before leads to the pixel after.

    Parameters
    ----------
    before, after : RGBDFrame
        Both with intrinsics.
    pose : ndarray of float64, shape (4, 4)
        Takes points [m] from the camera's place before to that after.
    otherwise : Sources
        For pixels that no depth leads to.
    """
    assert before.intrinsics is not None
    assert after.intrinsics is not None
    columns, rows, depth = _seen_from(after, np.linalg.inv(pose).astype(np.float64), before.intrinsics)
    row, column, inside = nearest(columns, rows)
    measured = before.depth[row, column]
    with np.errstate(invalid="ignore"):
        off = depth - measured
        allowed = np.maximum(_JUMP, _JUMP_SHARE * depth)
        # what was nearer than the point hid it; what was farther cannot have been there
        other = np.abs(off) > allowed
    known = after.known & np.isfinite(depth)
    from_before, reached = _splat(before, pose, after.intrinsics)
    rows_before, columns_before = np.divmod(from_before, before.shape[1])
    taken = ~known & reached
    use = known | taken
    row = np.where(taken, rows_before, np.where(known, row, otherwise.rows))
    column = np.where(taken, columns_before, np.where(known, column, otherwise.columns))
    seen = np.where(known, inside & ~other, taken | otherwise.seen)
    sure = np.where(use, seen & (taken | np.isfinite(measured) | otherwise.sure), otherwise.sure)
    return Sources(row, column, seen, sure & seen, otherwise.still & ~use)


def _seen_from(frame: RGBDFrame, motion: Pose, camera: CameraIntrinsics) -> tuple[Field, Field, Field]:
    """Columns, rows and depth [m] of all pixels as another camera sees them; NaN without depth or behind it."""
    assert frame.intrinsics is not None
    rows, columns = np.indices(frame.shape)
    points = frame.intrinsics.points(columns, rows, frame.depth) @ motion[:3, :3].T + motion[:3, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        depth = np.where(points[..., 2] > 1e-3, points[..., 2], np.nan)
        x = camera.fx * points[..., 0] / depth + camera.cx
        y = camera.fy * points[..., 1] / depth + camera.cy
    return x.astype(np.float32), y.astype(np.float32), depth.astype(np.float32)


def _splat(frame: RGBDFrame, motion: Pose, camera: CameraIntrinsics) -> tuple[NDArray[np.intp], Mask]:
    """For every pixel of the other camera the nearest of the points that fall on it or beside it, as an index into the
    frame's pixels, and where there is one."""
    height, width = frame.shape
    x, y, depth = _seen_from(frame, motion, camera)
    here = np.flatnonzero(np.isfinite(depth))
    far_first = here[np.argsort(-depth.ravel()[here], kind="stable")]
    row, column, inside = nearest(x.ravel()[far_first], y.ravel()[far_first])
    index = np.full((height, width), -1, np.intp)
    # the last of those that fall on a pixel stays: the nearest
    index[row[inside], column[inside]] = far_first[inside]
    return np.maximum(index, 0), index >= 0
