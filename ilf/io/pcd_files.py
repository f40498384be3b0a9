"""Clouds as PCD, the Point Cloud Library's format, version 0.7."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cloud import PointCloud
from .columns import Column, binary_rows, columns_of, text_rows
from .ply_files import scalar_columns


def pcd_parts(cloud: PointCloud, *, axes: str = "camera", unit: str = "m", ascii: bool = False) -> Iterator[bytes]:
    """A PCD file, part by part.

    Of every point float x, y, z; rgb, packed into the bits of a float as that library has it; normal_x, normal_y,
    normal_z where there are normals; and the scalars as in PLY. The camera is the viewpoint. A cloud with a point for
    every pixel of its image is organised: WIDTH and HEIGHT are the image's.

    Parameters
    ----------
    cloud : PointCloud
    axes, unit, ascii
        As `write_cloud` takes them.
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
    """Colours as the bits 0x00RRGGBB of a float, which is finite whatever the colour."""
    packed = np.zeros((len(colours), 4), np.uint8)
    packed[:, :3] = colours[:, ::-1]
    return packed.view("<f4")[:, 0]
