"""Readers of PLY, PCD, OBJ and GLB by their specifications, independent of the writers."""

import json
import struct
from pathlib import Path

import numpy as np

_PLY_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1"}


def read_ply(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """Vertices, one array with a field per property, and faces (M, 3) or None."""
    header, _, body = path.read_bytes().partition(b"end_header\n")
    lines = [line.split() for line in header.decode("ascii").splitlines()]
    assert lines[0] == ["ply"]
    (form,) = (line[1] for line in lines if line[0] == "format")
    counts = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
    fields = [(line[2], _PLY_TYPES[line[1]]) for line in lines if line[0] == "property" and line[1] != "list"]
    lists = [line[1:] for line in lines if line[0] == "property" and line[1] == "list"]
    assert list(counts) == ["vertex", "face"][: len(counts)]
    assert lists == ([["list", "uchar", "int", "vertex_indices"]] if "face" in counts else [])
    count, faces = counts["vertex"], counts.get("face")
    if form == "ascii":
        rows = [tuple(line.split()) for line in body.decode("ascii").splitlines()]
        assert len(rows) == count + (faces or 0)
        return np.array(rows[:count], fields), None if faces is None else np.array(rows[count:], int)[:, 1:]
    assert form == "binary_little_endian"
    dtype, face = np.dtype(fields), np.dtype([("n", "u1"), ("v", "<i4", 3)])
    assert len(body) == count * dtype.itemsize + (faces or 0) * face.itemsize
    vertices = np.frombuffer(body, dtype, count)
    if faces is None:
        return vertices, None
    triangles = np.frombuffer(body, face, faces, count * dtype.itemsize)
    assert (triangles["n"] == 3).all()
    return vertices, triangles["v"]


def read_pcd(path: Path) -> np.ndarray:
    """One array with a field per field, rgb as uint32."""
    content = path.read_bytes()
    start = content.index(b"DATA ")
    header, body = content[:start].decode("ascii"), content[content.index(b"\n", start) + 1 :]
    told = {line.split()[0]: line.split()[1:] for line in header.splitlines() if not line.startswith("#")}
    assert (told["VERSION"], told["VIEWPOINT"]) == (["0.7"], [*"0001000"])
    assert [str(int(told["HEIGHT"][0]) * int(told["WIDTH"][0]))] == told["POINTS"]
    assert set(told["SIZE"]) == {"4"}
    assert set(told["TYPE"]) == {"F"}
    assert set(told["COUNT"]) == {"1"}
    assert len(told["FIELDS"]) == len(told["SIZE"]) == len(told["TYPE"]) == len(told["COUNT"])
    fields = [(name, "<f4") for name in told["FIELDS"]]
    if content[start:].startswith(b"DATA ascii\n"):
        rows = np.array([tuple(line.split()) for line in body.decode("ascii").splitlines()], fields)
    else:
        assert content[start:].startswith(b"DATA binary\n")
        rows = np.frombuffer(body, fields)
    assert [str(len(rows))] == told["POINTS"]
    return rows.view([(name, "<u4" if name == "rgb" else "<f4") for name in told["FIELDS"]])


def read_obj(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (N, 3), colours (N, 3) 0-1, normals (N, 3), faces (M, 3) from 0 on; one normal per vertex."""
    lines = [line.split() for line in path.read_text("ascii").splitlines() if not line.startswith("#")]
    vertices = np.array([line[1:] for line in lines if line[0] == "v"], float)
    normals = np.array([line[1:] for line in lines if line[0] == "vn"], float)
    corners = [[corner.split("//") for corner in line[1:]] for line in lines if line[0] == "f"]
    assert all(len(set(corner)) == 1 for face in corners for corner in face)  # a vertex has its own normal
    faces = np.array([[int(corner[0]) for corner in face] for face in corners])
    return vertices[:, :3], vertices[:, 3:], normals, faces - 1


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
