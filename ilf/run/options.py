"""Export options: the files of a run's results and their formats."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass, field, replace

from ..data.frame import RGBDFrame
from ..data.points import AXES
from ..errors import ParameterError
from ..io.clouds import UNITS_PER_METRE
from ..sources.frame_ref import RECORD_FILE
from . import files
from .formats import FORMATS
from .run import Run

DEPTH_FILES = {"png": "depth.png", "tiff": "depth.tiff", "npy": "depth.npy"}
"""Depth format -> file name. PNG is 16 bit in `depth_units`; TIFF and NPY are float32 metres."""

ALIGNED_FILES = {"png": "depth_aligned.png", "tiff": "depth_aligned.tiff", "npy": "depth_aligned.npy"}
"""Depth format -> file name of depth aligned to colour after completion in the depth camera's view."""

ERROR_FILES = {"png": "expected_error.png", "tiff": "expected_error.tiff", "npy": "expected_error.npy"}
"""Depth format -> file name of the expected error, in the same units."""

CLOUD_FILES = {
    "ply": "cloud.ply",
    "ply-ascii": "cloud.ply",
    "pcd": "cloud.pcd",
    "xyz": "cloud.xyz",
    "xyzrgb": "cloud.xyzrgb",
}
"""Point cloud format -> file name."""

MESH_FILES = {"ply": "mesh.ply", "obj": "mesh.obj", "glb": "mesh.glb"}
"""Mesh format -> file name."""

WORLD = "world"
CLOUD_AXES = (*AXES, WORLD)
CLOUD_UNITS = tuple(UNITS_PER_METRE)

_LONGEST_NAME = 60
"""Maximum number of characters of a frame's name in file names, which are limited to 255 bytes."""


@dataclass(frozen=True)
class ExportOptions:
    """The files that an export writes, and their formats.

    Parameters
    ----------
    depth_formats : tuple of str
        Formats of the completed depth: any of "png" (uint16), "tiff" and "npy" (float32 metres).
    depth_units : float
        Units per metre of the 16-bit PNG: 1000 for millimetres.
    expected_error : bool
        For every depth file, a file of the same format and units with the expected error of the filled pixels; and a
        mask of the unsupported ones.
    labels, curves : bool
        The label map as PNG; the record of every iteration as CSV.
    cloud : str or None
        Format of the point cloud: "ply" (binary), "ply-ascii", "pcd", "xyz", "xyzrgb"; None for no cloud.
    axes : str
        Axes of cloud and mesh: "camera" (x right, y down, z forward), "y-up" (x right, y up, z backward), or "world",
        by the frame's pose.
    cloud_unit : str
        Unit of cloud and mesh: "m" or "mm".
    run_record : bool
        `run.json`, which replays the run.
    mesh : str or None
        Format of the mesh, cut at depth jumps: "ply", "obj", "glb" (always y up, in metres); None for no mesh.
    normals : bool
        Write normals of cloud and mesh.
    drop_flying : bool
        Leave flying points between surfaces out of cloud and mesh.
    exports : tuple of str
        Files of other programs, any of `FORMATS`.

    Raises
    ------
    ParameterError
        For an unknown format, axes or unit, or depth units that are not a positive number.
    """

    depth_formats: tuple[str, ...] = ("png", "npy")
    depth_units: float = 1000.0
    expected_error: bool = True
    labels: bool = True
    curves: bool = True
    cloud: str | None = "ply"
    axes: str = "camera"
    cloud_unit: str = "m"
    run_record: bool = True
    mesh: str | None = None
    normals: bool = False
    drop_flying: bool = False
    exports: tuple[str, ...] = field(default=(), metadata={"optional": True})

    def __post_init__(self) -> None:
        for name in ("exports", "depth_formats"):
            object.__setattr__(self, name, tuple(dict.fromkeys(getattr(self, name))))
        known: tuple[tuple[tuple[str | None, ...], Collection[str | None], str], ...] = (
            (self.exports, FORMATS, "export format"),
            (self.depth_formats, DEPTH_FILES, "depth format"),
            ((self.cloud,), (*CLOUD_FILES, None), "point cloud format"),
            ((self.mesh,), (*MESH_FILES, None), "mesh format"),
            ((self.axes,), CLOUD_AXES, "axes of the point cloud"),
            ((self.cloud_unit,), CLOUD_UNITS, "unit of the point cloud"),
        )
        for values, choices, what in known:
            for value in values:
                if value not in choices:
                    raise ParameterError(f"There is no {what} {value!r}. Known: {', '.join(filter(None, choices))}.")
        if not (math.isfinite(self.depth_units) and self.depth_units > 0):
            raise ParameterError(f"Depth units must be a positive number per metre, as 1000, not {self.depth_units!r}.")

    def filenames(self) -> tuple[str, ...]:
        """Names of the selected files; `ilf.run.writing.filenames` adds those that depend on the run."""
        names = [DEPTH_FILES[depth_format] for depth_format in self.depth_formats]
        if self.expected_error:
            names += [ERROR_FILES[depth_format] for depth_format in self.depth_formats]
            names += [files.UNSUPPORTED] if self.depth_formats else []
        if self.labels:
            names.append(files.LABELS)
        if self.curves:
            names.append(files.CURVES)
        if self.cloud is not None:
            names.append(CLOUD_FILES[self.cloud])
        if self.mesh is not None:
            names.append(MESH_FILES[self.mesh])
        names += [FORMATS[name].file for name in self.exports]
        if self.run_record:
            names.append(RECORD_FILE)
        return tuple(names)


def drop_impossible_cloud(
    options: ExportOptions, frame: RGBDFrame, remedy: str = ""
) -> tuple[ExportOptions, tuple[str, ...]]:
    """Remove the cloud from the options if the frame has no intrinsics; returns options and a note that ends with the
    remedy."""
    if frame.intrinsics is not None or options.cloud is None:
        return options, ()
    note = f"No point cloud is written, because the camera's intrinsics are not known{remedy}."
    return replace(options, cloud=None), (note,)


def drop_impossible(options: ExportOptions, run: Run) -> tuple[ExportOptions, tuple[str, ...]]:
    """Remove from the options what cannot be made of a run; returns options and notes."""
    kept, notes = drop_impossible_cloud(options, run.frame)
    lacks = {name: why for name in options.exports if (why := FORMATS[name].lacks(run))}
    exports = tuple(name for name in options.exports if name not in lacks)
    return replace(kept, exports=exports), (*notes, *(f"No {name} is written. {why}" for name, why in lacks.items()))


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
