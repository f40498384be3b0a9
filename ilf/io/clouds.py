"""Writing point clouds as PLY, PCD and XYZ, part by part, so that a large one is in memory only once."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.writing import write_parts
from ..data.points import LENGTHS, PointCloud, axes_signs
from ..errors import ExportError, ParameterError, check_kind, path_first

# The values of a cloud's points as columns, which file formats write in different orders.

UNITS_PER_METRE = {"m": 1.0, "mm": 1000.0}

_AT_ONCE = 1 << 16  # points

# enough digits to restore every float32 exactly
_FORMATS = {"f": "%.9g", "u": "%d"}


@dataclass(frozen=True, eq=False)
class Column:
    """One value of every point.

    Parameters
    ----------
    name : str
    values : ndarray
        Shape (N,).
    factor : float
        Factor applied to the values.
    kind : str
        Type in the file: "<f4" or "u1".
    """

    name: str
    values: NDArray[Any]
    factor: float = 1.0
    kind: str = "<f4"


@dataclass(frozen=True, eq=False)
class Columns:
    """All columns of a cloud in the axes and unit of the file."""

    points: tuple[Column, ...]
    normals: tuple[Column, ...]
    colours: tuple[Column, ...]
    scalars: tuple[Column, ...]


def columns_of(cloud: PointCloud, axes: str, unit: str) -> Columns:
    """Return columns x, y, z; nx, ny, nz; red, green, blue; and the scalars under their own names.

    Nothing is copied: factors are applied on writing.

    Raises
    ------
    ParameterError
        For unknown axes or units.
    """
    if unit not in UNITS_PER_METRE:
        raise ParameterError(f"unit must be one of {', '.join(UNITS_PER_METRE)}, not {unit!r}.")
    scale, signs = UNITS_PER_METRE[unit], axes_signs(axes)
    normals = cloud.normals
    return Columns(
        points=tuple(Column("xyz"[i], cloud.points[:, i], scale * signs[i]) for i in range(3)),
        normals=() if normals is None else tuple(Column(f"n{'xyz'[i]}", normals[:, i], signs[i]) for i in range(3)),
        colours=tuple(Column(name, cloud.colours[:, i], kind="u1") for i, name in enumerate(("red", "green", "blue"))),
        scalars=tuple(
            Column(name, values, scale if name in LENGTHS else 1.0) for name, values in cloud.scalars.items()
        ),
    )


def binary_rows(columns: Sequence[Column]) -> Iterator[bytes]:
    """Yield the values point by point as bytes, some points at a time."""
    for rows in _rows(columns):
        yield rows.tobytes()


def text_rows(columns: Sequence[Column], start: str = "", formats: Sequence[str] = ()) -> Iterator[bytes]:
    """Yield a line for each point, some points at a time, without loss of precision unless formats are given."""
    line = " ".join(formats or [_FORMATS[np.dtype(column.kind).kind] for column in columns])
    for rows in _rows(columns):
        values = [rows[name].tolist() for name in rows.dtype.names or ()]
        text = f"{start}{line}\n" * len(rows)
        yield (text % tuple(number for point in zip(*values, strict=True) for number in point)).encode()


def _rows(columns: Sequence[Column]) -> Iterator[NDArray[np.void]]:
    for start in range(0, len(columns[0].values), _AT_ONCE):
        some = slice(start, start + _AT_ONCE)
        rows = np.empty(len(columns[0].values[some]), [(column.name, column.kind) for column in columns])
        for column in columns:
            rows[column.name] = column.values[some]
            if column.factor != 1:
                rows[column.name] *= np.float32(column.factor)
        yield rows


# Clouds and meshes as PLY, with property names that CloudCompare and MeshLab display.

_KINDS = {"<f4": "float", "u1": "uchar"}

SHOWN_BY_MESHLAB = "expected_error"
"""The scalar also written as quality, the only one that MeshLab uses for colouring."""


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
    parts = columns_of(vertices, axes, unit)
    columns = [*parts.points, *parts.normals, *parts.colours, *scalar_columns(parts.scalars)]
    header = [
        "ply",
        f"format {'ascii' if ascii else 'binary_little_endian'} 1.0",
        "comment ILF Studio",
        f"comment unit {unit}, axes {axes}",
        f"element vertex {len(vertices)}",
        *(f"property {_KINDS[column.kind]} {column.name}" for column in columns),
    ]
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    yield "\n".join([*header, "end_header\n"]).encode()
    yield from text_rows(columns) if ascii else binary_rows(columns)
    if faces is not None:
        yield from _text_faces(faces) if ascii else _binary_faces(faces)


def scalar_columns(scalars: tuple[Column, ...]) -> list[Column]:
    """Return scalars under the names that CloudCompare and MeshLab recognise."""
    named = [replace(column, name=f"scalar_{column.name}") for column in scalars]
    return named + [replace(column, name="quality") for column in scalars if column.name == SHOWN_BY_MESHLAB]


def _binary_faces(faces: NDArray[np.int32]) -> Iterator[bytes]:
    for start in range(0, len(faces), _AT_ONCE):
        some = faces[start : start + _AT_ONCE]
        rows = np.empty(len(some), [("count", "u1"), ("vertices", "<i4", 3)])
        rows["count"], rows["vertices"] = 3, some
        yield rows.tobytes()


def _text_faces(faces: NDArray[np.int32]) -> Iterator[bytes]:
    for start in range(0, len(faces), _AT_ONCE):
        some = faces[start : start + _AT_ONCE]
        yield ("3 %d %d %d\n" * len(some) % tuple(some.reshape(-1).tolist())).encode()


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
    parts = columns_of(cloud, axes, unit)
    normals = [replace(column, name=f"normal_{column.name[1]}") for column in parts.normals]
    columns = [*parts.points, Column("rgb", _packed(cloud.colours)), *normals, *scalar_columns(parts.scalars)]
    ones = " ".join("1" for _ in columns)
    height, width = cloud.image_shape or (1, len(cloud))
    yield "\n".join(
        [
            "# .PCD v0.7 - Point Cloud Data file format",
            "VERSION 0.7",
            f"FIELDS {' '.join(column.name for column in columns)}",
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
    yield from text_rows(columns) if ascii else binary_rows(columns)


def _packed(colours: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Pack colours into the bits 0x00RRGGBB of a float, which is finite for every colour."""
    packed = np.zeros((len(colours), 4), np.uint8)
    packed[:, :3] = colours[:, ::-1]
    return packed.view("<f4")[:, 0]


CLOUD_SUFFIXES = (".ply", ".pcd", ".xyz", ".xyzrgb")
"""Suffixes that `write_cloud` supports; .xyz has no colour."""


def check_cloud_format(path: str | os.PathLike[str]) -> None:
    """Check before a long run that `write_cloud` supports the suffix.

    Raises
    ------
    ExportError
        For a suffix that is not in `CLOUD_SUFFIXES`.
    """
    if Path(path).suffix.lower() not in CLOUD_SUFFIXES:
        raise ExportError(f"A cloud cannot be written as {str(path)!r}: use one of {', '.join(CLOUD_SUFFIXES)}.")


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
        One of `ilf.cloud.AXES`.
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
    path, cloud = path_first(path, cloud)
    check_kind(cloud, PointCloud, "A cloud is written from points", "give what ilf.point_cloud returns.")
    check_cloud_format(path)
    if len(cloud) == 0:
        raise ExportError("The cloud has no points to write: the depth has no known pixel.")
    suffix = Path(path).suffix.lower()
    if suffix == ".ply":
        parts = ply_parts(cloud, axes=axes, unit=unit, ascii=ascii)
    elif suffix == ".pcd":
        parts = pcd_parts(cloud, axes=axes, unit=unit, ascii=ascii)
    else:
        parts = _xyz_parts(cloud, axes, unit, with_colours=suffix == ".xyzrgb")
    write_parts(path, parts)


def _xyz_parts(cloud: PointCloud, axes: str, unit: str, with_colours: bool) -> Iterator[bytes]:
    """Yield one line per point: x y z, without loss of precision, and the colours, 0-1."""
    columns = columns_of(cloud, axes, unit)
    if not with_colours:
        return text_rows(columns.points)
    colours = [replace(column, factor=1 / 255, kind="<f4") for column in columns.colours]
    return text_rows([*columns.points, *colours], formats=["%.9g"] * 3 + ["%.6g"] * 3)
