"""The surface through a depth image as triangles, cut where depth jumps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from ..errors import InputError
from ..stopping import check_stopped
from .links import Links, surface_links
from .points import PointCloud, point_cloud, required

_BAND = 128  # rows at a time, so that intermediate arrays stay small
_AT_ONCE = 1 << 20  # triangles

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles between points.

    Parameters
    ----------
    vertices : PointCloud
        With whatever is known of each.
    faces : ndarray
        int32 (M, 3): three vertices each, counter-clockwise as the camera sees them, so that they face it.
    """

    vertices: PointCloud
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise InputError(f"A mesh needs faces of shape (M, 3), not {self.faces.shape}.")

    def __len__(self) -> int:
        return len(self.faces)


def surface_faces(depth: ArrayLike, links: Links) -> NDArray[np.int32]:
    """Triangles between neighbouring pixels that are linked.

    Of four pixels that are all linked, the diagonal with the smaller step in depth parts the two triangles; of three,
    there is one.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W).
    links : Links
        Of that depth.

    Returns
    -------
    ndarray of int32, shape (M, 3)
        Pixels, each its row times W plus its column, counter-clockwise as the camera sees them.
    """
    image = np.asarray(depth, np.float32)
    height, width = image.shape
    found = np.empty((2 * max(height - 1, 0) * max(width - 1, 0), 3), np.int32)
    count = 0
    for top in range(0, height - 1, _BAND):
        for triangles in _triangles(image, links, slice(top, min(top + _BAND, height - 1))):
            found[count : count + len(triangles)] = triangles
            count += len(triangles)
    return found[:count]


def _triangles(depth: NDArray[np.float32], links: Links, rows: slice) -> Iterator[NDArray[np.int32]]:
    """Triangles between the pixels of some rows and those below them: a, b; c, d below."""
    below = slice(rows.start + 1, rows.stop + 1)
    top, bottom = links.right[rows], links.right[below]
    left, right = links.down[rows, :-1], links.down[rows, 1:]
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
    intrinsics: CameraIntrinsics | None,
    *,
    only: Mask | None = None,
    normals: NDArray[np.float32] | None = None,
    scalars: Mapping[str, NDArray[Any]] | None = None,
) -> Mesh:
    """The surface through the known pixels, cut where depth jumps.

    Parameters
    ----------
    depth, rgb, intrinsics, only, normals, scalars
        As `point_cloud` takes them. Pixels without a neighbour on the same surface give no vertex.

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
    >>> camera = CameraIntrinsics(100.0, 100.0, 1.0, 0.5)
    >>> mesh = surface_mesh([[1.0, 1.0, 3.0], [1.0, 1.0, 3.0]], np.zeros((2, 3, 3), np.uint8), camera)
    >>> len(mesh.vertices), mesh.faces.tolist()
    (4, [[0, 2, 1], [3, 1, 2]])
    """
    image = np.asarray(depth, np.float32)
    if only is not None:
        image = np.where(only, image, np.float32(np.nan))
    faces = surface_faces(image, surface_links(image, required(intrinsics)))
    check_stopped()
    used = np.zeros(image.size, bool)
    used[faces.reshape(-1)] = True
    numbers = np.cumsum(used, dtype=np.int32)
    numbers -= 1
    for start in range(0, len(faces), _AT_ONCE):
        part = faces[start : start + _AT_ONCE]
        part[...] = numbers[part]
    check_stopped()
    shown = used.reshape(image.shape)
    return Mesh(point_cloud(image, rgb, intrinsics, only=shown, normals=normals, scalars=scalars), faces)
