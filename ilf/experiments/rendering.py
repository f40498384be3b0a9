"""Pictures of depth and of point clouds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..cloud import point_cloud
from ..drawing.orbit import OrbitCamera
from ..drawing.splat import Look, splat
from ..frame import CameraIntrinsics, RGBDFrame

_MISSING = np.array([38, 38, 42], np.uint8)
_EMPTY = (250, 250, 250)

_YAW, _PITCH = math.radians(22), math.radians(14)
"""How far the cloud is turned, so that its shape shows."""

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
    """The cloud of a depth image, seen from the side and above, nearest points in front.

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
    rows, columns = frame.shape
    lens = CameraIntrinsics(focal, focal, (columns - 1) / 2, (rows - 1) / 2)
    given = point_cloud(frame.depth, frame.rgb, lens)
    camera = OrbitCamera(yaw=-_YAW, pitch=_PITCH).fitted(given.points, width / height)
    cloud = point_cloud(depth, frame.rgb, lens)
    return splat(cloud.points, cloud.colours, Look(camera, width, height, _EMPTY)).picture
