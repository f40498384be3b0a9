"""Triangles of simple surfaces, with normals and texture coordinates in metres. World axes: x right, y up, z ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

CREASE = np.cos(np.radians(35.0))
"""Sides of a turned profile that meet at less than 35 degrees are one smooth surface."""


@dataclass(frozen=True)
class Shape:
    """Triangles of one or several smooth surfaces, which share no vertices.

    Parameters
    ----------
    vertices : ndarray (V, 3)
        Positions [m].
    normals : ndarray (V, 3)
        Unit length, either sign.
    uv : ndarray (V, 2)
        Texture coordinates [m].
    face : ndarray (V,)
        Number of the smooth surface that a vertex belongs to.
    triangles : ndarray (T, 3)
        Rows of vertices.
    owner : object, optional
        Shared by the shapes of one object; None = it is an object of its own.
    """

    vertices: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    face: np.ndarray
    triangles: np.ndarray
    owner: object | None = None

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Shape:
        return replace(self, vertices=self.vertices + np.array([x, y, z]))

    def turned(self, matrix: np.ndarray) -> Shape:
        return replace(self, vertices=self.vertices @ matrix.T, normals=self.normals @ matrix.T)

    def scaled(self, factor: float) -> Shape:
        return replace(self, vertices=self.vertices * factor, uv=self.uv * factor)

    @cached_property
    def low(self) -> np.ndarray:
        """Lowest coordinates (3,)."""
        return self.vertices.min(axis=0)

    @cached_property
    def high(self) -> np.ndarray:
        """Highest coordinates (3,)."""
        return self.vertices.max(axis=0)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors scaled to length 1, along the last axis."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    return vectors / np.maximum(length, 1e-12)[..., None]


def rotation(degrees: float, axis: str = "y") -> np.ndarray:
    """Matrix of a turn about one axis."""
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[first, first], matrix[first, second] = cos, -sin
    matrix[second, first], matrix[second, second] = sin, cos
    return matrix


def any_rotation(rng: np.random.Generator) -> np.ndarray:
    """Matrix of a turn drawn evenly among all."""
    matrix, upper = np.linalg.qr(rng.standard_normal((3, 3)))
    matrix *= np.sign(np.diag(upper))
    return matrix * np.linalg.det(matrix)


def joined(shapes: Sequence[Shape]) -> Shape:
    """One shape of many, whose faces stay apart."""
    faces, triangles, first_face, first_vertex = [], [], 0, 0
    for shape in shapes:
        faces.append(shape.face + first_face)
        triangles.append(shape.triangles + first_vertex)
        first_face += int(shape.face[-1]) + 1
        first_vertex += len(shape.vertices)
    return Shape(
        np.concatenate([s.vertices for s in shapes]),
        np.concatenate([s.normals for s in shapes]),
        np.concatenate([s.uv for s in shapes]),
        np.concatenate(faces),
        np.concatenate(triangles),
    )


@cache
def _lattice(count: int, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Faces and triangles of lattices of vertices."""
    index = np.arange(count * rows * columns).reshape(count, rows, columns)
    a, b, c, d = index[:, :-1, :-1], index[:, :-1, 1:], index[:, 1:, 1:], index[:, 1:, :-1]
    triangles = np.stack([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)], axis=-2).reshape(-1, 3)
    return np.repeat(np.arange(count), rows * columns), triangles


@cache
def _unit_box() -> Shape:
    points, uv = np.empty((6, 2, 2, 3)), np.empty((6, 2, 2, 2))
    normals = np.zeros((6, 2, 2, 3))
    square = np.array([[(-0.5, -0.5), (0.5, -0.5)], [(-0.5, 0.5), (0.5, 0.5)]])
    for axis, across in ((0, [2, 1]), (1, [0, 2]), (2, [0, 1])):
        for side in (0, 1):
            points[2 * axis + side, ..., axis] = side - 0.5
            points[2 * axis + side][..., across] = square
            normals[2 * axis + side, ..., axis] = 1
            uv[2 * axis + side] = across
    return sheets(points, normals, uv)


def box(size: Sequence[float]) -> Shape:
    """Box centred at the origin."""
    one = _unit_box()
    vertices = one.vertices * np.asarray(size, float)
    uv = np.take_along_axis(vertices, one.uv.astype(int), axis=1)
    return Shape(vertices, one.normals, uv, one.face, one.triangles)


def standing(size: Sequence[float]) -> Shape:
    """Box whose bottom is centred at the origin."""
    return box(size).moved(y=size[1] / 2)


def sheets(points: np.ndarray, normals: np.ndarray | None = None, uv: np.ndarray | None = None) -> Shape:
    """Smooth surfaces through lattices of points, (N, rows, columns, 3); each is a face of its own."""
    points = np.asarray(points, float)
    if normals is None:
        normals = unit(np.cross(np.gradient(points, axis=1), np.gradient(points, axis=2)))
    if uv is None:
        uv = np.stack([_walked(points, 2), _walked(points, 1)], axis=-1)
    face, triangles = _lattice(*points.shape[:3])
    return Shape(points.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), face, triangles)


def sheet(points: np.ndarray) -> Shape:
    """Smooth surface through one lattice of points, (rows, columns, 3)."""
    return sheets(points[None])


def _walked(points: np.ndarray, axis: int) -> np.ndarray:
    """Length walked along one axis of lattices."""
    difference = np.diff(points, axis=axis)
    steps = np.sqrt(np.einsum("...i,...i->...", difference, difference)).mean(axis=3 - axis, keepdims=True)
    walked = np.zeros(points.shape[:3])
    inner = (slice(None), slice(1, None)) if axis == 1 else (slice(None), slice(None), slice(1, None))
    walked[inner] = np.cumsum(steps, axis=axis)
    return walked


@cache
def _round(segments: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    return angle, np.cos(angle), np.sin(angle)


def lathe(profile: Sequence[tuple[float, float]], segments: int = 20) -> Shape:
    """Surface of revolution around y of a polyline of (radius, height), creased where the polyline is."""
    line = np.asarray(profile, float)
    steps = unit(np.diff(line, axis=0))
    sharp = np.flatnonzero((steps[1:] * steps[:-1]).sum(axis=1) < CREASE) + 1
    angle, cos, sin = _round(segments)
    walked = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    runs = []
    for first, last in zip([0, *sharp], [*sharp, len(line) - 1], strict=True):
        part, step = line[first : last + 1], steps[first:last]
        tangent = unit(np.concatenate([step[:1], step[1:] + step[:-1], step[-1:]]))
        points = _swept(part[:, 0], part[:, 1], cos, sin)
        normals = _swept(tangent[:, 1], -tangent[:, 0], cos, sin)
        flat = abs(step[:, 0].mean()) > 0.9
        if flat:
            uv = points[..., [0, 2]]
        else:
            around = angle[None] * max(part[:, 0].mean(), 1e-3)
            uv = np.stack(np.broadcast_arrays(around, walked[first : last + 1, None]), axis=-1)
        runs.append(sheets(points[None], normals[None], uv[None]))
    return joined(runs)


def _swept(radius: np.ndarray, height: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    points = np.empty((len(height), len(cos), 3))
    points[..., 0], points[..., 1], points[..., 2] = radius[:, None] * cos, height[:, None], radius[:, None] * sin
    return points


def bar(start: Sequence[float], end: Sequence[float], radius: float, radius_end: float | None = None) -> Shape:
    """Round bar with flat ends between two points; it may taper."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - start))
    last = radius if radius_end is None else radius_end
    upright = lathe([(0, 0), (radius, 0), (last, length), (0, length)], 10 if radius < 0.03 else 18)
    return upright.turned(_aimed(end - start)).moved(*start)


def beam(start: Sequence[float], end: Sequence[float], width: float, height: float) -> Shape:
    """Square bar between two points."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    upright = standing((width, float(np.linalg.norm(end - start)), height))
    return upright.turned(_aimed(end - start)).moved(*start)


def _aimed(towards: np.ndarray) -> np.ndarray:
    """Matrix that turns the y axis to a direction."""
    up = towards / max(float(np.linalg.norm(towards)), 1e-12)
    side = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    side /= np.linalg.norm(side)
    return np.stack([side, up, np.cross(side, up)], axis=1)


def wire(path: np.ndarray, radius: float, segments: int = 7) -> Shape:
    """Bent round bar along a smooth path (P, 3), open at its ends."""
    path = np.asarray(path, float)
    tangent = unit(np.gradient(path, axis=0))
    helper = np.eye(3)[np.argmin(np.abs(tangent).max(axis=0))]
    side = unit(np.cross(tangent, helper))
    other = np.cross(tangent, side)
    _, cos, sin = _round(segments)
    ring = side[:, None] * cos[None, :, None] + other[:, None] * sin[None, :, None]
    return sheets((path[:, None] + radius * ring)[None], ring[None])


def ball(size: Sequence[float], power: float = 1.0, rows: int = 10, columns: int = 18) -> Shape:
    """Rounded body centred at the origin; `power` 1 is an ellipsoid, towards 0 a box with rounded edges."""
    up, around = np.linspace(-np.pi / 2, np.pi / 2, rows + 1), np.linspace(-np.pi, np.pi, columns + 1)
    if power < 0.8:
        up, around = _denser(up, np.pi / 2), _denser(around, np.pi / 4)

    def bent(x: np.ndarray, exponent: float) -> np.ndarray:
        return np.sign(x) * np.abs(x) ** exponent

    def body(exponent: float) -> np.ndarray:
        ring, rise = bent(np.cos(up), exponent), bent(np.sin(up), exponent)
        return _swept(ring, rise, bent(np.cos(around), exponent), bent(np.sin(around), exponent))

    half = np.asarray(size, float) / 2
    return sheets((body(power) * half)[None], unit(body(2 - power) / half)[None])


def _denser(angle: np.ndarray, spacing: float) -> np.ndarray:
    """Angles moved away from multiples of `spacing` towards the corners half-way, where a rounded box bends."""
    turn = angle / spacing
    return spacing * (turn + 0.09 * np.sin(2 * np.pi * turn))


def lump(size: Sequence[float], roughness: float, rng: np.random.Generator) -> Shape:
    """Stone, bush or crumpled cloth: an ellipsoid with waves of random direction."""
    smooth = ball(size, rows=14, columns=22)
    ways, phases = rng.normal(0, 9, (3, 6)), rng.uniform(0, 6, 6)
    wave = np.sin(smooth.vertices / np.max(size) @ ways + phases).mean(axis=1)
    points = smooth.vertices * (1 + roughness * wave[:, None])
    return sheets(points.reshape(1, 15, 23, 3), uv=smooth.uv)


def prism(outline: np.ndarray, height: float) -> Shape:
    """Convex outline (P, 2) in x and z, raised by `height` from the floor."""
    low = np.insert(np.asarray(outline, float), 1, 0.0, axis=1)
    following, up = np.roll(low, -1, axis=0), np.array([0.0, height, 0.0])
    walls = np.stack([np.stack([low, following], axis=1), np.stack([low + up, following + up], axis=1)], axis=1)
    rim = np.concatenate([low, low[:1]])
    lid = np.stack([np.broadcast_to(low.mean(axis=0), rim.shape), rim])
    upright = np.broadcast_to([0.0, 1.0, 0.0], lid[None].shape).copy()
    return joined([sheets(walls), *(sheets(lid[None] + at, upright, lid[..., [0, 2]]) for at in (0 * up, up))])
