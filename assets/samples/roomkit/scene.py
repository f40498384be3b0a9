"""The scene: parts with materials, and rays against all of them on the CPU."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ilf.data.open3d_images import load_open3d

from .meshes import Mesh, corner_normals
from .textures import Texture

open3d = load_open3d("Casting rays")


@dataclass(frozen=True)
class Material:
    """How a surface looks, and how an infrared pattern fares on it.

    Parameters
    ----------
    colour : ndarray
        Mean linear RGB, for light that bounces off.
    texture : callable, optional
        Object coordinates -> linear RGB, for what the camera sees.
    gloss : float
        Mirror reflection at normal incidence (Schlick's F0); 0 = matt.
    roughness : float
        Spread of mirror rays, as the standard deviation of the slope.
    emission : ndarray
        Radiance that the surface gives off.
    black : bool
        Absorbs infrared: no depth.
    floor : bool
        Varnished floor: mirrors the infrared pattern away where it reflects something bright.
    clear : bool
        Thin glass: seen through without refraction, casts no shadow.
    """

    colour: np.ndarray
    texture: Texture | None = None
    gloss: float = 0.0
    roughness: float = 0.0
    emission: np.ndarray = field(default_factory=lambda: np.zeros(3))
    black: bool = False
    floor: bool = False
    clear: bool = False


@dataclass(frozen=True)
class Hits:
    """What rays met, row by row; rows that met nothing have `found` False and undefined values."""

    found: np.ndarray
    distance: np.ndarray
    """In units of the ray's direction vector."""
    points: np.ndarray
    normals: np.ndarray
    """Shading normals, turned towards the ray's origin."""
    flat: np.ndarray
    """Normals of the triangles, turned the same way."""
    material: np.ndarray
    texture: np.ndarray
    part: np.ndarray
    """Which of the scene's parts."""


class Scene:
    """All parts for ray casting: what is solid in one structure, glass in another."""

    def __init__(self, parts: list[tuple[Mesh, Material]]) -> None:
        self.materials = list({id(material): material for _, material in parts}.values())
        number = {id(material): i for i, material in enumerate(self.materials)}
        meshes = [mesh for mesh, _ in parts]
        self._normals = np.concatenate([corner_normals(mesh) for mesh in meshes]).astype(np.float32)
        self._texture = np.concatenate([m.texture[m.triangles] for m in meshes]).astype(np.float32)
        self._material = np.concatenate([np.full(len(m.triangles), number[id(mat)]) for m, mat in parts])
        self._part = np.concatenate([np.full(len(mesh.triangles), part) for part, mesh in enumerate(meshes)])
        corners = np.concatenate([m.vertices[m.triangles] for m in meshes]).astype(np.float32)
        clear = np.array([material.clear for material in self.materials])[self._material]
        self._triangles = {glass: np.flatnonzero(clear == glass) for glass in (False, True)}
        self._rays = {glass: _caster(corners[chosen]) for glass, chosen in self._triangles.items()}

    def cast(self, origins: np.ndarray, directions: np.ndarray, *, glass: bool = False) -> Hits:
        """First hit of each ray on what is solid, or on glass; (N, 3) each."""
        answer = self._rays[glass].cast_rays(_rays(origins, directions))
        distance = answer["t_hit"].numpy()
        found = np.isfinite(distance)
        triangle = np.zeros(len(found), np.int64)
        triangle[found] = self._triangles[glass][answer["primitive_ids"].numpy()[found]]
        uv = answer["primitive_uvs"].numpy()
        share = np.stack([1 - uv[:, 0] - uv[:, 1], uv[:, 0], uv[:, 1]], axis=1)
        flat = answer["primitive_normals"].numpy()
        flat = flat * np.where(dot(flat, directions) > 0, -1, 1)[:, None]
        normals = np.einsum("nc,nci->ni", share, self._normals[triangle])
        normals *= np.where(dot(normals, flat) < 0, -1, 1)[:, None]
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        return Hits(
            found=found,
            distance=distance,
            points=origins + np.where(found, distance, 0)[:, None] * directions,
            normals=normals,
            flat=flat,
            material=self._material[triangle],
            texture=np.einsum("nc,nci->ni", share, self._texture[triangle]),
            part=self._part[triangle],
        )

    def blocked(self, origins: np.ndarray, directions: np.ndarray, *, far: float = 1.0) -> np.ndarray:
        """Whether anything solid lies on each ray between its origin and `far` times its direction, bool (N,)."""
        return self._rays[False].test_occlusions(_rays(origins, directions), tnear=0.0, tfar=far).numpy()

    def colour(self, hits: Hits, *, textured: bool) -> np.ndarray:
        """Linear RGB of the surfaces that were hit, (N, 3)."""
        colours = np.stack([m.colour for m in self.materials])[hits.material]
        if textured:
            for number, material in enumerate(self.materials):
                here = np.flatnonzero(hits.found & (hits.material == number))
                if material.texture is not None and here.size:
                    colours[here] = material.texture(hits.texture[here].astype(float))
        return np.clip(colours, 0.0, 0.95)

    def of(self, name: str, hits: Hits) -> np.ndarray:
        """One property of the materials that were hit, row by row."""
        return np.array([getattr(m, name) for m in self.materials])[hits.material]


def _caster(corners: np.ndarray) -> Any:
    """Triangles, (N, 3, 3), for ray casting."""
    rays = open3d.t.geometry.RaycastingScene()
    numbers = np.arange(3 * len(corners), dtype=np.uint32).reshape(-1, 3)
    rays.add_triangles(open3d.core.Tensor(corners.reshape(-1, 3)), open3d.core.Tensor(numbers))
    return rays


def in_front(glass: Hits, solid: Hits) -> Hits:
    """The hits on glass, found only before what is solid."""
    return replace(glass, found=glass.found & (glass.distance < solid.distance))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ni,ni->n", a, b)


def _rays(origins: np.ndarray, directions: np.ndarray) -> Any:
    return open3d.core.Tensor(np.concatenate([origins, directions], axis=1).astype(np.float32))
