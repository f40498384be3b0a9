"""Meshes as Wavefront OBJ: text, with colours behind the coordinates as MeshLab and Blender read them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..cloud import Mesh
from .columns import columns_of, text_rows

_AT_ONCE = 1 << 16  # triangles


def obj_parts(mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> Iterator[bytes]:
    """An OBJ file, part by part: a line v x y z red green blue (0-1) for each vertex, vn where there are normals, and f
    for each triangle. It has no place for scalars."""
    parts = columns_of(mesh.vertices, axes, unit)
    yield f"# ILF Studio\n# unit {unit}, axes {axes}\n".encode()
    colours = [replace(column, factor=1 / 255, kind="<f4") for column in parts.colours]
    yield from text_rows([*parts.points, *colours], "v ", ["%.9g"] * 3 + ["%.6g"] * 3)
    if parts.normals:
        yield from text_rows(parts.normals, "vn ", ["%.6g"] * 3)
    corner = "%d//%d" if parts.normals else "%d"
    line = f"f {corner} {corner} {corner}\n"
    for start in range(0, len(mesh.faces), _AT_ONCE):
        some = mesh.faces[start : start + _AT_ONCE]
        numbers = np.repeat(some.reshape(-1) + 1, 2 if parts.normals else 1)
        yield (line * len(some) % tuple(numbers.tolist())).encode()
