"""Point clouds as PLY, PCD and XYZ, through Open3D."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ..cloud import PointCloud, in_axes
from ..errors import ExportError, ParameterError
from .atomic import atomic_path

CLOUD_SUFFIXES = (".ply", ".pcd", ".xyz", ".xyzrgb")
"""Suffixes that `write_cloud` knows; .xyz has no colour."""

UNITS_PER_METRE = {"m": 1.0, "mm": 1000.0}

# bytes per point: 3 doubles + 3 bytes of colour; 3 floats + packed colour
_BINARY_STRIDES = {".ply": 27, ".pcd": 16}
_HEADER_END = re.compile(rb"end_header\n|DATA (?:binary|ascii)\n")


def load_open3d() -> Any:
    """The open3d module, imported on first use because that takes seconds.

    Raises
    ------
    ExportError
        If it cannot be loaded.
    """
    try:
        import libusb_package

        # open3d is linked against libusb-1.0, which bare machines lack; a copy loaded first satisfies it
        library = libusb_package.get_library_path()
        if library is not None:
            ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
        import open3d
    except (ImportError, OSError) as error:
        raise ExportError(
            f"Open3D, which writes point clouds, cannot be loaded ({error}). Install the packages "
            "open3d-cpu (or open3d) and libusb-package; if it names another library, install that one."
        ) from error
    return open3d


def write_cloud(
    path: str | os.PathLike[str],
    cloud: PointCloud,
    *,
    axes: str = "camera",
    unit: str = "m",
    ascii: bool = False,
) -> None:
    """Write a point cloud atomically, in the format that the suffix names.

    Parameters
    ----------
    path : path-like
        .ply, .pcd, .xyz (no colour) or .xyzrgb (colours 0-1).
    cloud : PointCloud
        In camera axes.
    axes : str
        One of `ilf.cloud.AXES`.
    unit : str
        "m" or "mm".
    ascii : bool
        Text instead of binary for .ply and .pcd. Open3D writes 6 digits into a text PLY.

    Raises
    ------
    ExportError
        For another suffix, an empty cloud, or if the file cannot be written.
    ParameterError
        For unknown axes or units.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in CLOUD_SUFFIXES:
        raise ExportError(f"A cloud cannot be written as {str(path)!r}: use one of {', '.join(CLOUD_SUFFIXES)}.")
    if unit not in UNITS_PER_METRE:
        raise ParameterError(f"unit must be one of {', '.join(UNITS_PER_METRE)}, not {unit!r}.")
    turned = in_axes(cloud, axes)
    if len(turned) == 0:
        raise ExportError("The cloud has no points to write: the depth has no known pixel.")
    o3d = load_open3d()
    geometry = o3d.geometry.PointCloud(
        o3d.utility.Vector3dVector(turned.points.astype(np.float64) * UNITS_PER_METRE[unit])
    )
    geometry.colors = o3d.utility.Vector3dVector(turned.colours / 255.0)
    quiet = o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error)
    with atomic_path(path) as temporary, quiet:
        if shutil.disk_usage(temporary.parent).free < len(turned) * min(_BINARY_STRIDES.values()):
            # found out here, since open3d would print a line for every buffer that it cannot write
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = o3d.io.write_point_cloud(str(temporary), geometry, write_ascii=ascii)
        if not written or not _is_whole(temporary, len(turned), ascii):
            raise ExportError(
                f"Could not write {path}: the cloud's file came out incomplete. Is the disk full? "
                "Free some space or choose another folder."
            )


def _is_whole(path: Path, points: int, ascii: bool) -> bool:
    """Whether a file has as many bytes (binary) or lines (text) as its points need.

    Open3D returns success even where the disk was full, and reads truncated files without complaint.
    """
    content = path.read_bytes()
    header = _HEADER_END.search(content, 0, 1024)
    body = content[header.end() :] if header else content
    stride = _BINARY_STRIDES.get(path.suffix.lower())
    if ascii or stride is None:
        return body.endswith(b"\n") and body.count(b"\n") == points
    return len(body) == points * stride
