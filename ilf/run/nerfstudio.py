"""Export of completed frames with poses as a nerfstudio data set, with a depth weight for every pixel."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import read_file, write_bytes
from .._runtime.formatting import counted
from ..data.camera import CameraIntrinsics
from ..errors import ExportError, InputError, cause
from ..io.cameras import intrinsics_from
from ..io.depth import read_depth_values, write_depth
from ..io.depth_reading import read_depth
from ..io.images import encode_image, read_colour
from ..io.labels import read_mask
from ..sources.frames import frame_folder
from ..sources.opening import is_recording, opened
from ..sources.pairing import natural
from ..sources.poses import OPENGL_AXES
from .options import ERROR_FILES, RECORD_FILE, UNSUPPORTED_FILE
from .record import RunRecord
from .record_file import read_record
from .writing import Written

# Results in a folder.


def result_folders(path: str | os.PathLike[str]) -> list[Path]:
    """The folder itself if it has a result, or the folders with results in it, by name; InputError without any."""
    root = Path(path).absolute()
    if (root / RECORD_FILE).is_file():
        return [root]
    try:
        inside = (inner for inner in root.iterdir() if (inner / RECORD_FILE).is_file())
        found = sorted(inside, key=lambda inner: natural(inner.name))
    except OSError as error:
        raise InputError(f"{root}: cannot be read ({cause(error)}). Give a folder with results.") from error
    if not found:
        raise InputError(
            f"{root} contains no results: there is no {RECORD_FILE} in it or its folders. Give a folder with results."
        )
    return found


TRANSFORMS_FILE = "transforms.json"

_IMAGES, _DEPTHS, _WEIGHTS = "images", "depths", "depth_weights"
_UNITS = 1000.0
_HALF_WEIGHT = 0.01
"""Expected error, as a share of the depth, that halves its weight."""

_PIXEL_CENTRE = 0.5
"""Position of the first pixel's centre in nerfstudio; 0 here."""


@dataclass(frozen=True, eq=False)
class _Result:
    """A result ready for export: its record, pose, camera and pixels."""

    record: RunRecord
    pose: NDArray[np.float64]
    camera: CameraIntrinsics
    colour: NDArray[np.uint8]
    depth: NDArray[np.float32]
    weight: NDArray[np.float32] | None


def depth_weight(
    depth: ArrayLike, error: ArrayLike, unsupported: NDArray[np.bool_] | None = None
) -> NDArray[np.float32]:
    """Weight of depth in a fit: 1 / (1 + (error / (1 % of the depth))²).

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W), NaN = missing.
    error : array_like
        Expected error [m], (H, W), from `ilf.expected_error`: NaN where depth was measured or is missing.
    unsupported : ndarray of bool, optional
        Mask (H, W) from `ilf.unsupported`.

    Returns
    -------
    ndarray of float32, shape (H, W)
        1 where depth was measured, 0.5 where the expected error is 1 % of it, 0 where it is missing or unsupported.

    Examples
    --------
    >>> depth_weight([[2.0, 2.0, np.nan]], [[np.nan, 0.02, np.nan]]).tolist()
    [[1.0, 0.5, 0.0]]
    """
    metres, expected = np.asarray(depth, np.float64), np.nan_to_num(np.asarray(error, np.float64))
    weight = np.where(np.isfinite(metres), 1 / (1 + (expected / (_HALF_WEIGHT * metres)) ** 2), 0)
    if unsupported is not None:
        weight[unsupported] = 0
    return weight.astype(np.float32)


def write_nerfstudio(folder: str | os.PathLike[str], results: Iterable[str | os.PathLike[str]]) -> Written:
    """Write results as a nerfstudio data set.

    `transforms.json` lists for each frame the colour, the completed depth (16-bit PNG in millimetres) and, if expected
    errors were written, `depth_weight_file_path`, an 8-bit PNG of `depth_weight` times 255 for custom loss functions.
    Frames of phones have their colour at the recorded resolution if the recording is available: nerfstudio accepts
    depth of another size.

    Parameters
    ----------
    folder : path-like
        Created if missing; must be empty otherwise.
    results : iterable of path-like
        Folders written by `CompletedRun.save` or `ilf complete`, or folders that contain such folders. Frames without a
        known pose are left out, with a note.

    Returns
    -------
    Written

    Raises
    ------
    InputError
        If none of them has a pose and a camera, or one of them is not a result or incomplete.
    ExportError
        If the folder is not empty, or cannot be written into.
    """
    target = Path(folder).absolute()
    found = [path for one in results for path in result_folders(one)]
    if os.path.exists(target) and (not target.is_dir() or any(target.iterdir())):
        raise ExportError(f"{target} already exists and is not an empty folder. Choose another one.")
    frames: list[dict[str, Any]] = []
    files: list[Path] = []
    lonely, notes = [], []
    for path in found:
        record = read_record(path / RECORD_FILE)
        if record.pose is None:
            lonely.append(path.name)
            continue
        entry, written, told = _write_frame(target, len(frames) + 1, _result(path, record))
        frames.append(entry)
        files += written
        notes += told
    if not frames:
        raise InputError(
            f"Nerfstudio needs poses, and none of the {len(found)} results has one. Use frames of TUM sequences, "
            "7-Scenes, ScanNet, ARKitScenes, Record3D or Stray Scanner, or give the pose in meta.json."
        )
    if lonely:
        named = f"{', '.join(lonely[:3])!s:.200}"
        notes.insert(0, f"Left out, without a known pose: {counted(len(lonely), 'result')} ({named}).")
    data = {"camera_model": "OPENCV", "depth_unit_scale_factor": 1 / _UNITS, "frames": frames}
    _write(target / TRANSFORMS_FILE, f"{json.dumps(data, indent=1)}\n".encode())
    return Written((*files, target / TRANSFORMS_FILE), tuple(dict.fromkeys(notes)))


def _result(folder: Path, record: RunRecord) -> _Result:
    files = frame_folder(folder)
    depth = read_depth(read_file(files.depth), None, files.options.depth_encoding).metres
    camera, colour, told = intrinsics_from(files.options.intrinsics), None, record.inputs
    if told is not None and told.frame is not None and is_recording(told.rgb.path):
        with opened(told.rgb.path) as recording:
            cameras = recording.cameras(told.frame)
            if cameras.is_registered and cameras.colour is not None and cameras.colour.shape != depth.shape:
                camera, colour = cameras.colour.intrinsics, recording.colour(told.frame)
    if camera is None or record.pose is None:
        raise InputError(f"{folder}: the camera's intrinsics are not known; nerfstudio needs them. Give --intrinsics.")
    rgb = read_colour(files.rgb) if colour is None else colour
    return _Result(record, np.array(record.pose), camera, rgb, depth, _weight(folder, record, depth))


def _weight(folder: Path, record: RunRecord, depth: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """None where no expected errors were written."""
    options = record.export
    if not options.expected_error or not options.depth_formats:
        return None
    depth_format = next(known for known in ("npy", "tiff", "png") if known in options.depth_formats)
    stored = read_depth_values(folder / ERROR_FILES[depth_format]).astype(np.float64)
    error = np.where(stored > 0, stored / (options.depth_units if depth_format == "png" else 1), np.nan)
    return depth_weight(depth, error, read_mask(folder / UNSUPPORTED_FILE, (depth.shape[0], depth.shape[1])))


def _write_frame(target: Path, number: int, result: _Result) -> tuple[dict[str, Any], list[Path], list[str]]:
    """Write a frame's files; returns its entry of transforms.json, the files, and notes."""
    camera, (height, width) = result.camera, result.colour.shape[:2]
    names = {"file_path": f"{_IMAGES}/{number:05}.jpg", "depth_file_path": f"{_DEPTHS}/{number:05}.png"}
    _write(target / names["file_path"], encode_image(".jpg", np.ascontiguousarray(result.colour[..., ::-1])))
    depth = target / names["depth_file_path"]
    depth.parent.mkdir(exist_ok=True)
    notes = [f"{result.record.name}: {note}" for note in write_depth(depth, result.depth, _UNITS)]
    if result.weight is not None:
        names["depth_weight_file_path"] = f"{_WEIGHTS}/{number:05}.png"
        grey = np.rint(255 * result.weight).astype(np.uint8)
        _write(target / names["depth_weight_file_path"], encode_image(".png", grey))
    entry = {
        **names,
        "name": result.record.name,
        "transform_matrix": (result.pose @ OPENGL_AXES).tolist(),
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + _PIXEL_CENTRE,
        "cy": camera.cy + _PIXEL_CENTRE,
        "w": width,
        "h": height,
        **dict.fromkeys(("k1", "k2", "p1", "p2"), 0.0),
    }
    return entry, [target / name for name in names.values()], notes


def _write(path: Path, content: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"Could not write into {path.parent}: {cause(error)}.") from error
    write_bytes(path, content)
