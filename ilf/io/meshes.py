"""Writing meshes as PLY, OBJ and GLB, part by part."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.writing import write_parts
from ..data.points import axes_signs
from ..data.surface import Mesh
from ..errors import ExportError, check_kind, path_first
from .clouds import columns_of, ply_parts, text_rows

# Meshes as Wavefront OBJ: text, with colours after the coordinates, as MeshLab and Blender read them.

_AT_ONCE = 1 << 16  # triangles


def obj_parts(mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> Iterator[bytes]:
    """Yield an OBJ file, part by part: a line v x y z red green blue (0-1) for each vertex, vn if there are normals,
    and f for each triangle. The format does not support scalars."""
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


# Meshes as binary glTF 2.0 (GLB), which browsers, Blender and most viewers open.

_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True, eq=False)
class _View:
    """An array of the file with its description."""

    values: NDArray[Any]
    shape: str
    kind: int
    target: int = _VERTICES
    more: dict[str, Any] | None = None

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype({_FLOAT: "<f4", _UINT16: "<u2", _UINT32: "<u4"}[self.kind])

    @property
    def count(self) -> int:
        return self.values.size if self.target == _INDICES else len(self.values)

    @property
    def bytes(self) -> int:
        return self.count * _WIDTHS[self.shape] * self.dtype.itemsize


def glb_parts(mesh: Mesh) -> Iterator[bytes]:
    """Yield a GLB file, part by part; always in metres with y up, as the format requires.

    Colours are linear in GLB, so they are stored with 16 bits to preserve their values. Scalars are attributes of the
    vertices, such as _EXPECTED_ERROR. The material is unlit and double-sided: the colours contain the lighting already.
    """
    vertices = mesh.vertices
    signs = np.array(axes_signs("y-up"), np.float32)
    low, high = vertices.points.min(axis=0) * signs, vertices.points.max(axis=0) * signs
    extent = {"min": np.minimum(low, high).tolist(), "max": np.maximum(low, high).tolist()}
    views = {"POSITION": _View(vertices.points, "VEC3", _FLOAT, more=extent)}
    if vertices.normals is not None:
        views["NORMAL"] = _View(vertices.normals, "VEC3", _FLOAT)
    views["COLOR_0"] = _View(vertices.colours, "VEC4", _UINT16, more={"normalized": True})
    for name, values in vertices.scalars.items():
        views[f"_{name.upper()}"] = _View(values, "SCALAR", _FLOAT)
    indices = _View(mesh.faces, "SCALAR", _UINT32, _INDICES)
    described = _description(views, indices)
    length = sum(view.bytes for view in (*views.values(), indices))
    yield struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(described) + 8 + length)
    yield struct.pack("<I4s", len(described), b"JSON") + described
    yield struct.pack("<I4s", length, b"BIN\0")
    for name, view in (*views.items(), ("", indices)):
        for start in range(0, len(view.values), _AT_ONCE):
            some = view.values[start : start + _AT_ONCE]
            if name == "COLOR_0":
                some = _with_alpha(_LINEAR[some])
            elif name in {"POSITION", "NORMAL"}:
                some = some * signs
            yield some.astype(view.dtype).tobytes()


def _description(views: dict[str, _View], indices: _View) -> bytes:
    """Return the file's JSON, padded to multiples of 4 bytes."""
    every, offset = [*views.values(), indices], 0
    buffer_views, accessors = [], []
    for number, view in enumerate(every):
        buffer_views.append({"buffer": 0, "byteOffset": offset, "byteLength": view.bytes, "target": view.target})
        accessor = {"bufferView": number, "componentType": view.kind, "count": view.count, "type": view.shape}
        accessors.append({**accessor, **(view.more or {})})
        offset += view.bytes
    attributes = {name: number for number, name in enumerate(views)}
    primitive = {"attributes": attributes, "indices": len(views), "material": 0, "mode": 4}
    content = {
        "asset": {"version": "2.0", "generator": "ILF Studio"},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [
            {
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1},
                "doubleSided": True,
                "extensions": {"KHR_materials_unlit": {}},
            }
        ],
        "accessors": accessors,
        "bufferViews": buffer_views,
        "buffers": [{"byteLength": offset}],
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    return text + b" " * (-len(text) % 4)


def _with_alpha(colours: NDArray[np.uint16]) -> NDArray[np.uint16]:
    return np.concatenate([colours, np.full((len(colours), 1), 0xFFFF, np.uint16)], axis=1)


def _linear_of(values: Sequence[int]) -> NDArray[np.uint16]:
    """Convert 8-bit sRGB values (IEC 61966-2-1) to linear light, in 16 bits."""
    share = np.asarray(values) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.rint(0xFFFF * light).astype(np.uint16)


_LINEAR = _linear_of(range(256))


MESH_SUFFIXES = (".ply", ".obj", ".glb")
"""Suffixes that `write_mesh` supports."""


def write_mesh(path: str | os.PathLike[str], mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> None:
    """Write a mesh atomically, in the format given by the suffix.

    Parameters
    ----------
    path : path-like
        .ply (with all scalars of the vertices), .obj (without scalars) or .glb.
    mesh : Mesh
        In camera axes.
    axes, unit : str
        As for `write_cloud`. A .glb is always in metres with y up, as the format requires.

    Raises
    ------
    ExportError
        For another suffix, a mesh without triangles, or if the file cannot be written.
    ParameterError
        For unknown axes or units.

    Examples
    --------
    >>> from ilf import Camera, surface_mesh
    >>> camera = Camera(100.0, 100.0, 1.0, 0.5)
    >>> write_mesh("mesh.obj", surface_mesh(np.ones((2, 3)), np.zeros((2, 3, 3), np.uint8), camera))
    >>> Path("mesh.obj").read_text().count("f ")
    4
    """
    path, mesh = path_first(path, mesh)
    check_kind(mesh, Mesh, "A mesh is written from a surface", "give what ilf.surface_mesh returns.")
    suffix = Path(path).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise ExportError(f"A mesh cannot be written as {str(path)!r}: use one of {', '.join(MESH_SUFFIXES)}.")
    if len(mesh) == 0:
        raise ExportError("The mesh has no triangles to write: no neighbouring pixels have depth on one surface.")
    if suffix == ".glb":
        parts = glb_parts(mesh)
    elif suffix == ".obj":
        parts = obj_parts(mesh, axes=axes, unit=unit)
    else:
        parts = ply_parts(mesh.vertices, mesh.faces, axes=axes, unit=unit)
    write_parts(path, parts)
