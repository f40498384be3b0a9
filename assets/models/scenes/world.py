"""A whole scene that rays are cast into."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ilf.data.open3d_images import load_open3d

from .materials import Table
from .parts import Parts
from .shapes import joined, unit

open3d = load_open3d("Casting rays")

OFF_SURFACE = 0.001
"""Where rays that leave a surface begin, above it [m]."""


class Hits:
    """What rays met, row by row; where they met nothing `found` is False and the rest undefined."""

    def __init__(
        self, world: World, origins: np.ndarray, directions: np.ndarray, met: tuple[np.ndarray, np.ndarray, np.ndarray]
    ) -> None:
        self._world, self._origins, self._directions = world, origins, directions
        self.distance, self._triangle, self._share = met
        """Of the hits, in units of the rays' directions."""
        self.found = np.isfinite(self.distance)

    def rows(self, which: np.ndarray) -> Hits:
        """Some of the rays."""
        origins = self._origins if self._origins.ndim == 1 else self._origins[which]
        met = self.distance[which], self._triangle[which], self._share[which]
        return Hits(self._world, origins, self._directions[which], met)

    @cached_property
    def points(self) -> np.ndarray:
        far = np.where(self.found, self.distance, 0).astype(np.float32)
        return self._origins.astype(np.float32) + far[:, None] * self._directions

    @cached_property
    def flat(self) -> np.ndarray:
        """Normals of the triangles, turned towards the rays' origins."""
        return towards(self._world.flat[self._triangle], -self._directions)

    @cached_property
    def normals(self) -> np.ndarray:
        """Smooth normals, turned the same way."""
        normals = towards(self._mean(self._world.normals), self.flat)
        return normals / np.sqrt(np.maximum(dot(normals, normals), 1e-12))[:, None]

    @cached_property
    def uv(self) -> np.ndarray:
        return self._mean(self._world.uv)

    @cached_property
    def material(self) -> np.ndarray:
        return self._world.material[self._triangle]

    @cached_property
    def part(self) -> np.ndarray:
        return self._world.part[self._triangle]

    @cached_property
    def object(self) -> np.ndarray:
        return self._world.object[self._triangle]

    def _mean(self, of_vertices: np.ndarray) -> np.ndarray:
        a, b, c = self._world.triangles[self._triangle].T
        u, v = self._share.T[..., None]
        return of_vertices[a] * (1 - u - v) + of_vertices[b] * u + of_vertices[c] * v


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
        whole = joined([shape for shape, _ in parts])
        vertices = whole.vertices.astype(np.float32)
        self.triangles = whole.triangles
        self.normals, self.uv = whole.normals.astype(np.float32), whole.uv.astype(np.float32)
        self.part = whole.face[self.triangles[:, 0]]
        self.material = np.repeat([number for _, number in parts], [len(shape.triangles) for shape, _ in parts])
        owners: dict[int, int] = {}
        objects = [owners.setdefault(id(shape.owner or shape), len(owners)) for shape, _ in parts]
        self.object = np.repeat(objects, [len(shape.triangles) for shape, _ in parts])
        a, b, c = (vertices[corner] for corner in self.triangles.T)
        self.flat = unit(np.cross(b - a, c - a))
        solid = ~table.transparent[self.material]
        self._all = _Caster(vertices, self.triangles, np.arange(len(self.triangles)))
        self._solid = self._all
        if not solid.all():
            self._solid = _Caster(vertices, self.triangles[solid], np.flatnonzero(solid))

    @property
    def has_glass(self) -> bool:
        return self._solid is not self._all

    def cast(self, origins: np.ndarray, directions: np.ndarray, *, through_glass: bool = False) -> Hits:
        """First hit of each ray; directions (N, 3), origins (N, 3) or one for all."""
        caster = self._solid if through_glass else self._all
        return Hits(self, origins, directions, caster.first(origins, directions))

    def blocked(self, origins: np.ndarray, directions: np.ndarray, far: float = 1.0) -> np.ndarray:
        """Whether something solid lies on each ray before `far` times its direction, bool (N,)."""
        return self._solid.any_before(origins, directions, far)


class _Caster:
    """Ray casting against a part of the triangles, on one thread."""

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray, numbers: np.ndarray) -> None:
        self._numbers = numbers
        self._scene = open3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(open3d.core.Tensor(vertices), open3d.core.Tensor(triangles.astype(np.uint32)))

    def first(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance, triangle and place on it; the distance is infinite where there is no hit."""
        answer = self._scene.cast_rays(_rays(origins, directions), nthreads=1)
        distance = answer["t_hit"].numpy()
        hit = np.where(np.isfinite(distance), answer["primitive_ids"].numpy(), 0)
        return distance, self._numbers[hit], answer["primitive_uvs"].numpy()

    def any_before(self, origins: np.ndarray, directions: np.ndarray, far: float) -> np.ndarray:
        return self._scene.test_occlusions(_rays(origins, directions), tnear=0.0, tfar=far, nthreads=1).numpy()


def _rays(origins: np.ndarray, directions: np.ndarray) -> Any:
    rays = np.empty((len(directions), 6), np.float32)
    rays[:, :3], rays[:, 3:] = origins, directions
    return open3d.core.Tensor(rays)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)


def towards(vectors: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Vectors turned so that each is on the side of its other."""
    return vectors * np.where(dot(vectors, others) < 0, np.float32(-1), np.float32(1))[:, None]
