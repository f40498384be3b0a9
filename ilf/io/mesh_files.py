"""Meshes as PLY, OBJ and GLB, part by part."""

from __future__ import annotations

import os
from pathlib import Path

from ..cloud import Mesh
from ..errors import ExportError
from .atomic import write_parts
from .glb_files import glb_parts
from .obj_files import obj_parts
from .ply_files import ply_parts

MESH_SUFFIXES = (".ply", ".obj", ".glb")
"""Suffixes that `write_mesh` knows."""


def write_mesh(path: str | os.PathLike[str], mesh: Mesh, *, axes: str = "camera", unit: str = "m") -> None:
    """Write a mesh atomically, in the format that the suffix names.

    Parameters
    ----------
    path : path-like
        .ply (with all that is known of the vertices), .obj (without scalars) or .glb.
    mesh : Mesh
        In camera axes.
    axes, unit : str
        As `write_cloud` takes them. A .glb is in metres with y up whatever they are, as the format has it.

    Raises
    ------
    ExportError
        For another suffix, a mesh without triangles, or if the file cannot be written.
    ParameterError
        For unknown axes or units.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise ExportError(f"A mesh cannot be written as {str(path)!r}: use one of {', '.join(MESH_SUFFIXES)}.")
    if len(mesh) == 0:
        raise ExportError("The mesh has no triangle to write: no neighbouring pixels have depth on one surface.")
    if suffix == ".glb":
        parts = glb_parts(mesh)
    elif suffix == ".obj":
        parts = obj_parts(mesh, axes=axes, unit=unit)
    else:
        parts = ply_parts(mesh.vertices, mesh.faces, axes=axes, unit=unit)
    write_parts(path, parts)
