"""Point cloud to picture in numpy: an orbit camera, a z-buffer splat and eye-dome lighting. No Qt, no OpenGL."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

MAX_POINT_SIZE = 12
"""Largest side of a point [px]; automatic sizes stop here when zoomed far in."""

NEAR = 0.01
"""Points nearer to the eye than this [m] are not drawn."""

_CHUNK = 1 << 15  # points at a time, so that the intermediate arrays stay in the cache
_SAMPLE = 20_000  # points that are enough to judge a cloud's extent and density
_EMPTY = np.uint64(0xFFFF_FFFF_FFFF_FFFF)
_INDEX = np.uint64(0xFFFF_FFFF)
_OVERLAP = 1.6  # automatic points are this much wider than their spacing, or slanted surfaces show slits
_EDL_STRENGTH = 12.0
_DISTANCES = (0.02, 1e4)


@dataclass(frozen=True)
class OrbitCamera:
    """A camera that orbits a target. Axes as in the cloud: x right, y down, z forward.

    Parameters
    ----------
    target : tuple of float
        Point that is looked at, (x, y, z) [m].
    distance : float
        From the eye to the target [m].
    yaw, pitch : float
        Direction of view [rad]; 0, 0 looks along +z as the depth camera did, a positive pitch looks down.
    fov : float
        Vertical angle of view [rad].
    """

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance: float = 3.0
    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = math.radians(45)

    def orbit(self, yaw: float, pitch: float) -> OrbitCamera:
        """Turned about the target by two angles [rad]; the pitch stops straight above and below."""
        turned = math.remainder(self.yaw + yaw, math.tau)
        return replace(self, yaw=turned, pitch=min(max(self.pitch + pitch, -math.pi / 2), math.pi / 2))

    def pan(self, right: float, down: float) -> OrbitCamera:
        """Moved with its target along the picture's axes [m]."""
        x_axis, y_axis, _ = self.rotation()
        x, y, z = (np.asarray(self.target) + right * x_axis + down * y_axis).tolist()
        return replace(self, target=(x, y, z))

    def dolly(self, factor: float) -> OrbitCamera:
        """Nearer (factor < 1) or farther (factor > 1), within 0.02 m to 10 km."""
        return replace(self, distance=min(max(self.distance * factor, _DISTANCES[0]), _DISTANCES[1]))

    def rotation(self) -> NDArray[np.float64]:
        """Rows: the picture's right, down and forward axes in cloud coordinates, float64 (3, 3)."""
        cos_y, sin_y, cos_p, sin_p = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array(
            [
                [cos_y, 0.0, -sin_y],
                [-sin_p * sin_y, cos_p, -sin_p * cos_y],
                [cos_p * sin_y, sin_p, cos_p * cos_y],
            ]
        )

    def view_matrix(self) -> NDArray[np.float64]:
        """Homogeneous matrix from cloud to eye coordinates, float64 (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = -matrix[:3, :3] @ np.asarray(self.target)
        matrix[2, 3] += self.distance
        return matrix

    def focal(self, height: int) -> float:
        """Focal length [px] in a picture of that height."""
        return 0.5 * height / math.tan(0.5 * self.fov)

    def fitted(self, points: NDArray[np.float32], aspect: float) -> OrbitCamera:
        """Same direction, but aimed at the middle of a cloud and far enough away to see nearly all of it.

        Parameters
        ----------
        points : ndarray
            float32 (N, 3) [m]. The outermost points do not count: stray ones would make the rest tiny.
        aspect : float
            Width of the picture over its height.
        """
        sample = _sample(points).astype(np.float64)
        if not len(sample):
            return self
        centre = np.median(sample, axis=0)
        x, y, z = self.rotation() @ (sample - centre).T
        half = math.tan(0.5 * self.fov)
        middle = np.zeros(2)
        for _ in range(4):  # the middle of the picture depends on the distance, and the other way round
            across, along = np.abs(x - middle[0]) / aspect, np.abs(y - middle[1])
            distance = max(float(np.percentile(np.maximum(across, along) / half - z, 99.5)), 2 * NEAR - float(z.min()))
            edges = np.percentile(np.stack([x - middle[0], y - middle[1]]) / (z + distance), (0.5, 99.5), axis=1)
            middle += edges.mean(axis=0) * distance
        aimed = replace(self, target=tuple(centre.tolist()), distance=1.0)
        return aimed.pan(*middle.tolist()).dolly(1.08 * distance)


def splat(
    points: NDArray[np.float32],
    colours: NDArray[np.uint8],
    camera: OrbitCamera,
    width: int,
    height: int,
    background: tuple[int, int, int] = (0, 0, 0),
    point_size: int | None = None,
    *,
    shaded: bool = True,
) -> NDArray[np.uint8]:
    """Picture of a point cloud: every point a square, the nearest wins.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m], x right, y down, z forward. Points that are not finite are not drawn.
    colours : ndarray
        uint8 (N, 3), red first.
    camera : OrbitCamera
        Where to look from.
    width, height : int
        Size of the picture [px].
    background : tuple of int
        Red, green, blue where no point falls.
    point_size : int, optional
        Side of a point [px], 1 to `MAX_POINT_SIZE`. None: each point is as wide as its distance to its
        neighbours appears, taking the cloud as seen by a depth camera at the origin.
    shaded : bool
        Eye-dome lighting: darken what lies behind its neighbourhood.

    Returns
    -------
    ndarray
        uint8 (height, width, 3).
    """
    if point_size is None:
        gain = _size_gain(points, camera, height)
        smallest, largest = _size_range(points, camera, gain)
    else:
        gain = 0.0
        smallest = largest = min(max(int(point_size), 1), MAX_POINT_SIZE)
    keys = _nearest(points, camera, width, height, gain, smallest, largest)
    seen = keys != _EMPTY
    nearest = (keys & _INDEX).astype(np.intp)
    picture = np.empty((height, width, 3), np.uint8)
    picture[:] = background
    if not len(points):
        return picture
    nearest[~seen] = 0
    found = np.take(colours, nearest, axis=0)
    if shaded:
        depth = (keys >> np.uint64(32)).astype(np.uint32).view(np.float32)
        depth[~seen] = np.inf
        found = _eye_dome(found, depth, radius=max(1, round(height / 600)))
    np.copyto(picture, found, where=seen[..., None])
    return picture


def _nearest(
    points: NDArray[np.float32],
    camera: OrbitCamera,
    width: int,
    height: int,
    gain: float,
    smallest: int,
    largest: int,
) -> NDArray[np.uint64]:
    """For each pixel the key (depth bits << 32 | index) of the nearest point that covers it, or _EMPTY.

    The bits of positive floats sort like the floats, so the smallest key is the nearest point. Points go as single
    pixels into one layer per size; a layer is then widened by a pixel and joined with the next smaller one.
    That gives the same picture as filling every square, at a cost that does not depend on the number of points.
    """
    margin = largest  # squares of points just outside reach into the picture
    columns, rows = width + 2 * margin, height + 2 * margin
    layers = np.full((largest - smallest + 1, rows, columns), _EMPTY)
    flat = layers.reshape(-1)
    matrix = camera.view_matrix().astype(np.float32)
    rotation, shift = np.ascontiguousarray(matrix[:3, :3]), matrix[:3, 3:]
    focal = np.float32(camera.focal(height))
    centre_x, centre_y = np.float32(columns / 2), np.float32(rows / 2)
    with np.errstate(all="ignore"):
        for start in range(0, len(points), _CHUNK):
            chunk = points[start : start + _CHUNK]
            eye = rotation @ chunk.T
            eye += shift
            z = eye[2]
            scale = focal / z
            u = eye[0] * scale + centre_x
            v = eye[1] * scale + centre_y
            inside = (z > NEAR) & (z < np.inf) & (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
            kept = np.flatnonzero(inside)
            if not len(kept):
                continue
            z = z[kept]
            pixel = v[kept].astype(np.intp)
            pixel *= columns
            pixel += u[kept].astype(np.intp)
            if largest > smallest:
                size = np.ceil(gain * chunk[kept, 2] / z).clip(smallest, largest)
                pixel += (size.astype(np.intp) - smallest) * (rows * columns)
            key = z.view(np.uint32).astype(np.uint64)
            key <<= np.uint64(32)
            key |= (kept + start).astype(np.uint64)
            np.minimum.at(flat, pixel, key)
    merged = layers[-1]
    for size in range(largest, 1, -1):
        _widen(merged, forward=size % 2 == 0)
        if size > smallest:
            np.minimum(merged, layers[size - 1 - smallest], out=merged)
    return merged[margin : margin + height, margin : margin + width]


def _widen(keys: NDArray[np.uint64], forward: bool) -> None:
    """Widen every square by one pixel in both axes, in place: to the right and down, or to the left and up."""
    for axis in (keys, keys.T):
        np.minimum(axis[:-1], axis[1:], out=axis[1:] if forward else axis[:-1])


def _size_gain(points: NDArray[np.float32], camera: OrbitCamera, height: int) -> float:
    """Size [px] of a point per ratio of its depth in the cloud to its depth in the view.

    A depth camera samples equal angles, so neighbours at depth z lie k z apart. k is found from the solid
    angle that the cloud fills and the number of its points.
    """
    sample = _sample(points)
    sample = sample[sample[:, 2] > NEAR]
    if len(sample) < 16:
        return 0.0
    angles = sample[:, :2] / sample[:, 2:]
    low, high = np.percentile(angles, (1, 99), axis=0)
    extent = np.maximum(high - low, 1e-6)
    cells = max(2, int(math.sqrt(len(sample) / 8)))
    inside = ((angles >= low) & (angles <= high)).all(axis=1)
    index = np.minimum(((angles[inside] - low) / extent * cells).astype(np.intp), cells - 1)
    filled = np.count_nonzero(np.bincount(index[:, 0] * cells + index[:, 1]))
    area = filled * float(np.prod(extent)) / cells**2
    count = len(points) * np.count_nonzero(inside) / len(sample)
    return _OVERLAP * camera.focal(height) * math.sqrt(area / max(count, 1.0))


def _size_range(points: NDArray[np.float32], camera: OrbitCamera, gain: float) -> tuple[int, int]:
    """Smallest and largest automatic size [px] that the view needs."""
    sample = _sample(points)
    forward = camera.view_matrix()[2]
    depth = sample @ forward[:3].astype(np.float32) + np.float32(forward[3])
    visible = (depth > NEAR) & (sample[:, 2] > NEAR)
    if gain == 0.0 or not visible.any():
        return 1, 1
    ratio = gain * np.percentile(sample[visible, 2] / depth[visible], (1, 99))
    low, high = np.ceil(ratio).clip(1, MAX_POINT_SIZE)
    return int(low), int(high)


def _sample(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """The finite ones of at most `_SAMPLE` points, spread evenly over the cloud's order."""
    if len(points) > _SAMPLE:
        points = points[np.linspace(0, len(points) - 1, _SAMPLE).astype(np.intp)]
    return points[np.isfinite(points).all(axis=1)]


def _eye_dome(colours: NDArray[np.uint8], depth: NDArray[np.float32], radius: int) -> NDArray[np.uint8]:
    """Darken pixels by how far they lie behind their eight neighbours, in ratios of depth (inf = nothing there)."""
    rows, columns = depth.shape
    far = np.log(depth)
    padded = np.pad(far, radius, constant_values=np.inf)
    behind = np.zeros_like(far)
    difference = np.empty_like(far)
    with np.errstate(invalid="ignore"):
        for dy, dx in ((0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (0, 2), (2, 0), (2, 2)):
            y, x = dy * radius, dx * radius
            np.subtract(far, padded[y : y + rows, x : x + columns], out=difference)
            np.maximum(difference, 0, out=difference)
            behind += difference
    behind *= -_EDL_STRENGTH / 8
    np.exp(behind, out=behind)
    np.nan_to_num(behind, copy=False, nan=1.0)
    return (colours * behind[..., None]).astype(np.uint8)
