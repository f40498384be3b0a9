"""Flags that say which files an export writes, and how."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from ..frame import RGBDFrame
from ..run import ExportOptions
from ..run.options import CLOUD_AXES, CLOUD_FILES, CLOUD_UNITS, DEPTH_FILES, MESH_FILES
from .parsing import UsageError

_SPACE = ("cloud_format", "mesh", "normals", "drop_flying", "axes", "cloud_unit")
"""What is said of point cloud and mesh."""


def add_export_options(group: Any) -> None:
    """Add the flags to a parser or a group of its flags."""
    group.add_argument(
        "--depth-formats", metavar="LIST", help=f"depth files, any of {','.join(DEPTH_FILES)} (default: png,npy)"
    )
    group.add_argument("--png-units", type=float, metavar="N", help="units per metre of depth.png (default: 1000)")
    group.add_argument(
        "--no-expected-error",
        action="store_true",
        help="write no expected_error files beside the depth files, in the same formats and units, nor expected errors "
        "into cloud and mesh",
    )
    group.add_argument(
        "--cloud-format",
        choices=tuple(CLOUD_FILES),
        help="format of the point cloud (default: ply); ply and pcd have expected error, blocks and what was filled",
    )
    group.add_argument("--no-cloud", action="store_true", help="write no point cloud")
    group.add_argument(
        "--mesh",
        choices=tuple(MESH_FILES),
        help="write a mesh too, cut where depth jumps; a glb has metres and y up, whatever --axes and --cloud-unit are",
    )
    group.add_argument(
        "--normals", action="store_true", default=None, help="normals for the points of cloud and mesh, not for xyz"
    )
    group.add_argument(
        "--drop-flying",
        action="store_true",
        default=None,
        help="leave points that hang in mid-air between surfaces out of cloud and mesh",
    )
    group.add_argument(
        "--axes",
        choices=CLOUD_AXES,
        help="axes of cloud and mesh: camera (x right, y down, z forward; default), y-up, or world, where the frame's "
        "pose puts them",
    )
    group.add_argument("--cloud-unit", choices=CLOUD_UNITS, help="unit of cloud and mesh (default: m)")


def export_options(arguments: argparse.Namespace) -> ExportOptions:
    """What the flags ask for.

    Raises
    ------
    UsageError
        If they contradict each other.
    ParameterError
        If a value cannot be.
    """
    if arguments.no_cloud and arguments.cloud_format is not None:
        raise UsageError("--no-cloud does not go together with --cloud-format.")
    if arguments.no_cloud and arguments.mesh is None and (flags := space_flags(arguments)):
        raise UsageError(f"--no-cloud does not go together with {', '.join(flags)}, unless --mesh is given.")
    defaults = ExportOptions()
    formats = arguments.depth_formats
    return ExportOptions(
        depth_formats=defaults.depth_formats if formats is None else tuple(filter(None, formats.split(","))),
        depth_units=defaults.depth_units if arguments.png_units is None else arguments.png_units,
        expected_error=not arguments.no_expected_error,
        cloud=None if arguments.no_cloud else arguments.cloud_format or defaults.cloud,
        axes=arguments.axes or defaults.axes,
        cloud_unit=arguments.cloud_unit or defaults.cloud_unit,
        mesh=arguments.mesh,
        normals=bool(arguments.normals),
        drop_flying=bool(arguments.drop_flying),
    )


def space_flags(arguments: argparse.Namespace) -> list[str]:
    """The flags given that ask for something of a point cloud or a mesh."""
    return [f"--{name.replace('_', '-')}" for name in _SPACE if getattr(arguments, name) is not None]


def fitting(
    options: ExportOptions, frame: RGBDFrame, arguments: argparse.Namespace, way_out: str = ""
) -> tuple[ExportOptions, tuple[str, ...]]:
    """The options without a cloud that nobody asked for and that cannot be, and a note about it, with what to do."""
    if frame.intrinsics is not None or options.cloud is None or space_flags(arguments):
        return options, ()
    note = f"No point cloud is written, because the camera's intrinsics are not known{way_out}."
    return replace(options, cloud=None), (note,)
