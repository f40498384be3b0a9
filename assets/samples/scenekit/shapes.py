"""Triangles of simple surfaces, with normals and texture coordinates in metres. World axes: x right, y up, z ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

CREASE = np.cos(np.radians(35.0))
"""Sides of a turned profile that meet at less than 35 degrees are one smooth surface."""


@dataclass(frozen=True)
class Shape:
    """Triangles that share no vertices.

    Parameters
    ----------
    corners : ndarray (T, 3, 3)
        Positions [m].
    normals : ndarray (T, 3, 3)
        Smooth normals at the corners, unit length, either sign.
    uv : ndarray (T, 3, 2)
        Texture coordinates [m].
    face : ndarray (T,)
        Number of the smooth surface that a triangle belongs to.
    """

    corners: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    face: np.ndarray

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Shape:
        return Shape(self.corners + np.array([x, y, z]), self.normals, self.uv, self.face)

    def turned(self, matrix: np.ndarray) -> Shape:
        return Shape(self.corners @ matrix.T, self.normals @ matrix.T, self.uv, self.face)


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
    faces, first = [], 0
    for shape in shapes:
        faces.append(shape.face + first)
        first += int(shape.face.max()) + 1
    return Shape(
        np.concatenate([s.corners for s in shapes]),
        np.concatenate([s.normals for s in shapes]),
        np.concatenate([s.uv for s in shapes]),
        np.concatenate(faces),
    )


def _unit_box() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    corners, normals, flat = [], [], []
    for axis, (u, v) in ((0, (2, 1)), (1, (0, 2)), (2, (0, 1))):
        for sign in (-0.5, 0.5):
            square = np.full((4, 3), sign)
            square[:, [u, v]] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            corners += [square[[0, 1, 2]], square[[0, 2, 3]]]
            normals += [np.tile(np.eye(3)[axis], (3, 1))] * 2
            flat += [(u, v)] * 2
    return np.array(corners), np.array(normals), np.array(flat), np.repeat(np.arange(6), 2)


_BOX = _unit_box()


def box(size: Sequence[float]) -> Shape:
    """Box centred at the origin."""
    corners, normals, axes, face = _BOX
    corners = corners * np.asarray(size, float)
    uv = np.take_along_axis(corners, np.broadcast_to(axes[:, None, :], (12, 3, 2)), axis=2)
    return Shape(corners, normals, uv, face)


def standing(size: Sequence[float]) -> Shape:
    """Box whose bottom is centred at the origin."""
    return box(size).moved(y=size[1] / 2)


def sheets(points: np.ndarray, normals: np.ndarray | None = None, uv: np.ndarray | None = None) -> Shape:
    """Smooth surfaces through lattices of points, (N, rows, columns, 3); each is a face of its own."""
    points = np.asarray(points, float)
    if normals is None:
        along, across = np.gradient(points, axis=1), np.gradient(points, axis=2)
        normals = np.cross(along, across)
        normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    if uv is None:
        uv = np.stack([_walked(points, 2), _walked(points, 1)], axis=-1)
    triangles = []
    for values in (points, normals, np.broadcast_to(uv, (*points.shape[:3], 2))):
        a, b, c, d = values[:, :-1, :-1], values[:, :-1, 1:], values[:, 1:, 1:], values[:, 1:, :-1]
        both = np.stack([np.stack([a, b, c], axis=3), np.stack([a, c, d], axis=3)], axis=3)
        triangles.append(both.reshape(-1, 3, values.shape[-1]))
    count = len(triangles[0]) // len(points)
    return Shape(*triangles, np.repeat(np.arange(len(points)), count))


def sheet(points: np.ndarray) -> Shape:
    """Smooth surface through one lattice of points, (rows, columns, 3)."""
    return sheets(points[None])


def _walked(points: np.ndarray, axis: int) -> np.ndarray:
    """Length walked along one axis of a lattice."""
    steps = np.linalg.norm(np.diff(points, axis=axis), axis=-1).mean(axis=3 - axis, keepdims=True)
    walked = np.concatenate([np.zeros_like(steps.take([0], axis)), np.cumsum(steps, axis=axis)], axis=axis)
    return np.broadcast_to(walked, points.shape[:3])


def lathe(profile: Sequence[tuple[float, float]], segments: int = 20) -> Shape:
    """Surface of revolution around y of a polyline of (radius, height), creased where the polyline is."""
    line = np.asarray(profile, float)
    steps = np.diff(line, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    sharp = np.flatnonzero((steps[1:] * steps[:-1]).sum(axis=1) < CREASE) + 1
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    height_walked = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    runs = []
    for first, last in zip([0, *sharp], [*sharp, len(line) - 1], strict=True):
        part, step = line[first : last + 1], steps[first:last]
        tangent = np.concatenate([step[:1], step[1:] + step[:-1], step[-1:]])
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
        points = _swept(part[:, 0], part[:, 1], cos, sin)
        normals = _swept(tangent[:, 1], -tangent[:, 0], cos, sin)
        flat = abs(step[:, 0].mean()) > 0.9
        if flat:
            uv = points[..., [0, 2]]
        else:
            around = np.broadcast_to(angle * max(part[:, 0].mean(), 1e-3), points.shape[:2])
            uv = np.stack([around, np.broadcast_to(height_walked[first : last + 1, None], points.shape[:2])], axis=-1)
        runs.append(sheets(points[None], normals[None], uv[None]))
    return joined(runs)


def _swept(radius: np.ndarray, height: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    rows = np.broadcast_to(height[:, None], (len(height), len(cos)))
    return np.stack([radius[:, None] * cos, rows, radius[:, None] * sin], axis=-1)


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
    tangent = np.gradient(path, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    helper = np.eye(3)[np.argmin(np.abs(tangent).max(axis=0))]
    side = np.cross(tangent, helper)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    other = np.cross(tangent, side)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    ring = side[:, None] * np.cos(angle)[None, :, None] + other[:, None] * np.sin(angle)[None, :, None]
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
    normals = body(2 - power) / half
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    return sheets((body(power) * half)[None], normals[None])


def _denser(angle: np.ndarray, spacing: float) -> np.ndarray:
    """Angles moved away from multiples of `spacing` towards the corners half-way, where a rounded box bends."""
    turn = angle / spacing
    return spacing * (turn + 0.09 * np.sin(2 * np.pi * turn))


def lump(size: Sequence[float], roughness: float, rng: np.random.Generator) -> Shape:
    """Stone, bush or crumpled cloth: an ellipsoid with waves of random direction."""
    points = ball(size, rows=14, columns=22).corners
    wave = np.zeros(points.shape[:2])
    for _ in range(6):
        wave += np.sin((points / np.max(size)) @ rng.normal(0, 9, 3) + rng.uniform(0, 6)) / 6
    corners = points * (1 + roughness * wave[..., None])
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    smooth = ball(size, rows=14, columns=22)
    return Shape(corners, np.repeat(flat[:, None], 3, axis=1), smooth.uv, smooth.face)


def prism(outline: np.ndarray, height: float) -> Shape:
    """Convex outline (P, 2) in x and z, raised by `height` from the floor."""
    low = np.insert(np.asarray(outline, float), 1, 0.0, axis=1)
    high = low + (0, height, 0)
    following = np.roll(low, -1, axis=0)
    walls = np.stack([np.stack([low, following], axis=1), np.stack([high, following + (0, height, 0)], axis=1)], axis=1)
    middle = low.mean(axis=0)
    lids = []
    for y in (0.0, height):
        rim = np.concatenate([low, low[:1]]) + (0, y, 0)
        lid = np.stack([np.broadcast_to(middle + (0, y, 0), rim.shape), rim])
        lids.append(sheets(lid[None], np.broadcast_to([0.0, 1.0, 0.0], lid[None].shape), lid[None][..., [0, 2]]))
    return joined([sheets(walls), *lids])
