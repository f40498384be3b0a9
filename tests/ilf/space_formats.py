"""Readers of PLY, PCD and OBJ by Open3D, and of GLB by its specification: independent of the writers."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from ilf.data.open3d_images import load_open3d


def read_points(path: Path) -> dict[str, np.ndarray]:
    """Points of a PLY or PCD, vertices of a mesh in PLY: positions, colors and normals (N, 3), scalars (N,)."""
    found = load_open3d().t.io.read_point_cloud(str(path)).point
    arrays = {name: values.numpy() for name, values in found.items()}
    return {name: values[:, 0] if values.shape[1] == 1 else values for name, values in arrays.items()}


def read_mesh(path: Path) -> Any:
    """A mesh of Open3D."""
    return load_open3d().io.read_triangle_mesh(str(path))


def read_glb(path: Path) -> tuple[dict, dict[str, np.ndarray], np.ndarray]:
    """JSON, attributes by name, faces (M, 3)."""
    content = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content))
    described, kind = struct.unpack_from("<I4s", content, 12)
    assert kind == b"JSON"
    assert described % 4 == 0
    told = json.loads(content[20 : 20 + described])
    size, kind = struct.unpack_from("<I4s", content, 20 + described)
    assert kind == b"BIN\0"
    body = content[28 + described :]
    assert len(body) == size == told["buffers"][0]["byteLength"]
    assert size % 4 == 0

    def array(number: int) -> np.ndarray:
        accessor = told["accessors"][number]
        view = told["bufferViews"][accessor["bufferView"]]
        dtype = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == accessor["count"] * width * np.dtype(dtype).itemsize
        found = np.frombuffer(body, dtype, accessor["count"] * width, view["byteOffset"])
        return found if width == 1 else found.reshape(-1, width)

    (primitive,) = told["meshes"][0]["primitives"]
    assert primitive["mode"] == 4
    attributes = {name: array(number) for name, number in primitive["attributes"].items()}
    return told, attributes, array(primitive["indices"]).reshape(-1, 3)
