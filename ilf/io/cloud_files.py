"""Point clouds as PLY, PCD and XYZ, part by part, so that a large one is held once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ..cloud import PointCloud
from ..errors import ExportError
from .atomic import write_parts
from .columns import columns_of, text_rows
from .pcd_files import pcd_parts
from .ply_files import ply_parts

CLOUD_SUFFIXES = (".ply", ".pcd", ".xyz", ".xyzrgb")
"""Suffixes that `write_cloud` knows; .xyz has no colour."""


def check_cloud_format(path: str | os.PathLike[str]) -> None:
    """Find out before a long run whether `write_cloud` could write a file of this suffix.

    Raises
    ------
    ExportError
        For another suffix than `CLOUD_SUFFIXES`.
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
    """Write a point cloud atomically, as float32, in the format that the suffix names.

    PLY and PCD have all that is known of the points: scalars as scalar_NAME, which CloudCompare shows as scalar fields,
    and the expected error also as quality, which MeshLab shows.

    Parameters
    ----------
    path : path-like
        .ply, .pcd, .xyz (no colour) or .xyzrgb (colours 0-1).
    cloud : PointCloud
        In camera axes.
    axes : str
        One of `ilf.cloud.AXES`.
    unit : str
        "m" or "mm": of the points and of scalars that are lengths.
    ascii : bool
        Text instead of binary for .ply and .pcd.

    Raises
    ------
    ExportError
        For another suffix, an empty cloud, or if the file cannot be written.
    ParameterError
        For unknown axes or units.
    """
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
    """One line per point: x y z, every digit of it, and the colours, 0-1."""
    columns = columns_of(cloud, axes, unit)
    if not with_colours:
        return text_rows(columns.points)
    colours = [replace(column, factor=1 / 255, kind="<f4") for column in columns.colours]
    return text_rows([*columns.points, *colours], formats=["%.9g"] * 3 + ["%.6g"] * 3)
