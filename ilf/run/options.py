"""Which files a run's results go into, and how they are written."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

from ..data.frame import RGBDFrame
from ..data.points import AXES
from ..errors import ParameterError
from ..io.clouds import UNITS_PER_METRE

LABELS_FILE, CURVES_FILE, RECORD_FILE = "blocks.png", "curves.csv", "run.json"
GUESSED_FILE, DISTRUSTED_FILE, DRAWN_FILE = "guessed.png", "distrusted.png", "drawn.png"
OUTSIDE_FILE = "outside_view.png"
COLOUR_FILE = "rgb.png"
"""Colour, where no file has it as it is in the frame: taken out of a recording, or without a lens's distortion."""
GUIDE_FILE = "guide_used.npy"

DEPTH_FILES = {"png": "depth.png", "tiff": "depth.tiff", "npy": "depth.npy"}
"""Depth format -> file name. PNG is 16 bit in `depth_units`; TIFF and NPY are float32 metres."""

ERROR_FILES = {"png": "expected_error.png", "tiff": "expected_error.tiff", "npy": "expected_error.npy"}
"""Depth format -> file name of the expected error, in the same units."""

UNVOUCHED_FILE = "unvouched.png"
"""Mask, beside the expected errors, of the filled pixels that nothing vouches for."""

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
"""Letters of a frame's name in the names of files, which may have 255 bytes."""


@dataclass(frozen=True)
class ExportOptions:
    """Which files an export writes, and how.

    Parameters
    ----------
    depth_formats : tuple of str
        Files of the completed depth: any of "png" (uint16), "tiff" and "npy" (float32 metres).
    depth_units : float
        Units per metre of the 16-bit PNG: 1000 for millimetres.
    expected_error : bool
        Beside every depth file, one of the same format and units with the expected error of the filled pixels; and a
        mask of those that nothing vouches for.
    labels, curves : bool
        The label map as PNG; the record of every iteration as CSV.
    cloud : str or None
        Format of the point cloud: "ply" (binary), "ply-ascii", "pcd", "xyz", "xyzrgb"; None for no cloud.
    axes : str
        Of cloud and mesh: "camera" (x right, y down, z forward), "y-up" (x right, y up, z backward), or "world", where
        the frame's pose puts them.
    cloud_unit : str
        Of cloud and mesh: "m" or "mm".
    run_record : bool
        `run.json`, which replays the run.
    mesh : str or None
        Format of the mesh, cut where depth jumps: "ply", "obj", "glb" (always y up, in metres); None for no mesh.
    normals : bool
        Of every point of cloud and mesh, which way its surface faces.
    drop_flying : bool
        Leave out points that hang in mid-air between surfaces, of cloud and mesh.

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "depth_formats", tuple(dict.fromkeys(self.depth_formats)))
        for depth_format in self.depth_formats:
            _require(depth_format, tuple(DEPTH_FILES), "depth format")
        if self.cloud is not None:
            _require(self.cloud, tuple(CLOUD_FILES), "point cloud format")
        if self.mesh is not None:
            _require(self.mesh, tuple(MESH_FILES), "mesh format")
        _require(self.axes, CLOUD_AXES, "axes of the point cloud")
        _require(self.cloud_unit, CLOUD_UNITS, "unit of the point cloud")
        if not (math.isfinite(self.depth_units) and self.depth_units > 0):
            raise ParameterError(
                f"Depth units must be a positive number per metre (1000 for millimetres), not {self.depth_units!r}."
            )

    def filenames(self) -> tuple[str, ...]:
        """Names of the files that are chosen here. What the run itself asks for beside them: `ilf.run.filenames`."""
        names = [DEPTH_FILES[depth_format] for depth_format in self.depth_formats]
        if self.expected_error:
            names += [ERROR_FILES[depth_format] for depth_format in self.depth_formats]
            names += [UNVOUCHED_FILE] if self.depth_formats else []
        if self.labels:
            names.append(LABELS_FILE)
        if self.curves:
            names.append(CURVES_FILE)
        if self.cloud is not None:
            names.append(CLOUD_FILES[self.cloud])
        if self.mesh is not None:
            names.append(MESH_FILES[self.mesh])
        if self.run_record:
            names.append(RECORD_FILE)
        return tuple(names)


def without_impossible_cloud(
    options: ExportOptions, frame: RGBDFrame, way_out: str = ""
) -> tuple[ExportOptions, tuple[str, ...]]:
    """The options without a cloud where the frame has no camera to make one with, and a note about it that ends with
    what to do."""
    if frame.intrinsics is not None or options.cloud is None:
        return options, ()
    note = f"No point cloud is written, because the camera's intrinsics are not known{way_out}."
    return replace(options, cloud=None), (note,)


def output_folder_name(frame_name: str) -> str:
    """Name of the folder that a frame's results go into unless someone says otherwise."""
    return f"{as_file_name(frame_name)}-ilf"


def as_file_name(frame_name: str) -> str:
    """A frame's name without what names of files cannot have.

    Examples
    --------
    >>> as_file_name("the room: 2 / 3")
    'the_room_2_3'
    """
    return re.sub(r"[^\w.-]+", "_", frame_name)[:_LONGEST_NAME] or "frame"


def _require(value: str, known: tuple[str, ...], what: str) -> None:
    if value not in known:
        raise ParameterError(f"There is no {what} {value!r}. Known: {', '.join(known)}.")
