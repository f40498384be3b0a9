"""Writing meshes as PLY, OBJ and GLB, part by part."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.writing import write_parts
from ..data.points import axes_signs
from ..data.surface import Mesh
from ..errors import ExportError, check_kind, check_path
from .clouds import COLOURED_LINE, coloured, lines_of, pieces, ply_parts, rows_of

# Meshes as Wavefront OBJ: text, with colours after the coordinates, as MeshLab and Blender read them.


def obj_parts(mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> Iterator[bytes]:
    """Yield an OBJ file, part by part: a line v x y z red green blue (0-1) for each vertex, vn if there are normals,
    and f for each triangle. The format does not support scalars."""
    yield f"# ILF Studio\n# unit {unit}, axes {axes}\n".encode()
    rows, has_normals = rows_of(mesh.vertices, axes, unit), mesh.vertices.normals is not None
    for part in pieces(rows):
        yield lines_of(coloured(part), f"v {COLOURED_LINE}")
    for part in pieces(rows) if has_normals else ():
        yield lines_of(part[["nx", "ny", "nz"]], "vn %.6g %.6g %.6g")
    corner = "%d//%d" if has_normals else "%d"
    for some in pieces(mesh.faces):
        yield lines_of(np.repeat(some + 1, 2 if has_normals else 1, axis=1), f"f {corner} {corner} {corner}")


# Meshes as binary glTF 2.0 (GLB), which browsers, Blender and most viewers open.

_VERTICES, _INDICES = 34962, 34963
_NUMBERS = {"<f4": 5126, "<u2": 5123, "<u4": 5125}
"""Type of the numbers of an array -> its code."""
_ELEMENTS = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4"}
"""Shape of the elements of an array -> its name."""


def glb_parts(mesh: Mesh) -> Iterator[bytes]:
    """Yield a GLB file, part by part; always in metres with y up, as the format requires.

    Colours are linear in GLB, so they are stored with 16 bits to preserve their values. Scalars are attributes of the
    vertices, such as _EXPECTED_ERROR. The material is unlit and double-sided: the colours contain the lighting already.
    """
    vertices, signs = mesh.vertices, np.array(axes_signs("y-up"), np.float32)
    arrays: dict[str, NDArray[Any]] = {"POSITION": vertices.points * signs}
    if vertices.normals is not None:
        arrays["NORMAL"] = vertices.normals * signs
    arrays["COLOR_0"] = np.pad(_LINEAR[vertices.colours], ((0, 0), (0, 1)), constant_values=0xFFFF)
    arrays |= {f"_{name.upper()}": values.astype("<f4") for name, values in vertices.scalars.items()}
    arrays["indices"] = mesh.faces.reshape(-1).astype("<u4")
    described, length = _description(arrays)
    yield struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(described) + 8 + length)
    yield struct.pack("<I4s", len(described), b"JSON") + described
    yield struct.pack("<I4s", length, b"BIN\0")
    for values in arrays.values():
        yield from (some.tobytes() for some in pieces(values))


def _description(arrays: Mapping[str, NDArray[Any]]) -> tuple[bytes, int]:
    """The file's JSON, padded to multiples of 4 bytes, and the number of bytes of all arrays."""
    offset = 0
    views, accessors = [], []
    for number, (name, values) in enumerate(arrays.items()):
        target = _INDICES if name == "indices" else _VERTICES
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": values.nbytes, "target": target})
        kind, element = _NUMBERS[values.dtype.newbyteorder("<").str], _ELEMENTS[values.shape[1:]]
        accessors.append({"bufferView": number, "componentType": kind, "count": len(values), "type": element})
        offset += values.nbytes
    accessors[0] |= {"min": arrays["POSITION"].min(axis=0).tolist(), "max": arrays["POSITION"].max(axis=0).tolist()}
    attributes = {name: number for number, name in enumerate(arrays)}
    accessors[attributes["COLOR_0"]] |= {"normalized": True}
    primitive = {"attributes": attributes, "indices": attributes.pop("indices"), "material": 0, "mode": 4}
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
        "bufferViews": views,
        "buffers": [{"byteLength": offset}],
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    return text + b" " * (-len(text) % 4), offset


def _linear_of(values: NDArray[np.integer]) -> NDArray[np.uint16]:
    """Convert 8-bit sRGB values (IEC 61966-2-1) to linear light, in 16 bits."""
    share = values / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.rint(0xFFFF * light).astype(np.uint16)


_LINEAR = _linear_of(np.arange(256))


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
    check_path(path)
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
