"""Pictures of depth and of point clouds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame

_MISSING = np.array([38, 38, 42], np.uint8)
_EMPTY = np.array([250, 250, 250], np.uint8)

_YAW, _PITCH = math.radians(22), math.radians(14)
"""How far the cloud is turned, so that its shape shows."""

_FITTED = 0.85
"""Share of the picture that the known depth takes."""

_NEAR_SHARE, _FAR_SHARE = 2.0, 98.0
"""Percentiles of the depth between which colours spread."""


def depth_range(depth: NDArray[np.floating]) -> tuple[float, float]:
    """Depth [m] between which colours spread."""
    near, far = np.nanpercentile(depth, [_NEAR_SHARE, _FAR_SHARE])
    return float(near), float(max(far, near + 1e-3))


def depth_picture(depth: NDArray[np.floating], between: tuple[float, float]) -> NDArray[np.uint8]:
    """Depth in colours, uint8 (H, W, 3); missing is nearly black."""
    import matplotlib

    share = (depth - between[0]) / (between[1] - between[0])
    colours = matplotlib.colormaps["viridis_r"](np.nan_to_num(np.clip(share, 0, 1)), bytes=True)[..., :3]
    return np.where(np.isfinite(depth)[..., None], colours, _MISSING)


def thumbnail(picture: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """A picture at most so wide, every so many pixels taken: depth colours must not be mixed."""
    step = max(1, math.ceil(picture.shape[1] / width))
    return np.ascontiguousarray(picture[::step, ::step])


def cloud_picture(frame: RGBDFrame, depth: NDArray[np.floating], focal: float, width: int) -> NDArray[np.uint8]:
    """The cloud of a depth image, seen in parallel from the side and above, nearest points in front.

    Parameters
    ----------
    frame : RGBDFrame
        Gives the colours; the view fits its known depth, whatever depth is shown.
    depth : ndarray of float, shape (H, W)
        [m], NaN = missing.
    focal : float
        Focal length [px].
    width : int
        Of the picture [px].
    """
    height = round(width * frame.shape[0] / frame.shape[1])
    given, _ = _turned(frame.depth, focal)
    low, high = np.percentile(given[:, :2], [_NEAR_SHARE, _FAR_SHARE], axis=0)
    scale = _FITTED * min(width / (high[0] - low[0]), height / (high[1] - low[1]))
    points, places = _turned(depth, focal)
    u, v = np.round((points[:, :2] - (low + high) / 2) * scale + (np.array([width, height]) - 1) / 2).astype(int).T
    seen = np.flatnonzero((u >= 0) & (u < width) & (v >= 0) & (v < height))
    seen = seen[np.argsort(-points[seen, 2], kind="stable")]
    picture = np.broadcast_to(_EMPTY, (height, width, 3)).copy()
    picture[v[seen], u[seen]] = frame.rgb.reshape(-1, 3)[places[seen]]
    return picture


def _turned(depth: NDArray[np.floating], focal: float) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The points of a depth image, turned so that its shape shows (N, 3) [m], and their places in it (N,)."""
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns].astype(np.float64)
    x = (columns - (depth.shape[1] - 1) / 2) / focal * z
    y = (rows - (depth.shape[0] - 1) / 2) / focal * z
    x, z = math.cos(_YAW) * x + math.sin(_YAW) * z, math.cos(_YAW) * z - math.sin(_YAW) * x
    y, z = math.cos(_PITCH) * y + math.sin(_PITCH) * z, math.cos(_PITCH) * z - math.sin(_PITCH) * y
    return np.stack([x, y, z], axis=1), rows * depth.shape[1] + columns
