"""Point cloud rendering in numpy: z-buffer splatting and eye-dome lighting. No Qt, no OpenGL."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import run_to_end

# A camera that orbits a point of the cloud.

NEAR = 0.01
"""Points nearer to the eye than this [m] are not drawn."""

_DISTANCES = (0.02, 1e4)
_SAMPLE = 20_000  # points, enough to estimate a cloud's extent and density


@dataclass(frozen=True)
class OrbitCamera:
    """A camera that orbits a target. Axes as in the cloud: x right, y down, z forward.

    Parameters
    ----------
    target : tuple of float
        Point at which the camera looks, (x, y, z) [m].
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
        """A camera rotated about the target by two angles [rad]; the pitch is limited to straight above and below."""
        turned = math.remainder(self.yaw + yaw, math.tau)
        return replace(self, yaw=turned, pitch=min(max(self.pitch + pitch, -math.pi / 2), math.pi / 2))

    def pan(self, right: float, down: float) -> OrbitCamera:
        """A camera moved with its target along the picture's axes [m]."""
        x_axis, y_axis, _ = self.rotation()
        x, y, z = (np.asarray(self.target) + right * x_axis + down * y_axis).tolist()
        return replace(self, target=(x, y, z))

    def dolly(self, factor: float) -> OrbitCamera:
        """A camera moved nearer (factor < 1) or farther (factor > 1), within 0.02 m to 10 km."""
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

    def project(self, points: NDArray[np.floating], width: int, height: int) -> NDArray[np.float64]:
        """Project points of the cloud, (N, 3) [m], to a picture of that size, float64 (N, 3): x and y [px] from its
        upper left corner, and distance before the eye [m]; x and y are valid only if that is positive."""
        matrix = self.view_matrix()
        eye = np.asarray(points, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        with np.errstate(all="ignore"):
            places = eye[:, :2] / eye[:, 2:] * self.focal(height) + (width / 2, height / 2)
        return np.column_stack([places, eye[:, 2]])

    def metres_per_pixel(self, height: int) -> float:
        """Length [m] of a pixel's side at the target, in a picture of that height."""
        return self.distance / self.focal(height)

    def fitted(self, points: NDArray[np.float32], aspect: float) -> OrbitCamera:
        """A camera with the same direction that shows nearly all of a cloud, centred.

        Parameters
        ----------
        points : ndarray
            float32 (N, 3) [m]. The outermost points are ignored: outliers would make the rest tiny.
        aspect : float
            Width of the picture over its height.
        """
        sample = finite_sample(points).astype(np.float64)
        if not len(sample):
            return self
        centre = np.median(sample, axis=0)
        x, y, z = self.rotation() @ (sample - centre).T
        half = math.tan(0.5 * self.fov)
        middle = np.zeros(2)
        for _ in range(4):  # the middle of the picture depends on the distance, and vice versa
            across, along = np.abs(x - middle[0]) / aspect, np.abs(y - middle[1])
            distance = max(float(np.percentile(np.maximum(across, along) / half - z, 99.5)), 2 * NEAR - float(z.min()))
            edges = np.percentile(np.stack([x - middle[0], y - middle[1]]) / (z + distance), (0.5, 99.5), axis=1)
            middle += edges.mean(axis=0) * distance
        aimed = replace(self, target=tuple(centre.tolist()), distance=1.0)
        return aimed.pan(*middle.tolist()).dolly(1.08 * distance)


def finite_sample(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """The finite points of a sample of at most 20 000 points, evenly spaced in the cloud's order."""
    if len(points) > _SAMPLE:
        points = points[np.linspace(0, len(points) - 1, _SAMPLE).astype(np.intp)]
    return points[np.isfinite(points).all(axis=1)]


# The picture: every point is a square, and the nearest point is visible.

MAX_POINT_SIZE = 12
"""Largest side of a point [px]; automatic sizes stop here when zoomed far in."""

_CHUNK = 1 << 15  # points at a time, so that intermediate arrays stay in the cache
_EMPTY = np.uint64(0xFFFF_FFFF_FFFF_FFFF)
_INDEX = np.uint64(0xFFFF_FFFF)
_MIN_FILLED_NEIGHBOURS = 5  # of eight neighbours
_OVERLAP = 1.6  # ratio of automatic point size to spacing; smaller ones leave slits in slanted surfaces
_EDL_STRENGTH = 12.0
_EDL_STEPS = 4000  # per unit of log depth: from NEAR to 100 km they fit into 16 bits
_EDL_EMPTY = 0xFFFF
_EDL_NEIGHBOURS = ((0, 1), (1, 0), (1, 2), (2, 1), (0, 0), (0, 2), (2, 0), (2, 2))

_EDL_SHADES = np.round(255 * np.exp(-_EDL_STRENGTH / 8 / _EDL_STEPS * np.arange(1 << 16))).astype(np.uint8)


@dataclass(frozen=True)
class Sight:
    """View of a cloud: camera and rendering options.

    Parameters
    ----------
    camera : OrbitCamera
    width, height : int
        Size of the picture [px].
    background : tuple of int
        Red, green, blue of pixels without a point.
    point_size : int, optional
        Side of a point [px], 1 to `MAX_POINT_SIZE`. None: each point is as wide as its apparent distance to its
        neighbours, assuming a depth camera at the origin, and single gaps are closed.
    shaded : bool
        Whether to use eye-dome lighting, which darkens points behind their neighbourhood.
    depths : tuple of float
        Points whose z [m] in the cloud is not within these two are not drawn.
    """

    camera: OrbitCamera
    width: int
    height: int
    background: tuple[int, int, int] = (0, 0, 0)
    point_size: int | None = None
    shaded: bool = True
    depths: tuple[float, float] = (-math.inf, math.inf)


@dataclass(frozen=True, eq=False)
class Splat:
    """A rendered picture of a cloud.

    Parameters
    ----------
    picture : ndarray
        uint8 (height, width, 3), red first.
    nearest : ndarray
        int32 (height, width): index of the visible point at each pixel, -1 where there is none.
    """

    picture: NDArray[np.uint8]
    nearest: NDArray[np.int32]


def splat(points: NDArray[np.float32], colours: NDArray[np.uint8], look: Sight, spacing: float | None = None) -> Splat:
    """Draw a point cloud: every point is a square, and the nearest point is visible.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m], x right, y down, z forward. Points that are not finite are not drawn.
    colours : ndarray
        uint8 (N, 3), red first.
    look : Sight
    spacing : float, optional
        Spacing of the points; found by `spacing_of` if left out.

    Returns
    -------
    Splat
    """
    return run_to_end(splat_steps(points, colours, look, spacing))


def splat_steps(
    points: NDArray[np.float32], colours: NDArray[np.uint8], look: Sight, spacing: float | None = None
) -> Generator[None, None, Splat]:
    """`splat` as a generator with steps of a few milliseconds, so that it can be stopped early."""
    if look.point_size is None:
        gain = _OVERLAP * look.camera.focal(look.height) * (spacing_of(points) if spacing is None else spacing)
        smallest, largest = _size_range(points, look.camera, gain)
    else:
        gain = 0.0
        smallest = largest = min(max(int(look.point_size), 1), MAX_POINT_SIZE)
    keys = yield from _nearest_keys(points, look, gain, smallest, largest)
    seen = keys != _EMPTY
    nearest = (keys & _INDEX).astype(np.int32)  # _EMPTY becomes -1
    if not len(points):
        return Splat(np.full((*keys.shape, 3), look.background, np.uint8), nearest)
    picture = np.take(colours, nearest, axis=0)
    if look.shaded:
        depth = (keys >> np.uint64(32)).astype(np.uint32).view(np.float32)
        yield
        picture = _eye_dome(picture, depth, seen, radius=max(1, round(look.height / 600)))
    cv2.copyTo(np.full_like(picture, look.background), (~seen).view(np.uint8), picture)
    return Splat(picture, nearest)


def _nearest_keys(
    points: NDArray[np.float32], look: Sight, gain: float, smallest: int, largest: int
) -> Generator[None, None, NDArray[np.uint64]]:
    """For each pixel the key (depth bits << 32 | index) of the nearest point that covers it, or _EMPTY.

    The bits of positive floats sort like the floats, so the smallest key is the nearest point. Points are drawn as
    single pixels into one layer per size; a layer is then widened by a pixel and merged with the next smaller one.
    The result equals filling every square, at a cost that does not depend on the number of points.
    """
    margin = largest  # squares of points just outside extend into the picture
    columns, rows = look.width + 2 * margin, look.height + 2 * margin
    layers = np.full((largest - smallest + 1, rows, columns), _EMPTY)
    flat = layers.reshape(-1)
    matrix = look.camera.view_matrix().astype(np.float32)
    rotation, shift = np.ascontiguousarray(matrix[:3, :3]), matrix[:3, 3:]
    focal = np.float32(look.camera.focal(look.height))
    centre_x, centre_y = np.float32(columns / 2), np.float32(rows / 2)
    low, high = look.depths
    for start in range(0, len(points), _CHUNK):
        with np.errstate(all="ignore"):
            chunk = points[start : start + _CHUNK]
            eye = rotation @ chunk.T
            eye += shift
            z = eye[2]
            scale = focal / z
            u = eye[0] * scale + centre_x
            v = eye[1] * scale + centre_y
            inside = (z > NEAR) & (z < np.inf) & (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
            inside &= (chunk[:, 2] >= low) & (chunk[:, 2] <= high)
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
        yield
    merged = layers[-1]
    for size in range(largest, 1, -1):
        # every square is widened by a pixel in both axes, to the right and down, then to the left and up
        for axis in (merged, merged.T):
            np.minimum(axis[:-1], axis[1:], out=axis[1:] if size % 2 == 0 else axis[:-1])
        if size > smallest:
            np.minimum(merged, layers[size - 1 - smallest], out=merged)
        yield
    if look.point_size is None:
        _close_gaps(merged)
    return merged[margin : margin + look.height, margin : margin + look.width]


def _close_gaps(keys: NDArray[np.uint64]) -> None:
    """Give pixels without a point, but with most of their eight neighbours filled, the nearest of those; in place.

    A surface that the depth camera saw at a grazing angle has gaps wider than its points.
    """
    seen = (keys != _EMPTY).view(np.uint8)
    around = cv2.boxFilter(seen, cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    gaps = (around >= _MIN_FILLED_NEIGHBOURS) & (seen == 0)
    gaps[[0, -1]] = gaps[:, [0, -1]] = False
    places, flat = np.flatnonzero(gaps), keys.reshape(-1)
    columns = keys.shape[1]
    nearest = np.full(len(places), _EMPTY)
    for offset in (-columns - 1, -columns, -columns + 1, -1, 1, columns - 1, columns, columns + 1):
        np.minimum(nearest, flat[places + offset], out=nearest)
    flat[places] = nearest


def spacing_of(points: NDArray[np.float32]) -> float:
    """Distance between neighbouring points of a cloud, divided by their depth; 0 if there are too few points.

    A depth camera samples equal angles, so neighbours at depth z are k z apart. k is estimated from the solid angle
    that the cloud fills and the number of its points.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m].
    """
    sample = finite_sample(points)
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
    return math.sqrt(area / max(count, 1.0))


def _size_range(points: NDArray[np.float32], camera: OrbitCamera, gain: float) -> tuple[int, int]:
    """Smallest and largest automatic size [px] that the view needs."""
    sample = finite_sample(points)
    forward = camera.view_matrix()[2]
    depth = sample @ forward[:3].astype(np.float32) + np.float32(forward[3])
    visible = (depth > NEAR) & (sample[:, 2] > NEAR)
    if gain == 0.0 or not visible.any():
        return 1, 1
    ratio = gain * np.percentile(sample[visible, 2] / depth[visible], (1, 99))
    low, high = np.ceil(ratio).clip(1, MAX_POINT_SIZE)
    return int(low), int(high)


def _eye_dome(
    colours: NDArray[np.uint8], depth: NDArray[np.float32], seen: NDArray[np.bool_], radius: int
) -> NDArray[np.uint8]:
    """Darken pixels with points by how far they lie behind their eight neighbours, in ratios of depth."""
    rows, columns = depth.shape
    with np.errstate(all="ignore"):
        far = np.log(depth)
        far -= np.float32(math.log(NEAR))
        far *= np.float32(_EDL_STEPS)
        far[~seen] = _EDL_EMPTY
        levels = far.astype(np.uint16)
    padded = cv2.copyMakeBorder(levels, radius, radius, radius, radius, cv2.BORDER_CONSTANT, value=[_EDL_EMPTY])
    behind, difference = np.zeros_like(levels), np.empty_like(levels)
    for dy, dx in _EDL_NEIGHBOURS:
        y, x = dy * radius, dx * radius
        # both saturate at 16 bits: points in front do not count, and black stays black
        cv2.subtract(levels, padded[y : y + rows, x : x + columns], dst=difference)
        cv2.add(behind, difference, dst=behind)
    shade = np.take(_EDL_SHADES, behind)
    return np.asarray(cv2.multiply(colours, cv2.merge([shade, shade, shade]), scale=1 / 255), np.uint8)
