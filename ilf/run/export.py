"""Export: the choice of files, formats and units, and writing all of them or none."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cloud import AXES, point_cloud
from ..completion import Completion
from ..confidence import expected_error
from ..dense import fill_rest
from ..errors import ExportError, InputError, ParameterError
from ..frame import RGBDFrame
from ..io import write_cloud, write_depth, write_expected_error, write_labels, write_mask
from ..io.atomic import write_bytes
from ..io.cloud_files import UNITS_PER_METRE, check_cloud_format
from .curve_files import write_curves

LABELS_FILE, CURVES_FILE, RECORD_FILE, GUESSED_FILE = "blocks.png", "curves.csv", "run.json", "guessed.png"

DEPTH_FILES = {"png": "depth.png", "tiff": "depth.tiff", "npy": "depth.npy"}
"""Depth format -> file name. PNG is 16 bit in `depth_units`; TIFF and NPY are float32 metres."""

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

CLOUD_AXES = AXES
CLOUD_UNITS = tuple(UNITS_PER_METRE)


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
        Beside every depth file, one of the same format and units with the expected error of the filled pixels.
    dense : bool
        Guess the depth that is missing after the run (`ilf.dense.fill_rest`), and write a mask of what is guessed.
    labels, curves : bool
        The label map as PNG; the record of every iteration as CSV.
    cloud : str or None
        Format of the point cloud: "ply" (binary), "ply-ascii", "pcd", "xyz", "xyzrgb"; None for no cloud.
    axes : str
        "camera" (x right, y down, z forward) or "y-up" (x right, y up, z backward).
    cloud_unit : str
        "m" or "mm".
    run_record : bool
        `run.json`, which replays the run.

    Raises
    ------
    ParameterError
        For an unknown format, axes or unit, or depth units that are not a positive number.
    """

    depth_formats: tuple[str, ...] = ("png", "npy")
    depth_units: float = 1000.0
    expected_error: bool = True
    dense: bool = False
    labels: bool = True
    curves: bool = True
    cloud: str | None = "ply"
    axes: str = "camera"
    cloud_unit: str = "m"
    run_record: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "depth_formats", tuple(dict.fromkeys(self.depth_formats)))
        for depth_format in self.depth_formats:
            _require(depth_format, tuple(DEPTH_FILES), "depth format")
        if self.cloud is not None:
            _require(self.cloud, tuple(CLOUD_FILES), "point cloud format")
        _require(self.axes, CLOUD_AXES, "axes of the point cloud")
        _require(self.cloud_unit, CLOUD_UNITS, "unit of the point cloud")
        if not (math.isfinite(self.depth_units) and self.depth_units > 0):
            raise ParameterError(
                f"Depth units must be a positive number per metre (1000 for millimetres), not {self.depth_units!r}."
            )

    def filenames(self) -> tuple[str, ...]:
        """Names of the files that the export writes into its folder."""
        names = [DEPTH_FILES[depth_format] for depth_format in self.depth_formats]
        if self.expected_error:
            names += [ERROR_FILES[depth_format] for depth_format in self.depth_formats]
        if self.dense:
            names.append(GUESSED_FILE)
        if self.labels:
            names.append(LABELS_FILE)
        if self.curves:
            names.append(CURVES_FILE)
        if self.cloud is not None:
            names.append(CLOUD_FILES[self.cloud])
        if self.run_record:
            names.append(RECORD_FILE)
        return tuple(names)


def output_folder_name(frame_name: str) -> str:
    """Name of the folder that a frame's results go into unless someone says otherwise."""
    return re.sub(r"[^\w.-]+", "_", frame_name) + "-ilf"


@dataclass(frozen=True)
class ExportReport:
    """What an export has written.

    Attributes
    ----------
    files : tuple of Path
        In the order of `ExportOptions.filenames`.
    warnings : tuple of str
        What was lost on the way into the files, and how to keep it.
    """

    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def export(
    folder: str | os.PathLike[str],
    frame: RGBDFrame,
    labels: NDArray[np.int32],
    completion: Completion,
    options: ExportOptions,
    *,
    run_record: Mapping[str, Any] | None = None,
    overwrite: bool = True,
) -> ExportReport:
    """Write the chosen files into a folder: all of them, or none.

    Parameters
    ----------
    folder : path-like
        Made if it is not there. Other files in it are left alone.
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
        The label map that was run.
    completion : Completion
    options : ExportOptions
    run_record : mapping, optional
        From `ilf.run.record.make_run_record`; needed where `options.run_record` asks for it.
    overwrite : bool
        Whether files of an earlier export may be replaced.

    Returns
    -------
    ExportReport

    Raises
    ------
    InputError
        If a cloud is asked for and the frame has no intrinsics. Nothing is written then.
    ExportError
        If a file would replace one of the frame's own, or cannot be written. The folder is as it was then.
    """
    target = Path(folder).absolute()
    check_export(target, frame, options, overwrite=overwrite)
    if options.run_record and run_record is None:
        raise ExportError("run.json is asked for, but there is no record of the run. Make one, or leave it out.")
    with _staging(target) as staging:
        warnings = _write_all(staging, frame, labels, completion, options)
        if options.run_record and run_record is not None:
            text = json.dumps(run_record, indent=2, allow_nan=False)
            write_bytes(staging / RECORD_FILE, f"{text}\n".encode())
            if run_record["blocks"]["edited"] and not options.labels:
                warnings.append(f"{RECORD_FILE} cannot be replayed without {LABELS_FILE}: the blocks were edited.")
        names = options.filenames()
        _move_in(staging, target, names)
    return ExportReport(tuple(target / name for name in names), tuple(warnings))


def check_export(
    folder: str | os.PathLike[str], frame: RGBDFrame, options: ExportOptions, *, overwrite: bool = True
) -> None:
    """Find out before a long run what would keep its export from being written.

    Raises
    ------
    InputError, ExportError
        As `export` does.
    """
    target = Path(folder)
    if options.cloud is not None:
        check_cloud_format(CLOUD_FILES[options.cloud])
    if options.cloud is not None and frame.intrinsics is None:
        raise InputError(
            "A point cloud needs the camera's intrinsics, and this frame has none. Give them as a preset "
            "(such as nyu-kinect-v1), as fx,fy,cx,cy or as a JSON file; or leave the cloud out."
        )
    if target.exists() and not target.is_dir():
        raise ExportError(f"{target} is a file, not a folder. Choose another folder.")
    paths = [target / name for name in options.filenames()]
    check_not_an_input(frame, paths)
    for path in paths:
        if path.is_dir():
            raise ExportError(f"{path} is a folder, and a file of that name is to be written. Choose another folder.")
        if path.exists() and not overwrite:
            raise ExportError(f"{path} is there already. Choose another folder, or allow to overwrite it.")


def check_not_an_input(frame: RGBDFrame, paths: Sequence[Path]) -> None:
    """Raise ExportError if one of the paths is a file that the frame was read from."""
    inputs = [Path(str(frame.sources[role])) for role in ("rgb", "depth") if role in frame.sources]
    for path in paths:
        if path.exists() and any(source.exists() and path.samefile(source) for source in inputs):
            raise ExportError(f"{path} is the frame's own file and would be overwritten. Choose another folder.")


def _write_all(
    folder: Path, frame: RGBDFrame, labels: NDArray[np.int32], completion: Completion, options: ExportOptions
) -> list[str]:
    """Write the results, without the run's record; returns warnings."""
    warnings: list[str] = []
    if options.dense:
        completion = fill_rest(frame, completion)
        write_mask(folder / GUESSED_FILE, completion.guessed)
        if count := np.count_nonzero(completion.guessed):
            warnings.append(f"{count} pixels of the depth are guesses, which no block vouches for: see {GUESSED_FILE}.")
    for depth_format in options.depth_formats:
        name = DEPTH_FILES[depth_format]
        found = write_depth(folder / name, completion.depth, options.depth_units)
        warnings += [f"{name}: {warning}" for warning in found]
    if options.expected_error and options.depth_formats:
        error = expected_error(frame, completion)
        for depth_format in options.depth_formats:
            name = ERROR_FILES[depth_format]
            found = write_expected_error(folder / name, error, options.depth_units)
            warnings += [f"{name}: {warning}" for warning in found]
    if options.labels:
        write_labels(folder / LABELS_FILE, labels)
    if options.curves:
        write_curves(folder / CURVES_FILE, completion.history)
    if options.cloud is not None:
        write_cloud(
            folder / CLOUD_FILES[options.cloud],
            point_cloud(completion.depth, frame.rgb, frame.intrinsics),
            axes=options.axes,
            unit=options.cloud_unit,
            ascii=options.cloud == "ply-ascii",
        )
    return warnings


@contextmanager
def _staging(target: Path) -> Iterator[Path]:
    """A temporary folder inside `target`, which is made if need be and unmade again if the block fails."""
    missing = [path for path in (target, *target.parents) if not path.exists()]
    try:
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".ilf-export-", dir=target) as staging, _naming(staging, target):
            yield Path(staging)
    except BaseException as error:
        for path in missing:
            if path.is_dir() and not any(path.iterdir()):
                path.rmdir()
        if isinstance(error, OSError):
            raise ExportError(f"Could not write into {target}: {error.strerror or error}.") from error
        raise


@contextmanager
def _naming(staging: str, target: Path) -> Iterator[None]:
    """Have errors of the writers name the file's final place: the temporary one means nothing to anyone."""
    try:
        yield
    except ExportError as error:
        raise ExportError(str(error).replace(staging, str(target))) from error


def _move_in(staging: Path, target: Path, names: Sequence[str]) -> None:
    """Put all staged files into their places; if one cannot be, those before it are taken back."""
    aside = staging / "before"
    aside.mkdir()
    try:
        for name in names:
            if (target / name).exists():
                os.replace(target / name, aside / name)
            os.replace(staging / name, target / name)
    except BaseException:
        for name in names:
            if (aside / name).exists():
                os.replace(aside / name, target / name)
            elif not (staging / name).exists():
                (target / name).unlink(missing_ok=True)
        raise


def _require(value: str, known: tuple[str, ...], what: str) -> None:
    if value not in known:
        raise ParameterError(f"There is no {what} {value!r}. Known: {', '.join(known)}.")
