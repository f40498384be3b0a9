"""Flags of the files that an export writes."""

from __future__ import annotations

import argparse

from ..run.formats import FORMATS
from ..run.options import CLOUD_AXES, CLOUD_FILES, CLOUD_UNITS, DEPTH_FILES, MESH_FILES, ExportOptions
from .usage import UsageError, declare, given_flags

_GEOMETRY = ("cloud", "mesh", "normals", "drop_flying", "axes", "cloud_unit")
"""The values of the flags of point cloud and mesh."""


def add_export_options(group: argparse._ActionsContainer) -> None:
    """Add the flags to a parser or a group of its flags."""
    usual = ExportOptions()
    declared = f"""
        --depth-formats LIST  formats of the depth files, any of {",".join(DEPTH_FILES)}
            (default: {",".join(usual.depth_formats)})
        --png-units UNITS     units per metre of depth.png
        --no-expected-error   omit the expected error, both its files and its values in point cloud and mesh
    """
    declare(group, declared, png_units=usual.depth_units)
    declared = f"""
        --cloud {"|".join(CLOUD_FILES)}  format of the point cloud (default: {usual.cloud}); ply and pcd include
            expected error, block and fill state
        --no-cloud  write no point cloud
    """
    declare(group.add_mutually_exclusive_group(), declared)
    formats = ", ".join(f"{name} ({format.group}: {format.title})" for name, format in FORMATS.items())
    declared = f"""
        --mesh {"|".join(MESH_FILES)}  also write a mesh, cut at depth jumps. glb is always in metres with y up
        --normals      add normals to point cloud (not xyz) and mesh
        --drop-flying  remove flying pixels from point cloud and mesh
        --axes {"|".join(CLOUD_AXES)}  axes of point cloud and mesh: camera (x right, y down, z forward), y-up, or world
            (needs a pose)
        --cloud-unit {"|".join(CLOUD_UNITS)}  unit of point cloud and mesh
        --export FORMAT ...  also write a file for another program; can be repeated: {formats}. `ilf complete` also
            takes a FILE, in the format of its extension: one of these, .rrd for the viewer Rerun with images, blocks
            and curves (needs the package rerun-sdk), or one of plugins
    """
    declare(group, declared, axes=usual.axes, cloud_unit=usual.cloud_unit)


def given_exports(arguments: argparse.Namespace) -> tuple[tuple[str, ...], list[str]]:
    """Return what --export gives: formats of files among the results, and other files."""
    formats = tuple(given for given in arguments.export if given in FORMATS)
    return formats, [given for given in arguments.export if given not in FORMATS]


def export_options(arguments: argparse.Namespace, *, with_files: bool = False) -> ExportOptions:
    """Return the export options of the flags.

    Raises
    ------
    UsageError
        If the flags contradict each other, or --export gives a file, but not `with_files`.
    ParameterError
        If a value is not valid.
    """
    if arguments.no_cloud and arguments.mesh is None and (flags := geometry_flags(arguments)):
        raise UsageError(f"--no-cloud contradicts {', '.join(flags)}: leave it out, or add --mesh.")
    exports, files = given_exports(arguments)
    if files and not with_files:
        raise UsageError(f"--export takes a format here, not {files[0]!r:.60}: {', '.join(FORMATS)}.")
    formats = arguments.depth_formats
    return ExportOptions(
        depth_formats=ExportOptions.depth_formats if formats is None else tuple(filter(None, formats.split(","))),
        depth_units=arguments.png_units,
        expected_error=not arguments.no_expected_error,
        cloud=None if arguments.no_cloud else arguments.cloud or ExportOptions.cloud,
        axes=arguments.axes,
        cloud_unit=arguments.cloud_unit,
        mesh=arguments.mesh,
        normals=arguments.normals,
        drop_flying=arguments.drop_flying,
        exports=exports,
    )


def geometry_flags(arguments: argparse.Namespace) -> list[str]:
    """Return the given flags of point cloud and mesh."""
    return given_flags(arguments, _GEOMETRY)
