"""A whole scene that rays are cast into."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, fields

import libusb_package
import numpy as np

from .materials import Table
from .parts import Parts

# open3d loads libusb-1.0 on import; bare machines have only the copy in this package.
ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
import open3d  # noqa: E402

OFF_SURFACE = 0.001
"""Where rays that leave a surface begin, above it [m]."""


@dataclass(frozen=True)
class Hits:
    """What rays met, row by row; where they met nothing `found` is False and the rest undefined."""

    found: np.ndarray
    distance: np.ndarray
    """In units of the ray's direction."""
    points: np.ndarray
    normals: np.ndarray
    """Smooth normals, turned towards the ray's origin."""
    flat: np.ndarray
    """Normals of the triangles, turned the same way."""
    uv: np.ndarray
    material: np.ndarray
    part: np.ndarray

    def rows(self, which: np.ndarray) -> Hits:
        return Hits(*(getattr(self, one.name)[which] for one in fields(self)))


class World:
    """All parts in one structure for rays; a second one leaves out what is transparent.

    Parameters
    ----------
    parts : list of (Shape, int)
        Shapes and the rows of `table` that they are made of.
    table : Table
        Their materials.
    """

    def __init__(self, parts: Parts, table: Table) -> None:
        self.table = table
        shapes = [shape for shape, _ in parts]
        sizes = [len(shape.face) for shape in shapes]
        firsts = np.concatenate([[0], np.cumsum([int(shape.face.max()) + 1 for shape in shapes])])
        self._corners = np.concatenate([s.corners for s in shapes]).astype(np.float32)
        self._normals = np.concatenate([s.normals for s in shapes]).astype(np.float32)
        self._uv = np.concatenate([s.uv for s in shapes]).astype(np.float32)
        self._part = np.concatenate([s.face for s in shapes]) + np.repeat(firsts[:-1], sizes)
        self._material = np.repeat([material for _, material in parts], sizes)
        solid = ~table.transparent[self._material]
        self._all = _Caster(self._corners, np.arange(len(self._corners)))
        self._solid = self._all if solid.all() else _Caster(self._corners[solid], np.flatnonzero(solid))

    @property
    def has_glass(self) -> bool:
        return self._solid is not self._all

    def cast(self, origins: np.ndarray, directions: np.ndarray, *, through_glass: bool = False) -> Hits:
        """First hit of each ray, (N, 3) each."""
        caster = self._solid if through_glass else self._all
        distance, triangle, share = caster.first(origins, directions)
        found = np.isfinite(distance)
        corners = self._corners[triangle]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat = towards(flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-20), -directions)
        normals = towards(np.einsum("nc,nci->ni", share, self._normals[triangle]), flat)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        return Hits(
            found=found,
            distance=distance,
            points=(origins + np.where(found, distance, 0)[:, None] * directions).astype(np.float32),
            normals=normals,
            flat=flat,
            uv=np.einsum("nc,nci->ni", share, self._uv[triangle]),
            material=self._material[triangle],
            part=self._part[triangle],
        )

    def blocked(self, origins: np.ndarray, directions: np.ndarray, far: float = 1.0) -> np.ndarray:
        """Whether something solid lies on each ray before `far` times its direction, bool (N,)."""
        return self._solid.any_before(origins, directions, far)


class _Caster:
    """Ray casting against a part of the triangles, on one thread."""

    def __init__(self, corners: np.ndarray, numbers: np.ndarray) -> None:
        self._numbers = numbers
        self._scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        index = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
        self._scene.add_triangles(open3d.core.Tensor(corners.reshape(-1, 3)), open3d.core.Tensor(index))

    def first(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance, triangle and shares of its corners; distance is infinite where there is no hit."""
        answer = self._scene.cast_rays(_rays(origins, directions), nthreads=1)
        distance = answer["t_hit"].numpy()
        hit = np.where(np.isfinite(distance), answer["primitive_ids"].numpy(), 0)
        u, v = answer["primitive_uvs"].numpy().T
        return distance, self._numbers[hit], np.stack([1 - u - v, u, v], axis=1)

    def any_before(self, origins: np.ndarray, directions: np.ndarray, far: float) -> np.ndarray:
        return self._scene.test_occlusions(_rays(origins, directions), tnear=0.0, tfar=far, nthreads=1).numpy()


def _rays(origins: np.ndarray, directions: np.ndarray) -> open3d.core.Tensor:
    rays = np.empty((len(directions), 6), np.float32)
    rays[:, :3], rays[:, 3:] = origins, directions
    return open3d.core.Tensor(rays)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)


def towards(vectors: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Vectors turned so that each is on the side of its other."""
    return vectors * np.where(dot(vectors, others) < 0, np.float32(-1), np.float32(1))[:, None]
