"""The table of formats of other programs that a completed frame is exported in. A new one is a function and a line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from .._runtime.installation import optional
from ..data.camera import Camera
from ..data.frame import RGBDFrame
from ..data.results import Completion
from ..errors import InputError
from ..io.block_files import encode_blocks, palette_problem, path_from
from ..io.cameras import camera_info_yaml, camera_json, opencv_yaml
from ..io.depth import encode_depth
from .run import Run

DEPTH, BLOCKS, CAMERA = "depth", "blocks", "camera"
"""What a file is about: its group in the window's dialog."""

TUM_UNITS = 5000.0
"""Units per metre of depth in TUM's data sets."""


class Format(NamedTuple):
    """A format.

    Attributes
    ----------
    group : str
        DEPTH, BLOCKS or CAMERA.
    title : str
        For the user.
    file : str
        Name of the file among the results; other files of the format end in a dot and the format's name.
    content : callable
        Makes the file, and notes on what it does not preserve, of a completed frame and the path of the colour file as
        seen from the file ("" for none).
    lacks : callable
        Says in a sentence why the file cannot be made of a run; "" if it can.
    """

    group: str
    title: str
    file: str
    content: Callable[[Completion, str], tuple[bytes, Sequence[str]]]
    lacks: Callable[[Run], str] = lambda run: ""


def _depth(completion: Completion, image: str, *, name: str, units: float = 1.0) -> tuple[bytes, Sequence[str]]:
    return encode_depth(name, completion.depth, units)


def _no_exr(run: Run) -> str:
    try:
        optional("OpenEXR", "ilf-studio[sensors]", "Writing EXR")
    except InputError as error:
        return str(error)
    return ""


def _blocks(completion: Completion, image: str, *, format: str) -> tuple[bytes, Sequence[str]]:
    blocks = completion.run.blocks
    return encode_blocks(format, blocks.labels, blocks.names, blocks.colours, image), ()


def _camera(
    completion: Completion, image: str, *, write: Callable[[Camera, tuple[int, int]], bytes]
) -> tuple[bytes, Sequence[str]]:
    camera = completion.frame.intrinsics
    if camera is None:
        raise InputError(_no_camera(completion.run))
    return write(camera, completion.frame.shape), ()


def _no_camera(run: Run) -> str:
    if run.frame.intrinsics is not None:
        return ""
    return "The frame has no camera intrinsics: give them as a preset (kinect-v2), as fx,fy,cx,cy or as a file."


FORMATS = {
    "exr": Format(DEPTH, "EXR, float32 metres", "depth.exr", partial(_depth, name="depth.exr"), _no_exr),
    "tum.png": Format(DEPTH, "PNG, 5000/m (TUM)", "depth.tum.png", partial(_depth, name="depth.png", units=TUM_UNITS)),
    "palette.png": Format(
        BLOCKS,
        "Label map, coloured",
        "blocks.palette.png",
        partial(_blocks, format="palette"),
        lambda run: palette_problem(run.blocks.labels),
    ),
    "coco.json": Format(BLOCKS, "COCO, run lengths", "blocks.coco.json", partial(_blocks, format="coco-rle")),
    "labelme.json": Format(BLOCKS, "labelme, polygons", "blocks.labelme.json", partial(_blocks, format="labelme")),
    "camera.json": Format(CAMERA, "JSON (Open3D)", "camera.json", partial(_camera, write=camera_json), _no_camera),
    "opencv.yaml": Format(CAMERA, "OpenCV", "camera.opencv.yaml", partial(_camera, write=opencv_yaml), _no_camera),
    "camera_info.yaml": Format(
        CAMERA, "ROS camera_info", "camera_info.yaml", partial(_camera, write=camera_info_yaml), _no_camera
    ),
}
"""Name, which is the ending of files -> format."""


def check_format(name: str, run: Run) -> None:
    """Raise InputError if a format cannot be made of a run."""
    if why := FORMATS[name].lacks(run):
        raise InputError(f"No {name} can be written. {why}")


def colour_seen_from(folder: Path, frame: RGBDFrame) -> str:
    """Path of a frame's colour file as seen from a folder; "" if it has none of its own."""
    inputs = frame.inputs
    return path_from(folder, inputs.rgb.path) if inputs is not None and inputs.has_colour_file else ""
