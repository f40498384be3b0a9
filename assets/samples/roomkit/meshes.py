"""Triangle meshes from a few generators. World axes: x right, y up, z away from the camera; metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Mesh:
    """Triangles with the coordinates that textures are drawn in.

    Parameters
    ----------
    vertices : ndarray, float64 (V, 3)
        World positions [m].
    triangles : ndarray, int (T, 3)
        Vertex indices, wound alike within one smooth surface.
    texture : ndarray, float64 (V, 3)
        Position of each vertex in the object's own coordinates, from before it was moved.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    texture: np.ndarray

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Mesh:
        return Mesh(self.vertices + np.array([x, y, z]), self.triangles, self.texture)

    def turned(self, degrees: float, axis: str = "y") -> Mesh:
        first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        vertices = self.vertices.copy()
        vertices[:, first] = cos * self.vertices[:, first] - sin * self.vertices[:, second]
        vertices[:, second] = sin * self.vertices[:, first] + cos * self.vertices[:, second]
        return Mesh(vertices, self.triangles, self.texture)


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of many."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]),
        np.concatenate([mesh.texture for mesh in meshes]),
    )


def grid(points: np.ndarray) -> Mesh:
    """Surface through a (rows, columns, 3) lattice of points."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    vertices = points.reshape(-1, 3).astype(float)
    return Mesh(vertices, triangles, vertices.copy())


def box(size: Sequence[float], bevel: float = 0.0, bulge: float = 0.0, steps: int = 4) -> Mesh:
    """Box centred at the origin, its edges rounded with radius `bevel`, its faces swollen by `bulge`."""
    half = np.asarray(size, float) / 2
    bevel = min(bevel, float(half.min()) * 0.999)
    inner = half - bevel
    middle = 12 if bulge else 2
    lines = []
    for extent, core in zip(half, inner, strict=True):
        if bevel == 0 and not bulge:
            lines.append(np.array([-extent, extent]))
            continue
        corner = core + bevel * np.tan(np.linspace(0, np.pi / 4, steps + 1))
        flat = np.linspace(-core, core, middle)
        lines.append(np.concatenate([-corner[:0:-1], flat, corner[1:]]))
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1, 1):
            points = np.empty((len(lines[u]), len(lines[v]), 3))
            points[..., u], points[..., v] = np.meshgrid(lines[u], lines[v], indexing="ij")
            points[..., axis] = sign * half[axis]
            if bevel:
                core = np.clip(points, -inner, inner)
                away = points - core
                points = core + bevel * away / np.linalg.norm(away, axis=-1, keepdims=True)
            face = grid(points if sign > 0 else points[::-1])
            faces.append(face)
    mesh = joined(faces)
    if not bulge:
        return mesh
    relative = mesh.vertices / half
    swell = np.ones((len(relative), 3))
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        swell[:, axis] += bulge / half[axis] * (1 - relative[:, u] ** 2) * (1 - relative[:, v] ** 2)
    return Mesh(mesh.vertices * swell, mesh.triangles, mesh.vertices)


def lathe(profile: Sequence[tuple[float, float]], segments: int = 48) -> Mesh:
    """Surface of revolution around y of a polyline of (radius, height); texture: angle, height, radius."""
    radius, height = np.asarray(profile, float).T
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    points = np.empty((len(radius), segments + 1, 3))
    points[..., 0] = radius[:, None] * np.cos(angle)
    points[..., 1] = height[:, None]
    points[..., 2] = radius[:, None] * np.sin(angle)
    mesh = grid(points)
    texture = np.empty_like(points)
    texture[..., 0], texture[..., 1], texture[..., 2] = angle, height[:, None], radius[:, None]
    return Mesh(mesh.vertices, mesh.triangles, texture.reshape(-1, 3))


def curve(points: Sequence[tuple[float, float]], count: int = 24) -> list[tuple[float, float]]:
    """Smooth polyline through points (Catmull-Rom), for lathe profiles and bent tubes."""
    p = np.asarray(points, float)
    p = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    out = []
    for i in range(1, len(p) - 2):
        t = np.linspace(0, 1, count // (len(p) - 3) + 1)[:-1, None]
        a, b, c, d = p[i - 1 : i + 3]
        out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return [tuple(q) for q in np.concatenate([*out, p[-2:-1]])]


def tube(path: Sequence[Sequence[float]], radius: float | Sequence[float], segments: int = 14) -> Mesh:
    """Round bar along a polyline, closed at both ends; `radius` may taper point by point."""
    points = np.asarray(path, float)
    radii = np.broadcast_to(np.asarray(radius, float), (len(points),))
    points = np.concatenate([points[:1], points, points[-1:]])
    radii = np.concatenate([[0.0], radii, [0.0]])
    tangent = np.gradient(points[1:-1], axis=0)
    tangent = np.concatenate([tangent[:1], tangent, tangent[-1:]])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    helper = np.eye(3)[np.argmin(np.abs(tangent).max(axis=0))]
    side = np.cross(tangent, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(tangent, side)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    ring = side[:, None] * np.cos(angle)[None, :, None] + other[:, None] * np.sin(angle)[None, :, None]
    return grid(points[:, None] + radii[:, None, None] * ring)


def ellipsoid(size: Sequence[float], segments: int = 24) -> Mesh:
    """Ellipsoid centred at the origin with the full axes `size`."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    mesh = lathe(list(zip(np.cos(angle) / 2, np.sin(angle) / 2, strict=True)), segments)
    vertices = mesh.vertices * np.asarray(size, float)
    return Mesh(vertices, mesh.triangles, vertices.copy())


def corner_normals(mesh: Mesh, crease: float = 40.0) -> np.ndarray:
    """Unit normal at every triangle corner, (T, 3, 3), smooth except across creases sharper than `crease` degrees."""
    corners = mesh.vertices[mesh.triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(face, axis=1, keepdims=True)
    unit = face / np.maximum(area, 1e-20)
    # Weld by position: generators repeat vertices along seams and poles.
    _, welded = np.unique(np.round(corners.reshape(-1, 3), 6), axis=0, return_inverse=True)
    welded = welded.reshape(-1)
    order = np.argsort(welded, kind="stable")
    counts = np.bincount(welded)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    repeats = counts[welded]
    one = np.repeat(np.arange(len(welded)), repeats)
    within = np.arange(len(one)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    two = order[np.repeat(starts[welded], repeats) + within]
    close = np.einsum("ij,ij->i", unit[one // 3], unit[two // 3]) > np.cos(np.radians(crease))
    total = np.zeros((len(welded), 3))
    for axis in range(3):
        total[:, axis] = np.bincount(one[close], face[two[close] // 3, axis], len(welded))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normals = np.where(length > 1e-20, total / np.maximum(length, 1e-20), np.repeat(unit, 3, axis=0))
    return normals.reshape(-1, 3, 3)
