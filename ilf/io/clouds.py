"""Writing point clouds as PLY, PCD and XYZ, part by part, so that text and other columns of a large one stay small."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.writing import write_parts
from ..data.points import LENGTHS, PointCloud, axes_signs
from ..errors import ExportError, ParameterError, check_kind, check_path

# The points of a cloud as rows, from which file formats take columns in different orders.

UNITS_PER_METRE = {"m": 1.0, "mm": 1000.0}

_AT_ONCE = 1 << 16  # points or triangles

_COLOURS = "red", "green", "blue"

SHOWN_BY_MESHLAB = "expected_error"
"""The scalar also written as quality, the only one that MeshLab uses for colouring."""

_EXACT = "%.9g"
"""Format with enough digits to restore every float32 exactly."""


def rows_of(cloud: PointCloud, axes: str, unit: str) -> NDArray[np.void]:
    """The points as records, in the axes and unit of the file: x, y, z; nx, ny, nz if there are normals; red, green,
    blue, uint8; and the scalars under names that CloudCompare and MeshLab recognise, scalar_NAME and quality.

    Raises
    ------
    ParameterError
        For unknown axes or units.
    """
    if unit not in UNITS_PER_METRE:
        raise ParameterError(f"unit must be one of {', '.join(UNITS_PER_METRE)}, not {unit!r}.")
    scale, signs = UNITS_PER_METRE[unit], axes_signs(axes)
    columns: dict[str, tuple[NDArray[Any], float]] = {}
    for prefix, vectors, factor in (("", cloud.points, scale), ("n", cloud.normals, 1.0)):
        if vectors is not None:
            columns |= {f"{prefix}{'xyz'[i]}": (vectors[:, i], factor * signs[i]) for i in range(3)}
    columns |= {name: (cloud.colours[:, i], 1.0) for i, name in enumerate(_COLOURS)}
    for name, values in cloud.scalars.items():
        columns[f"scalar_{name}"] = values, scale if name in LENGTHS else 1.0
    if SHOWN_BY_MESHLAB in cloud.scalars:
        columns["quality"] = columns[f"scalar_{SHOWN_BY_MESHLAB}"]
    rows = np.empty(len(cloud), [(name, "u1" if name in _COLOURS else "<f4") for name in columns])
    for name, (values, factor) in columns.items():
        rows[name] = values
        if factor != 1:
            rows[name] *= np.float32(factor)
    return rows


def coloured(rows: NDArray[np.void]) -> NDArray[np.float32]:
    """The coordinates and colours, 0-1, of points, (N, 6)."""
    colours = (rows[name].astype(np.float32) * np.float32(1 / 255) for name in _COLOURS)
    return np.column_stack([*(rows[name] for name in "xyz"), *colours])


COLOURED_LINE = " ".join([_EXACT] * 3 + ["%.6g"] * 3)
"""The format of a line of such numbers."""


def lines_of(rows: NDArray[Any], line: str) -> bytes:
    """A line of text for each row: a record, or numbers in an array (N, M)."""
    numbers = chain.from_iterable(rows.tolist()) if rows.dtype.names else rows.ravel().tolist()
    return (f"{line}\n" * len(rows) % tuple(numbers)).encode()


def pieces(rows: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Yield some rows of an array at a time."""
    return (rows[start : start + _AT_ONCE] for start in range(0, len(rows), _AT_ONCE))


# Clouds and meshes as PLY, with property names that CloudCompare and MeshLab display.


def ply_parts(
    vertices: PointCloud,
    faces: NDArray[np.int32] | None = None,
    *,
    axes: str = "camera",
    unit: str = "m",
    ascii: bool = False,
) -> Iterator[bytes]:
    """Yield a PLY file, part by part.

    For every vertex float x, y, z; nx, ny, nz if there are normals; uchar red, green, blue; a float scalar_NAME for
    each scalar, and the expected error also as quality.

    Parameters
    ----------
    vertices : PointCloud
    faces : ndarray, optional
        int32 (M, 3): the three vertices of each triangle.
    axes, unit : str
        As for `write_cloud`.
    ascii : bool
        Text, without loss of precision, instead of little-endian binary.
    """
    rows = rows_of(vertices, axes, unit)
    is_colour = {name: name in _COLOURS for name in rows.dtype.names or ()}
    header = [
        "ply",
        f"format {'ascii' if ascii else 'binary_little_endian'} 1.0",
        "comment ILF Studio",
        f"comment unit {unit}, axes {axes}",
        f"element vertex {len(vertices)}",
        *(f"property {'uchar' if colour else 'float'} {name}" for name, colour in is_colour.items()),
    ]
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    yield "\n".join([*header, "end_header\n"]).encode()
    line = " ".join("%d" if colour else _EXACT for colour in is_colour.values())
    for part in pieces(rows):
        yield lines_of(part, line) if ascii else part.tobytes()
    for some in () if faces is None else pieces(faces):
        counted = np.empty(len(some), [("count", "u1"), ("vertices", "<i4", 3)])
        counted["count"], counted["vertices"] = 3, some
        yield lines_of(some, "3 %d %d %d") if ascii else counted.tobytes()


# Clouds as PCD, the Point Cloud Library's format, version 0.7.


def pcd_parts(cloud: PointCloud, *, axes: str = "camera", unit: str = "m", ascii: bool = False) -> Iterator[bytes]:
    """Yield a PCD file, part by part.

    For every point float x, y, z; rgb, packed into the bits of a float as in that library; normal_x, normal_y,
    normal_z if there are normals; and the scalars as in PLY. The camera is the viewpoint. A cloud with a point for
    every pixel of its image is organised: WIDTH and HEIGHT are the image's.

    Parameters
    ----------
    cloud : PointCloud
    axes, unit, ascii
        As for `write_cloud`.
    """
    rows = rows_of(cloud, axes, unit)
    names = [*_pcd_columns(rows[:0])]
    ones = " ".join("1" for _ in names)
    height, width = cloud.image_shape or (1, len(cloud))
    yield "\n".join(
        [
            "# .PCD v0.7 - Point Cloud Data file format",
            "VERSION 0.7",
            f"FIELDS {' '.join(names)}",
            f"SIZE {ones.replace('1', '4')}",
            f"TYPE {ones.replace('1', 'F')}",
            f"COUNT {ones}",
            f"WIDTH {width}",
            f"HEIGHT {height}",
            "VIEWPOINT 0 0 0 1 0 0 0",
            f"POINTS {len(cloud)}",
            f"DATA {'ascii' if ascii else 'binary'}\n",
        ]
    ).encode()
    for part in pieces(rows):
        columns = np.column_stack([*_pcd_columns(part).values()])
        yield lines_of(columns, " ".join([_EXACT] * len(names))) if ascii else columns.tobytes()


def _pcd_columns(rows: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
    """The columns of a PCD; colours are packed into the bits 0x00RRGGBB of a float, which is finite for every
    colour."""
    packed = np.zeros((len(rows), 4), np.uint8)
    packed[:, :3] = np.column_stack([rows[name] for name in reversed(_COLOURS)])
    columns = {name: rows[name] for name in "xyz"} | {"rgb": packed.view("<f4")[:, 0]}
    others = (name for name in rows.dtype.names or () if name not in {*"xyz", *_COLOURS})
    return columns | {f"normal_{name[1]}" if name in {"nx", "ny", "nz"} else name: rows[name] for name in others}


CLOUD_SUFFIXES = (".ply", ".pcd", ".xyz", ".xyzrgb")
"""Suffixes that `write_cloud` supports; .xyz has no colour."""


def write_cloud(
    path: str | os.PathLike[str],
    cloud: PointCloud,
    *,
    axes: str = "camera",
    unit: str = "m",
    ascii: bool = False,
) -> None:
    """Write a point cloud atomically, as float32, in the format given by the suffix.

    PLY and PCD contain all scalars of the points: as scalar_NAME, which CloudCompare shows as scalar fields, and the
    expected error also as quality, which MeshLab shows.

    Parameters
    ----------
    path : path-like
        .ply, .pcd, .xyz (no colour) or .xyzrgb (colours 0-1).
    cloud : PointCloud
        In camera axes.
    axes : str
        One of `ilf.data.points.AXES`.
    unit : str
        "m" or "mm", for the points and for scalars that are lengths.
    ascii : bool
        Text instead of binary for .ply and .pcd.

    Raises
    ------
    ExportError
        For another suffix, an empty cloud, or if the file cannot be written.
    ParameterError
        For unknown axes or units.

    Examples
    --------
    >>> write_cloud("cloud.xyz", PointCloud(np.array([[1, 2, 3]], np.float32), np.zeros((1, 3), np.uint8)))
    >>> Path("cloud.xyz").read_text().split()
    ['1', '2', '3']
    """
    check_path(path)
    check_kind(cloud, PointCloud, "A cloud is written from points", "give what ilf.point_cloud returns.")
    suffix = Path(path).suffix.lower()
    if suffix not in CLOUD_SUFFIXES:
        raise ExportError(f"A cloud cannot be written as {str(path)!r}: use one of {', '.join(CLOUD_SUFFIXES)}.")
    if len(cloud) == 0:
        raise ExportError("The cloud has no points to write: the depth has no known pixel.")
    if suffix == ".ply":
        parts = ply_parts(cloud, axes=axes, unit=unit, ascii=ascii)
    elif suffix == ".pcd":
        parts = pcd_parts(cloud, axes=axes, unit=unit, ascii=ascii)
    elif suffix == ".xyz":
        parts = (lines_of(rows[[*"xyz"]], " ".join([_EXACT] * 3)) for rows in pieces(rows_of(cloud, axes, unit)))
    else:
        parts = (lines_of(coloured(rows), COLOURED_LINE) for rows in pieces(rows_of(cloud, axes, unit)))
    write_parts(path, parts)
