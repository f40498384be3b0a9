"""Flags of the files that an export writes, and of given blocks."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from ..data.blocks import Blocks
from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters
from ..io.block_files import read_blocks
from ..io.labels import LoadedBlocks
from ..run.options import (
    CLOUD_AXES,
    CLOUD_FILES,
    CLOUD_UNITS,
    DEPTH_FILES,
    MESH_FILES,
    ExportOptions,
    drop_impossible_cloud,
)
from ..segmentation.reextraction import with_gaps_filled
from .parsing import BLOCK_PREFIX, given_parameters, with_given
from .usage import UsageError

_GEOMETRY_FLAGS = ("cloud_format", "mesh", "normals", "drop_flying", "axes", "cloud_unit")
"""Flags of point cloud and mesh."""


def add_export_options(group: Any) -> None:
    """Add the flags to a parser or a group of its flags."""
    group.add_argument(
        "--depth-formats",
        metavar="LIST",
        help=f"formats of the depth files, any of {','.join(DEPTH_FILES)} (default: png,npy)",
    )
    group.add_argument("--png-units", type=float, metavar="N", help="units per metre of depth.png (default: 1000)")
    group.add_argument(
        "--no-expected-error",
        action="store_true",
        help="omit the expected error, both its files and its values in point cloud and mesh",
    )
    group.add_argument(
        "--cloud-format",
        choices=tuple(CLOUD_FILES),
        help="format of the point cloud (default: ply); ply and pcd include expected error, block and fill state",
    )
    group.add_argument("--no-cloud", action="store_true", help="write no point cloud")
    group.add_argument(
        "--mesh",
        choices=tuple(MESH_FILES),
        help="also write a mesh, cut at depth jumps. glb is always in metres with y up",
    )
    group.add_argument(
        "--normals", action="store_true", default=None, help="add normals to point cloud (not xyz) and mesh"
    )
    group.add_argument(
        "--drop-flying",
        action="store_true",
        default=None,
        help="remove flying pixels from point cloud and mesh",
    )
    group.add_argument(
        "--axes",
        choices=CLOUD_AXES,
        help="axes of point cloud and mesh: camera (x right, y down, z forward; default), y-up, or world (needs a "
        "pose)",
    )
    group.add_argument("--cloud-unit", choices=CLOUD_UNITS, help="unit of point cloud and mesh (default: m)")


def export_options(arguments: argparse.Namespace) -> ExportOptions:
    """Return the export options of the flags.

    Raises
    ------
    UsageError
        If the flags contradict each other.
    ParameterError
        If a value is not valid.
    """
    if arguments.no_cloud and arguments.cloud_format is not None:
        raise UsageError("--no-cloud contradicts --cloud-format: leave out one of them.")
    if arguments.no_cloud and arguments.mesh is None and (flags := geometry_flags(arguments)):
        raise UsageError(f"--no-cloud contradicts {', '.join(flags)}: leave it out, or add --mesh.")
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


def geometry_flags(arguments: argparse.Namespace) -> list[str]:
    """Return the given flags of point cloud and mesh."""
    return [f"--{name.replace('_', '-')}" for name in _GEOMETRY_FLAGS if getattr(arguments, name) is not None]


def feasible_options(
    options: ExportOptions, frame: RGBDFrame, arguments: argparse.Namespace, remedy: str = ""
) -> tuple[ExportOptions, tuple[str, ...]]:
    """Return the options without a point cloud that was not requested and is not possible, and a note about that."""
    return (options, ()) if geometry_flags(arguments) else drop_impossible_cloud(options, frame, remedy)


# Given blocks, from this program or another, and the extraction in their gaps.


def add_given_blocks(group: Any, flag: str) -> None:
    """Add the arguments of given blocks, and of filling their gaps."""
    group.add_argument(
        flag,
        dest="blocks",
        metavar="PATH",
        help="use these blocks instead of extracting them. Formats: label map (PNG), labelme or COCO JSON, "
        "segment-anything masks (JSON) or a folder of masks (PNG); where masks overlap, the smallest is on top",
    )
    group.add_argument("--fill-gaps", action="store_true", help=f"extract blocks in the gaps of {flag}")


def check_given_blocks(
    arguments: argparse.Namespace, flag: str, base: BlockParameters | None = None
) -> BlockParameters:
    """Return the extraction parameters, based on `base`; UsageError for arguments without effect."""
    if arguments.blocks is None and arguments.fill_gaps:
        raise UsageError(f"--fill-gaps needs blocks: give them with {flag}.")
    given = given_parameters(arguments, BlockParameters)
    if arguments.blocks is not None and given and not arguments.fill_gaps:
        raise UsageError(
            f"With {flag} nothing is extracted: leave out the --{BLOCK_PREFIX}* flags, or add --fill-gaps."
        )
    return with_given(base or BlockParameters(), arguments)


def given_blocks(arguments: argparse.Namespace, frame: RGBDFrame) -> LoadedBlocks:
    """Read the given blocks; an empty map if there are none."""
    if arguments.blocks is None:
        return LoadedBlocks(np.zeros(frame.shape, np.int32))
    return read_blocks(arguments.blocks, frame.shape, image=None if frame.inputs is None else frame.inputs.rgb.path)


def filled(blocks: LoadedBlocks, extracted: Blocks, parameters: BlockParameters) -> LoadedBlocks:
    """Return blocks with their gaps filled by extracted ones."""
    labels = with_gaps_filled(blocks.labels, extracted.labels, parameters)
    return LoadedBlocks(labels, blocks.names, blocks.notes + extracted.notes)
