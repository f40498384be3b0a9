"""Clouds and meshes as PLY: named so that CloudCompare and MeshLab show what is known of the points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cloud import PointCloud
from .columns import Column, binary_rows, columns_of, text_rows

_KINDS = {"<f4": "float", "u1": "uchar"}
_AT_ONCE = 1 << 16  # triangles

SHOWN_BY_MESHLAB = "expected_error"
"""The scalar that is also the quality, the only one that MeshLab colours by."""


def ply_parts(
    vertices: PointCloud,
    faces: NDArray[np.int32] | None = None,
    *,
    axes: str = "camera",
    unit: str = "m",
    ascii: bool = False,
) -> Iterator[bytes]:
    """A PLY file, part by part.

    Of every vertex float x, y, z; nx, ny, nz where there are normals; uchar red, green, blue; a float scalar_NAME for
    each scalar, and the expected error once more as quality.

    Parameters
    ----------
    vertices : PointCloud
    faces : ndarray, optional
        int32 (M, 3): the three vertices of each triangle.
    axes, unit : str
        As `write_cloud` takes them.
    ascii : bool
        Text, every digit of it, instead of little-endian binary.
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
    """Scalars under the names by which CloudCompare and MeshLab know them."""
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
