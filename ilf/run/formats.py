"""Export of a completed frame for other programs: the table of formats, Rerun, and plugins."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import NamedTuple

from .._runtime.installation import optional
from .._runtime.plugins import EXPORTERS, call, entry_of_file, entry_points, load, package_of
from .._runtime.writing import atomic_path, ensure_folder, write_bytes
from ..data.camera import Camera
from ..data.frame import RGBDFrame
from ..data.results import Completion
from ..errors import ExportError, InputError, ParameterError
from ..io.block_files import encode_blocks, palette_problem, path_from
from ..io.cameras import camera_info_yaml, camera_json, opencv_yaml
from ..io.depth import encode_depth
from ..io.encodings import TUM_UNITS
from .run import Run

DEPTH, BLOCKS, CAMERA = "depth", "blocks", "camera"
"""What a file is about: its group in the window's dialog."""

Made = tuple[bytes, Sequence[str]]
"""Content of a file, and notes on what it does not preserve."""

Content = Callable[[Completion, str], Made]
"""Makes a file of a completed frame and the path of the colour file as seen from the file ("" for none)."""


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
        Makes the file, see `Content`.
    lacks : callable
        Says in a sentence why the file cannot be made of a run; "" if it can.
    """

    group: str
    title: str
    file: str
    content: Content
    lacks: Callable[[Run], str] = lambda run: ""

    def __str__(self) -> str:
        """What forms and helps show."""
        return f"{self.group}: {self.title}"


def _depth(name: str, units: float = 1.0) -> Content:
    return lambda completion, image: encode_depth(name, completion.depth, units)


def _blocks(format: str) -> Content:
    def content(completion: Completion, image: str) -> Made:
        blocks = completion.run.blocks
        return encode_blocks(format, blocks.labels, blocks.names, blocks.colours, image), ()

    return content


def _camera(write: Callable[[Camera, tuple[int, int]], bytes]) -> Content:
    def content(completion: Completion, image: str) -> Made:
        camera = completion.frame.intrinsics
        assert camera is not None, "a run without one lacks it"
        return write(camera, completion.frame.shape), ()

    return content


def _no_exr(run: Run) -> str:
    try:
        optional("OpenEXR", "ilf-studio[sensors]", "Writing EXR")
    except InputError as error:
        return str(error)
    return ""


def _no_camera(run: Run) -> str:
    if run.frame.intrinsics is not None:
        return ""
    return "The frame has no camera intrinsics: give them as a preset (kinect-v2), as fx,fy,cx,cy or as a file."


def _no_palette(run: Run) -> str:
    return palette_problem(run.blocks.labels)


FORMATS = {
    "exr": Format(DEPTH, "EXR, float32 metres", "depth.exr", _depth("depth.exr"), _no_exr),
    "tum.png": Format(DEPTH, "PNG, 5000/m (TUM)", "depth.tum.png", _depth("depth.png", TUM_UNITS)),
    "palette.png": Format(BLOCKS, "Label map, coloured", "blocks.palette.png", _blocks("palette"), _no_palette),
    "coco.json": Format(BLOCKS, "COCO, run lengths", "blocks.coco.json", _blocks("coco-rle")),
    "labelme.json": Format(BLOCKS, "labelme, polygons", "blocks.labelme.json", _blocks("labelme")),
    "camera.json": Format(CAMERA, "JSON (Open3D)", "camera.json", _camera(camera_json), _no_camera),
    "opencv.yaml": Format(CAMERA, "OpenCV", "camera.opencv.yaml", _camera(opencv_yaml), _no_camera),
    "camera_info.yaml": Format(CAMERA, "ROS camera_info", "camera_info.yaml", _camera(camera_info_yaml), _no_camera),
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


# A file of its own: of the table, of Rerun, or of a plugin.

_BUILT_IN = (EntryPoint("rrd", "ilf.run.rerun_file:RerunFile", EXPORTERS),)


class Export:
    """An export into one file, in the format of its extension.

    Parameters
    ----------
    path : path-like
        A file of that name is replaced; the folder is created if missing.

    Raises
    ------
    ParameterError
        If no format has this extension.
    InputError
        If the format needs a package that is not installed, or its plugin fails.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        of_table = tuple(EntryPoint(name, "ilf.run.formats:FORMATS", EXPORTERS) for name in FORMATS)
        entries = (*of_table, *_BUILT_IN, *entry_points(EXPORTERS))
        entry = entry_of_file(path, entries)
        if entry is None:
            known = ", ".join(f".{each.name}" for each in entries)
            raise ParameterError(f"{path}: there is no export with this extension. Known: {known}.")
        self.path = Path(path)
        self._entry = entry
        self._write: Callable[[Path, Completion], None] | None = (
            None if entry in of_table else call(entry, lambda: load(entry)().write)
        )
        """Of what is not in the table: of an object that the class of the entry point makes, before the run, so that a
        missing package is reported then. It writes into the existing, empty file at the path."""

    def check(self, run: Run) -> None:
        """Raise InputError if the file cannot be made of a run."""
        if self._write is None:
            check_format(self._entry.name, run)

    def write(self, completion: Completion) -> Sequence[str]:
        """Write the file; returns notes on what it does not preserve.

        Raises
        ------
        ExportError
            If it cannot be written. An existing file is unchanged then.
        InputError
            If it cannot be made of this run, or the plugin fails; likewise.
        """
        self.check(completion.run)
        ensure_folder(self.path.parent)
        if self._write is None:
            image = colour_seen_from(self.path.parent, completion.frame)
            content, notes = FORMATS[self._entry.name].content(completion, image)
            write_bytes(self.path, content)
            return [f"{self.path.name}: {note}" for note in notes]
        with atomic_path(self.path) as temporary:
            call(self._entry, self._write, temporary, completion)
            if not (temporary.exists() and temporary.stat().st_size):
                raise ExportError(f"{self.path}: {package_of(self._entry)} has written nothing. Update that package.")
        return ()
