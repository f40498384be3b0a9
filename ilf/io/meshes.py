"""Writing meshes as PLY, OBJ and GLB, part by part."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.writing import write_parts
from ..data.points import axes_signs
from ..data.surface import Mesh
from ..errors import ExportError, check_kind, path_first
from .clouds import COLOURED_LINE, coloured, lines_of, ply_parts, rows_of, triangles_of

# Meshes as Wavefront OBJ: text, with colours after the coordinates, as MeshLab and Blender read them.

_AT_ONCE = 1 << 16  # vertices


def obj_parts(mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> Iterator[bytes]:
    """Yield an OBJ file, part by part: a line v x y z red green blue (0-1) for each vertex, vn if there are normals,
    and f for each triangle. The format does not support scalars."""
    yield f"# ILF Studio\n# unit {unit}, axes {axes}\n".encode()
    for rows in rows_of(mesh.vertices, axes, unit):
        yield lines_of(coloured(rows), f"v {COLOURED_LINE}")
    has_normals = mesh.vertices.normals is not None
    for rows in rows_of(mesh.vertices, axes, unit) if has_normals else ():
        yield lines_of(rows[["nx", "ny", "nz"]], "vn %.6g %.6g %.6g")
    corner = "%d//%d" if has_normals else "%d"
    for some in triangles_of(mesh.faces):
        yield lines_of(np.repeat(some + 1, 2 if has_normals else 1, axis=1), f"f {corner} {corner} {corner}")


# Meshes as binary glTF 2.0 (GLB), which browsers, Blender and most viewers open.

_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
_DTYPES: dict[int, np.dtype[Any]] = {_FLOAT: np.dtype("<f4"), _UINT16: np.dtype("<u2"), _UINT32: np.dtype("<u4")}

_View = tuple[NDArray[Any], str, int, dict[str, Any]]
"""An array of the file, the types of its elements and of their numbers, and more that describes it."""


def glb_parts(mesh: Mesh) -> Iterator[bytes]:
    """Yield a GLB file, part by part; always in metres with y up, as the format requires.

    Colours are linear in GLB, so they are stored with 16 bits to preserve their values. Scalars are attributes of the
    vertices, such as _EXPECTED_ERROR. The material is unlit and double-sided: the colours contain the lighting already.
    """
    vertices = mesh.vertices
    signs = np.array(axes_signs("y-up"), np.float32)
    low, high = vertices.points.min(axis=0) * signs, vertices.points.max(axis=0) * signs
    extent = {"min": np.minimum(low, high).tolist(), "max": np.maximum(low, high).tolist()}
    views: dict[str, _View] = {"POSITION": (vertices.points, "VEC3", _FLOAT, extent)}
    if vertices.normals is not None:
        views["NORMAL"] = vertices.normals, "VEC3", _FLOAT, {}
    views["COLOR_0"] = vertices.colours, "VEC4", _UINT16, {"normalized": True}
    views |= {f"_{name.upper()}": (values, "SCALAR", _FLOAT, {}) for name, values in vertices.scalars.items()}
    described, length = _description(views, (mesh.faces.reshape(-1), "SCALAR", _UINT32, {}))
    yield struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(described) + 8 + length)
    yield struct.pack("<I4s", len(described), b"JSON") + described
    yield struct.pack("<I4s", length, b"BIN\0")
    for name, (values, _, kind, _) in views.items():
        for start in range(0, len(values), _AT_ONCE):
            some = values[start : start + _AT_ONCE]
            if name == "COLOR_0":
                some = np.pad(_LINEAR[some], ((0, 0), (0, 1)), constant_values=0xFFFF)
            elif name in {"POSITION", "NORMAL"}:
                some = some * signs
            yield some.astype(_DTYPES[kind]).tobytes()
    for triangles in triangles_of(mesh.faces):
        yield triangles.astype(_DTYPES[_UINT32]).tobytes()


def _description(views: dict[str, _View], indices: _View) -> tuple[bytes, int]:
    """The file's JSON, padded to multiples of 4 bytes, and the number of bytes of all arrays."""
    offset = 0
    buffer_views, accessors = [], []
    for number, (values, shape, kind, more) in enumerate([*views.values(), indices]):
        size = len(values) * _WIDTHS[shape] * _DTYPES[kind].itemsize
        target = _INDICES if number == len(views) else _VERTICES
        buffer_views.append({"buffer": 0, "byteOffset": offset, "byteLength": size, "target": target})
        accessors.append({"bufferView": number, "componentType": kind, "count": len(values), "type": shape, **more})
        offset += size
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
    return text + b" " * (-len(text) % 4), offset


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
