"""Export options: the files of a run's results and their formats."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..data.declarations import ParameterSet, declare, with_documented_parameters
from .formats import FORMATS

_DEPTH_FORMATS = {"png": "PNG, 16 bit", "tiff": "TIFF, float32 metres", "npy": "NPY, float32 metres"}
_CLOUD_FORMATS = {
    "ply": "PLY, binary",
    "ply-ascii": "PLY, text",
    "pcd": "PCD",
    "xyz": "XYZ, no colour",
    "xyzrgb": "XYZRGB",
}
_MESH_FORMATS = {"glb": "GLB, for viewers and browsers", "ply": "PLY, with all attributes", "obj": "OBJ, text"}

DEPTH_FILES = {name: f"depth.{name}" for name in _DEPTH_FORMATS}
"""Depth format -> file name. PNG is 16 bit in `depth_units`; TIFF and NPY are float32 metres."""

ALIGNED_FILES = {name: f"depth_aligned.{name}" for name in _DEPTH_FORMATS}
"""Depth format -> file name of depth aligned to colour after completion in the depth camera's view."""

ERROR_FILES = {name: f"expected_error.{name}" for name in _DEPTH_FORMATS}
"""Depth format -> file name of the expected error, in the same units."""

CLOUD_FILES = {name: f"cloud.{name.removesuffix('-ascii')}" for name in _CLOUD_FORMATS}
"""Point cloud format -> file name."""

MESH_FILES = {name: f"mesh.{name}" for name in _MESH_FORMATS}
"""Mesh format -> file name."""

WORLD = "world"

_LONGEST_NAME = 60
"""Maximum number of characters of a frame's name in file names, which are limited to 255 bytes."""


DEPTH, RUN, SPACE, OTHERS = "Completed depth", "Blocks and run", "Point cloud and mesh", "Files of other programs"
"""Groups of the options."""


@with_documented_parameters
@dataclass(frozen=True)
class ExportOptions(ParameterSet):
    """The files that an export writes, and their formats."""

    depth_formats: tuple[str, ...] = declare(
        ("png", "npy"), "Formats", "Formats of the depth files: PNG has 16 bits, TIFF and NPY are float32 metres.",
        DEPTH,
        choices=_DEPTH_FORMATS,
    )  # fmt: skip
    depth_units: float = declare(
        1000.0, "Units of the PNG per metre", "Units per metre of depth.png: 1000 for millimetres.", DEPTH,
        needs=("png",), flag="--png-units", minimum=1e-6, maximum=1e9,
    )  # fmt: skip
    expected_error: bool = declare(
        True, "Expected error as well (expected_error.*)", "The expected error of the filled pixels, in the format and "
        "units of each depth file, and as values of point cloud and mesh; and a mask of the unsupported pixels. "
        "Over many frames, about 68 % of the true errors lie within it (not calibrated for extrapolated pixels).",
        DEPTH, needs=("result", "depth"),
    )  # fmt: skip
    labels: bool = declare(True, "Blocks as label map (blocks.png)", "The label map as PNG.", RUN, flag="")
    curves: bool = declare(
        True, "Convergence curves (curves.csv)", "The record of every iteration.", RUN, flag="", needs=("result",)
    )
    cloud: str | None = declare(
        "ply", "Write the point cloud", "Format of the point cloud. It has all points, also those that the 3D view "
        "leaves out; PLY and PCD contain for each its expected error (0 where depth was measured), whether it was "
        "filled, its block, and whether it is unsupported, which CloudCompare shows as scalar fields.", SPACE,
        or_none=True, needs=("camera",), choices=_CLOUD_FORMATS,
    )  # fmt: skip
    axes: str = declare(
        "camera", "Axes", "Axes of point cloud and mesh: camera (x right, y down, z forward), y-up, or world (needs a "
        "pose).", SPACE, needs=("space",),
        choices={
            "camera": "Camera: x right, y down, z forward", "y-up": "Y up: x right, y up, z backward",
            WORLD: "World: by the frame's pose",
        },
    )  # fmt: skip
    cloud_unit: str = declare(
        "m", "Unit", "Unit of point cloud and mesh.", SPACE, needs=("space",),
        choices={"m": "Metres", "mm": "Millimetres"},
    )  # fmt: skip
    run_record: bool = declare(True, "Run record (run.json)", "What a replay of the run needs.", RUN, flag="")
    mesh: str | None = declare(
        None, "Write a mesh, cut where depth jumps", "Format of the mesh. It is cut at depth jumps; GLB is always in "
        "metres with y up.", SPACE, or_none=True, needs=("camera",),
        choices=_MESH_FORMATS,
    )  # fmt: skip
    normals: bool = declare(False, "Normals", "Normals of point cloud (not XYZ) and mesh.", SPACE, needs=("space",))
    drop_flying: bool = declare(
        False, "Remove flying points", "Leave points between two surfaces out of point cloud and mesh; the depth files "
        "keep them.", SPACE, needs=("space",),
    )  # fmt: skip
    exports: tuple[str, ...] = declare(
        (), "Formats", "Files of other programs.", OTHERS, flag="", choices=FORMATS, optional=True
    )


def output_folder_name(frame_name: str) -> str:
    """Default name of the folder for a frame's results."""
    return f"{as_file_name(frame_name)}-ilf"


def as_file_name(frame_name: str) -> str:
    """A frame's name without characters that file names cannot contain.

    Examples
    --------
    >>> as_file_name("the room: 2 / 3")
    'the_room_2_3'
    """
    return re.sub(r"[^\w.-]+", "_", frame_name)[:_LONGEST_NAME] or "frame"
