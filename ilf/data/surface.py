"""The surface through a depth image as triangles, cut where depth jumps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.long_work import check_cancelled
from ..errors import InputError
from .arrays import plain_array
from .camera import Camera
from .open3d_images import load_open3d
from .pixel_grids import Pairs, strips
from .points import PointCloud, known_pixels, point_cloud, required_intrinsics

# Links between neighbouring pixels of one surface, cut where depth jumps.

_MAX_SLOPE = 5.7
"""Tangent of 80 degrees: maximum slope of a surface relative to the image at which a step is not a jump."""

_NOISE = 0.010
"""Maximum step at 1 m as a share of depth, at any angle; proportional to depth, like sensor noise."""

_MIN_STEP, _MAX_STEP = 0.01, 0.04
"""Share of depth up to which a step is never a jump, and above which it is always one."""

_CONTINUED_PIXELS = 2
"""Steeper steps are not jumps if inverse depth continues alike for this many pixels on both sides: a distant floor."""

_MAX_DIFFERENCE = 0.5
"""Maximum difference of the steps beside a step, as a share of it."""

Mask = NDArray[np.bool_]


def surface_links(depth: ArrayLike, intrinsics: Camera) -> Pairs:
    """Find which neighbours lie on one surface.

    Neighbours are linked unless the surface between them would be seen at a grazing angle (80 degrees), which in depth
    images is nearly always a jump, and the step is larger than noise. Even then they are linked if the surface
    continues with the same slope for two pixels on both sides, like a distant floor.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). Values that are not finite and positive are missing, and not linked.
    intrinsics : Camera
        Of this image.

    Returns
    -------
    ndarray of bool, shape (H, W - 1)
        Whether each pixel is linked to the one on its right.
    ndarray of bool, shape (H - 1, W)
        Whether each pixel is linked to the one below.

    Examples
    --------
    >>> right, down = surface_links([[2.0, 2.01, 3.0, np.nan]], Camera(500.0, 500.0, 2.0, 0.0))
    >>> right.tolist(), down.shape
    ([[True, False, False]], (0, 4))
    """
    image = np.asarray(plain_array(depth), np.float32)
    inverse = np.full(image.shape, np.nan, np.float32)
    np.divide(1, image, out=inverse, where=known_pixels(image))
    return _along_rows(inverse, intrinsics.fx), _along_rows(inverse.T, intrinsics.fy).T


def _along_rows(inverse: NDArray[np.float32], focal: float) -> Mask:
    """Whether the surface continues from each pixel to the next in its row; inverse depth [1/m], NaN = missing."""
    if inverse.shape[1] < 2:
        return np.zeros((inverse.shape[0], 0), bool)
    step = np.diff(inverse, axis=1)
    size = np.abs(step)
    nearer, farther = np.maximum(inverse[:, 1:], inverse[:, :-1]), np.minimum(inverse[:, 1:], inverse[:, :-1])
    share = size / farther  # step in depth as a share of the nearer depth
    linked = share <= np.clip(np.maximum(_MAX_SLOPE / focal, _NOISE / nearer), _MIN_STEP, _MAX_STEP)
    goes_on = ~linked & np.isfinite(share)
    for away in range(1, _CONTINUED_PIXELS + 1):
        alike = np.abs(step[:, away:] - step[:, :-away])
        goes_on[:, :away] = goes_on[:, -away:] = False
        goes_on[:, away:] &= alike <= _MAX_DIFFERENCE * size[:, away:]
        goes_on[:, :-away] &= alike <= _MAX_DIFFERENCE * size[:, :-away]
    return np.asarray(linked | goes_on)


_BAND = 128  # rows at a time, so that intermediate arrays stay small
_AT_ONCE = 1 << 20  # triangles


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles between points.

    Parameters
    ----------
    vertices : PointCloud
        The vertices with their colours, normals and scalars.
    faces : ndarray
        int32 (M, 3): three vertices each, counter-clockwise as seen by the camera, so that they face it.
    """

    vertices: PointCloud
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise InputError(f"A mesh needs faces of shape (M, 3), not {self.faces.shape}.")

    def __len__(self) -> int:
        return len(self.faces)

    def to_open3d(self) -> Any:
        """Return vertices, colours, normals and faces as an `open3d.geometry.TriangleMesh`, which has no scalars.

        Raises
        ------
        ExportError
            If Open3D is not installed (extra `app`).
        """
        o3d, vertices = load_open3d(), self.vertices.to_open3d()
        mesh = o3d.geometry.TriangleMesh(vertices.points, o3d.utility.Vector3iVector(self.faces))
        mesh.vertex_colors, mesh.vertex_normals = vertices.colors, vertices.normals
        return mesh


def surface_faces(depth: ArrayLike, links: Pairs) -> NDArray[np.int32]:
    """Create triangles between linked neighbouring pixels.

    Four linked pixels give two triangles, divided along the diagonal with the smaller step in depth; three give one.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W).
    links : tuple of ndarray
        Links of that depth, from `surface_links`.

    Returns
    -------
    ndarray of int32, shape (M, 3)
        Pixel indices, row times W plus column, counter-clockwise as seen by the camera.
    """
    image = np.asarray(plain_array(depth), np.float32)
    height, width = image.shape
    found = np.empty((2 * max(height - 1, 0) * max(width - 1, 0), 3), np.int32)
    count = 0
    for rows, *_ in strips(height - 1, rows=_BAND):
        for triangles in _triangles(image, links, rows):
            found[count : count + len(triangles)] = triangles
            count += len(triangles)
    return found[:count]


def _triangles(depth: NDArray[np.float32], links: Pairs, rows: slice) -> Iterator[NDArray[np.int32]]:
    """Yield triangles between the pixels a, b of some rows and c, d below them."""
    below = slice(rows.start + 1, rows.stop + 1)
    top, bottom = links[0][rows], links[0][below]
    left, right = links[1][rows, :-1], links[1][rows, 1:]
    rising = (top & left).view(np.uint8) + (right & bottom)
    falling = (top & right).view(np.uint8) + (left & bottom)
    here, under = depth[rows], depth[below]
    with np.errstate(invalid="ignore"):
        shorter = np.abs(here[:, 1:] - under[:, :-1]) <= np.abs(here[:, :-1] - under[:, 1:])
    rises = (rising > falling) | ((rising == falling) & shorter)
    width = depth.shape[1]
    for corner, (first, second, third) in (
        (rises & top & left, (0, width, 1)),  # a, c, b
        (rises & right & bottom, (width + 1, 1, width)),  # d, b, c
        (~rises & top & right, (1, 0, width + 1)),  # b, a, d
        (~rises & left & bottom, (width, width + 1, 0)),  # c, d, a
    ):
        y, x = np.nonzero(corner)
        a = ((y + rows.start) * width + x).astype(np.int32)
        yield np.stack([a + first, a + second, a + third], axis=1)


def surface_mesh(
    depth: ArrayLike,
    rgb: ArrayLike,
    intrinsics: Camera | ArrayLike | None,
    *,
    only: Mask | None = None,
    normals: NDArray[np.float32] | None = None,
    scalars: Mapping[str, NDArray[Any]] | None = None,
) -> Mesh:
    """Create a mesh of the surface through the known pixels, cut where depth jumps.

    Parameters
    ----------
    depth, rgb, intrinsics, only, normals, scalars
        As for `point_cloud`. Pixels without a neighbour on the same surface give no vertex.

    Returns
    -------
    Mesh
        In camera axes, vertices row by row.

    Raises
    ------
    InputError
        Without intrinsics, or if the shapes do not fit.

    Examples
    --------
    >>> camera = Camera(100.0, 100.0, 1.0, 0.5)
    >>> mesh = surface_mesh([[1.0, 1.0, 3.0], [1.0, 1.0, 3.0]], np.zeros((2, 3, 3), np.uint8), camera)
    >>> len(mesh.vertices), mesh.faces.tolist()
    (4, [[0, 2, 1], [3, 1, 2]])
    """
    image = np.asarray(plain_array(depth), np.float32)
    if only is not None:
        image = np.where(plain_array(only), image, np.float32(np.nan))
    faces = surface_faces(image, surface_links(image, required_intrinsics(intrinsics, image.shape)))
    check_cancelled()
    used = np.zeros(image.size, bool)
    used[faces.reshape(-1)] = True
    numbers = np.cumsum(used, dtype=np.int32)
    numbers -= 1
    for start in range(0, len(faces), _AT_ONCE):
        part = faces[start : start + _AT_ONCE]
        part[...] = numbers[part]
    check_cancelled()
    shown = used.reshape(image.shape)
    return Mesh(point_cloud(image, rgb, intrinsics, only=shown, normals=normals, scalars=scalars), faces)


# Surface normals at every pixel, from the slope of inverse depth.

_RADIUS, _ROUNDS = 4, 2
"""Radius [px] and number of passes of averaging slopes over linked pixels, to reduce sensor noise."""

_NORMALS_BAND = 256  # rows at a time, so that intermediate arrays stay small

Array = NDArray[np.float32]
Double = NDArray[np.float64]


def surface_normals(depth: ArrayLike, intrinsics: Camera | ArrayLike | None) -> Array:
    """Compute the surface normal at every pixel.

    The inverse depth of a plane is linear across the image, so its slope gives the normal. The slope is averaged over
    linked neighbours within a few pixels (sigma 3.7 px), but never across a jump.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). Values that are not finite and positive are missing.
    intrinsics : Camera
        Of this image.

    Returns
    -------
    ndarray of float32, shape (H, W, 3)
        Unit vectors in camera axes, towards the camera; 0, 0, -1 where a pixel has no link or depth is missing.

    Raises
    ------
    InputError
        Without intrinsics.

    Examples
    --------
    >>> normals = surface_normals(np.full((3, 4), 2.0), Camera(100.0, 100.0, 1.5, 1.0))
    >>> bool(np.allclose(normals, (0, 0, -1)))
    True
    """
    image = np.asarray(plain_array(depth), np.float32)
    camera = required_intrinsics(intrinsics, image.shape)
    right, down = surface_links(image, camera)
    found = np.empty((*image.shape, 3), np.float32)
    for rows, wider, inner in strips(len(image), _ROUNDS * _RADIUS + 1, _NORMALS_BAND):
        links = right[wider], down[wider.start : wider.stop - 1]
        found[rows] = _normals(image[wider], links, camera, wider.start)[inner]
    return found


def _normals(depth: Array, links: Pairs, intrinsics: Camera, first_row: int) -> Array:
    known = known_pixels(depth)
    inverse = np.divide(1, depth, out=np.zeros(depth.shape, np.float32), where=known)
    across, along = _slopes(inverse, links), _slopes(inverse.T, (links[1].T, links[0].T)).T
    rows, columns = np.arange(depth.shape[0], dtype=np.float32)[:, None], np.arange(depth.shape[1], dtype=np.float32)
    sight_x = (columns - np.float32(intrinsics.cx)) / np.float32(intrinsics.fx)
    sight_y = (rows + np.float32(first_row - intrinsics.cy)) / np.float32(intrinsics.fy)
    # a plane n . P = 1 has the inverse depth n_x x / z + n_y y / z + n_z
    normal = np.empty((*depth.shape, 3), np.float32)
    np.multiply(across, np.float32(-intrinsics.fx), out=normal[..., 0])
    np.multiply(along, np.float32(-intrinsics.fy), out=normal[..., 1])
    normal[..., 2] = -inverse - normal[..., 0] * sight_x - normal[..., 1] * sight_y
    normal[~known] = (0, 0, -1)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return normal


def _slopes(inverse: Array, links: Pairs) -> Array:
    """Return the mean step along the rows over linked pixels; 0 where there is none."""
    right, down = links
    total, count = np.zeros(inverse.shape), np.zeros(inverse.shape)
    step = np.where(right, np.diff(inverse, axis=1), 0)
    for side in (np.s_[:, :-1], np.s_[:, 1:]):
        total[side] += step
        count[side] += right
    along, across = _reach(right), _reach(down.T)
    for _ in range(_ROUNDS):
        total, count = (_box_sums(_box_sums(values, *along).T, *across).T for values in (total, count))
    return np.divide(total, count, out=np.zeros(inverse.shape), where=count > 0).astype(np.float32)


def _reach(linked: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first pixel of its row that each pixel is averaged with, and the one after the last: near and
    linked."""
    height, width = linked.shape[0], linked.shape[1] + 1
    here = np.arange(width)
    first, last = np.zeros((height, width), np.intp), np.full((height, width), width - 1)
    first[:, 1:] = np.where(linked, 0, here[1:])
    last[:, :-1] = np.where(linked, width - 1, here[:-1])
    np.maximum.accumulate(first, axis=1, out=first)
    np.minimum.accumulate(last[:, ::-1], axis=1, out=last[:, ::-1])
    return np.maximum(first, here - _RADIUS), np.minimum(last, here + _RADIUS) + 1


def _box_sums(values: Double, first: NDArray[np.intp], end: NDArray[np.intp]) -> Double:
    """Return sums of the values of each row from `first` to before `end`."""
    sums = np.zeros((len(values), values.shape[1] + 1))
    np.cumsum(values, axis=1, out=sums[:, 1:])
    return np.asarray(np.take_along_axis(sums, end, 1) - np.take_along_axis(sums, first, 1))
