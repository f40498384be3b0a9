"""Point clouds as PLY and XYZ by numpy, as PCD through Open3D."""

from __future__ import annotations

import ctypes
import errno
import os
import re
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..cloud import PointCloud, in_axes
from ..errors import ExportError, ParameterError
from ..extras import way_out
from .atomic import atomic_path, write_bytes
from .ply_files import ply_content, text_content

CLOUD_SUFFIXES = (".ply", ".pcd", ".xyz", ".xyzrgb")
"""Suffixes that `write_cloud` knows; .xyz has no colour."""

UNITS_PER_METRE = {"m": 1.0, "mm": 1000.0}

# what Open3D is linked against that bare machines lack
_OPEN3D_LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libgomp.so.1", "libidn2.so.0", "libudev.so.1")

_PCD_BYTES = 16  # of a binary point: 3 floats and packed colour
_PCD_HEADER_END = re.compile(rb"DATA (?:binary|ascii)\n")


def load_open3d() -> Any:
    """The open3d module, imported on first use because that takes seconds.

    Raises
    ------
    ExportError
        If it is not installed or cannot be loaded; the message names what to install.
    """
    with suppress(ImportError, OSError):
        import libusb_package

        # open3d is linked against libusb-1.0, which bare machines lack; a copy loaded first satisfies it
        library = libusb_package.get_library_path()
        if library is not None:
            ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    try:
        import open3d
    except (ImportError, OSError) as error:
        raise ExportError(
            f"A PCD file needs the package open3d, {way_out('open3d', 'cloud', error, _OPEN3D_LIBRARIES).rstrip('.')}; "
            "or write PLY, which needs nothing."
        ) from error
    return open3d


def check_cloud_format(path: str | os.PathLike[str]) -> None:
    """Find out before a long run whether `write_cloud` could write a file of this suffix here.

    Raises
    ------
    ExportError
        For another suffix than `CLOUD_SUFFIXES`, or if the package that it needs cannot be loaded.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in CLOUD_SUFFIXES:
        raise ExportError(f"A cloud cannot be written as {str(path)!r}: use one of {', '.join(CLOUD_SUFFIXES)}.")
    if suffix == ".pcd":
        load_open3d()


def write_cloud(
    path: str | os.PathLike[str],
    cloud: PointCloud,
    *,
    axes: str = "camera",
    unit: str = "m",
    ascii: bool = False,
) -> None:
    """Write a point cloud atomically, as float32, in the format that the suffix names.

    Parameters
    ----------
    path : path-like
        .ply, .pcd, .xyz (no colour) or .xyzrgb (colours 0-1). Only .pcd needs Open3D.
    cloud : PointCloud
        In camera axes.
    axes : str
        One of `ilf.cloud.AXES`.
    unit : str
        "m" or "mm".
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
    if unit not in UNITS_PER_METRE:
        raise ParameterError(f"unit must be one of {', '.join(UNITS_PER_METRE)}, not {unit!r}.")
    turned = in_axes(cloud, axes)
    if len(turned) == 0:
        raise ExportError("The cloud has no points to write: the depth has no known pixel.")
    scaled = PointCloud((turned.points * UNITS_PER_METRE[unit]).astype(np.float32), turned.colours)
    suffix = Path(path).suffix.lower()
    if suffix == ".pcd":
        _write_pcd(path, scaled, ascii)
    elif suffix == ".ply":
        write_bytes(path, ply_content(scaled.points, scaled.colours, ascii=ascii))
    else:
        write_bytes(path, text_content(scaled.points, scaled.colours / 255.0 if suffix == ".xyzrgb" else None))


def _write_pcd(path: str | os.PathLike[str], cloud: PointCloud, ascii: bool) -> None:
    o3d = load_open3d()
    geometry = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.points.astype(np.float64)))
    geometry.colors = o3d.utility.Vector3dVector(cloud.colours / 255.0)
    quiet = o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error)
    with atomic_path(path) as temporary, quiet:
        if shutil.disk_usage(temporary.parent).free < len(cloud) * _PCD_BYTES:
            # found out here, since open3d would print a line for every buffer that it cannot write
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = o3d.io.write_point_cloud(str(temporary), geometry, write_ascii=ascii)
        if not written or not _is_whole_pcd(temporary, len(cloud), ascii):
            raise ExportError(
                f"Could not write {path}: the cloud's file came out incomplete. Is the disk full? "
                "Free some space or choose another folder."
            )


def _is_whole_pcd(path: Path, points: int, ascii: bool) -> bool:
    """Whether a file has as many bytes (binary) or lines (text) as its points need.

    Open3D returns success even where the disk was full, and reads truncated files without complaint.
    """
    content = path.read_bytes()
    header = _PCD_HEADER_END.search(content, 0, 1024)
    body = content[header.end() :] if header else content
    if ascii:
        return body.endswith(b"\n") and body.count(b"\n") == points
    return len(body) == points * _PCD_BYTES
