"""Camera poses: checked matrices, and files in the forms of several programs."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import FileContent, read_file, read_json
from ..data.camera import checked_transform, rigid_transform
from ..data.frame import RGBDFrame
from ..errors import FormatError, InputError, ParameterError
from ..io.camera_files import cameras_in, chosen_camera
from ..io.cameras import CAMERA_FILE, read_cameras
from ..io.encodings import checked_units
from .pairing import MAX_TIME_GAP_S

Matrix = NDArray[np.float64]

OPENGL_AXES = np.diag([1.0, -1.0, -1.0, 1.0])
"""Transform of points between camera axes y down, z forward and y up, z backward; its own inverse."""


def as_pose(numbers: ArrayLike) -> Matrix | None:
    """The camera pose of 12 or 16 numbers, row by row; None if they are no pose."""
    flat = np.asarray(numbers, np.float64).ravel()
    if flat.size not in {12, 16}:
        return None
    return checked_pose(np.append(flat, (0, 0, 0, 1)[: 16 - flat.size]).reshape(4, 4))


def pose_at_time(rows: Matrix, time: str) -> Matrix | None:
    """The pose nearest in time, from a trajectory with rows of time, tx ty tz, qx qy qz qw; None if the text is no
    time, or there is none within `MAX_TIME_GAP_S`."""
    try:
        wanted = float(time)
    except ValueError:
        return None
    rows = rows[np.isfinite(rows).all(axis=1)]
    if rows.shape[1:] != (8,) or not rows.size:
        return None
    row = rows[np.argmin(np.abs(rows[:, 0] - wanted))]
    return posed(row[4:], row[1:4]) if abs(row[0] - wanted) <= MAX_TIME_GAP_S else None


def posed(quaternion: ArrayLike, position: ArrayLike) -> Matrix | None:
    """The camera pose from a quaternion x, y, z, w and a position [m]; None if they are not a valid pose."""
    length = math.hypot(*np.asarray(quaternion, np.float64))
    if not 0 < length < math.inf:
        return None
    return checked_pose(turned_and_moved(np.asarray(quaternion, np.float64) / length, position))


def turned_and_moved(quaternion: Matrix, position: ArrayLike) -> Matrix:
    """The transform, (4, 4), by a quaternion x, y, z, w of length 1 and a translation."""
    x, y, z, w = quaternion
    rotation = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return rigid_transform(rotation, position)


def checked_pose(pose: Matrix) -> Matrix | None:
    """The pose if it is valid, else None; where tracking was lost, files contain other numbers."""
    try:
        return checked_transform(pose, "")
    except InputError:
        return None


# Files with poses.

_LAST_NUMBER = re.compile(r"(\d+)\D*$")
_LOG_ROWS = 5
"""Lines of a pose in a .log file of Open3D: three integers, then the four rows of the matrix."""

_UP = re.compile(r"^(\.\./)+")
_MATTERPORT_SIZE = 1280, 1024
"""Width and height [px] of the images of Matterport3D."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Camera poses, (4, 4), as in the file; None where there is none.

    Attributes
    ----------
    in_order : list
        Of one frame after the other.
    by_name : mapping
        Of images by the ends of their paths, see `image_name`.
    by_time : ndarray, shape (N, 8)
        Rows of time [s], position and quaternion x, y, z, w.
    cameras : mapping
        Intrinsics of images, by the same names as the poses.
    depth_files : mapping
        Paths of depth files relative to the folder of the file, by the paths of their images; "" where none is listed.
    depth_units : float or None
        File units per metre of depth, if stated.
    """

    in_order: list[Matrix | None] = field(default_factory=list)
    by_name: Mapping[str, Matrix | None] = field(default_factory=dict)
    by_time: Matrix = field(default_factory=lambda: np.empty((0, 8)))
    cameras: Mapping[str, Any] = field(default_factory=dict)
    depth_files: Mapping[str, str] = field(default_factory=dict)
    depth_units: float | None = None

    def pose(self, rgb: str, place: int, count: int) -> Matrix | None:
        """The pose of a frame; None if not known.

        Parameters
        ----------
        rgb : str
            Path of its colour file.
        place, count : int
            Its place among the frames of the trajectory, from 0, and their number. Poses in order belong to the frames
            in order if there are as many; otherwise to the number in a frame's name, from 0.
        """
        stem = os.path.splitext(os.path.basename(rgb))[0]
        if self.by_name:
            return _of_image(self.by_name, rgb)
        if len(self.by_time):
            return pose_at_time(self.by_time, stem)
        number = place if count == len(self.in_order) else _number_in(stem)
        return self.in_order[number] if number is not None and number < len(self.in_order) else None

    def camera(self, rgb: str) -> Any:
        """The intrinsics of an image, as `ilf.data.camera.camera_of` takes them; None if not known."""
        return _of_image(self.cameras, rgb)


def _of_image(named: Mapping[str, Any], rgb: str) -> Any:
    """The value of the longest name in which the path of an image ends; None if there is none."""
    parts = image_name(rgb).split("/")
    keys = ("/".join(parts[start:]) for start in range(len(parts)))
    return next((named[key] for key in keys if key in named), None)


def _number_in(stem: str) -> int | None:
    found = _LAST_NUMBER.search(stem)
    return None if found is None or len(found[1]) > 12 else int(found[1])


def read_trajectory(path: Path) -> Trajectory:
    """Read the camera poses of many frames.

    Parameters
    ----------
    path : Path
        A transforms.json of nerfstudio; pose_intrinsic_imu.json of ScanNet++; scene_camera.json of BOP, for cameras
        alone; a camera of Polycam, with t_00 to t_23; a .log of Open3D; a .conf of Matterport3D; or text with a row for
        each frame: 12 or 16 numbers of a matrix, or time, position and quaternion x, y, z, w as in the TUM benchmark. #
        marks comments.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it contains something else.
    """
    content = read_file(path)
    reader = _READERS.get(path.suffix.lower(), _rows_of_text)
    try:
        return reader(content)
    except (ValueError, TypeError, LookupError, ArithmeticError, ParameterError) as error:
        raise FormatError(f"{content} contains no camera poses that can be read ({error!s:.80}).") from error


def _lines(content: FileContent) -> list[list[str]]:
    """The words of the lines of a file that are no comments."""
    text = content.data.tobytes().decode("utf-8", "replace")
    return [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]


def _rows_of_text(content: FileContent) -> Trajectory:
    rows = [[*map(float, words)] for words in _lines(content)]
    widths = {len(row) for row in rows}
    if widths == {8}:
        times = np.array(rows)
        return Trajectory(by_time=times[np.isfinite(times).all(axis=1)])
    if widths == {4}:  # a matrix in several lines
        height = 4 if len(rows) % 4 == 0 else 3
        return Trajectory([as_pose(rows[at : at + height]) for at in range(0, len(rows), height)])
    if not widths <= {12, 16}:
        raise ValueError(f"its lines have {', '.join(map(str, sorted(widths)[:4]))} numbers, not 8, 12 or 16")
    return Trajectory([as_pose(row) for row in rows])


def _log(content: FileContent) -> Trajectory:
    rows = [[*map(float, words)] for words in _lines(content)]
    if len(rows) % _LOG_ROWS or any(len(row) != (3 if at % _LOG_ROWS == 0 else 4) for at, row in enumerate(rows)):
        raise ValueError("a pose must have a line of three integers and four lines of a matrix")
    return Trajectory([as_pose(rows[at + 1 : at + _LOG_ROWS]) for at in range(0, len(rows), _LOG_ROWS)])


def _conf(content: FileContent) -> Trajectory:
    poses, cameras, numbers = {}, {}, [math.nan] * 9
    for words in _lines(content):
        if words[0] == "intrinsics_matrix":
            numbers = [float(word) for word in words[1:10]]
        elif words[0] == "scan":
            name = image_name(words[2])
            poses[name] = as_pose([*map(float, words[3:])])
            fx, cx, fy, cy = (numbers[at] for at in (0, 2, 4, 5))
            width, height = _MATTERPORT_SIZE
            # rows are counted from the bottom
            cameras[name] = {"fx": fx, "fy": fy, "cx": cx, "cy": height - 1 - cy, "width": width, "height": height}
    return Trajectory(by_name=poses, cameras=cameras)


def _transforms(content: FileContent) -> Trajectory:
    if content.path.name == CAMERA_FILE:
        return Trajectory(cameras=_of_scene(content.path))
    data = read_json(content)
    data = data if isinstance(data, dict) else {}
    if "t_00" in data:
        image, pose = content.path.stem, as_pose([data[f"t_{row}{column}"] for row in range(3) for column in range(4)])
        return Trajectory(by_name={image: pose}, cameras={image: chosen_camera(data, str(content))})
    frames, common = data.get("frames"), {name: value for name, value in data.items() if name != "frames"}
    if any(isinstance(one, dict) and "aligned_pose" in one for one in common.values()):  # of ScanNet++
        frames, common = [_of_scannetpp(*named) for named in common.items()], {}
    if not isinstance(frames, list) or not frames:
        raise ValueError("it has no frames")
    cameras: dict[str, Any] = {}
    poses, depth_files = {}, {}
    for stated in (common | frame for frame in frames):
        image = _file(stated["file_path"])
        name = image_name(image)
        poses[name] = as_pose(stated["transform_matrix"])
        if camera := next((camera for _, camera in cameras_in(stated)), None):
            cameras[name] = camera | {"name": content.path.name}
        depth_files[os.path.normpath(image)] = _file(stated.get("depth_file_path") or stated.get("depth_path") or "")
    scale = data.get("depth_unit_scale_factor", data.get("integer_depth_scale"))
    units = None if scale is None else checked_units(1 / float(scale))
    return Trajectory(by_name=poses, cameras=cameras, depth_files=depth_files, depth_units=units)


def _of_scene(path: Path) -> dict[str, Any]:
    """The cameras of a scene of BOP by the names of images, which have six digits, or those of an export fewer."""
    found: dict[str, Any] = {}
    for number, (camera, scale) in read_cameras(path).items():
        stated = {"K": [*camera.numbers], "depth_scale": scale}
        found |= {f"{number:0{digits}}": stated for digits in range(1, 7)}
    return found


def _of_scannetpp(name: str, stated: Mapping[str, Any]) -> dict[str, Any]:
    """A frame of ScanNet++ by the names of nerfstudio."""
    return {"file_path": name, "transform_matrix": stated["aligned_pose"], "K": stated["intrinsic"]}


def _file(path: Any) -> str:
    """A path of a file in JSON, also as Windows writes it or (as Blender's data sets do) without .png, or ""; raises
    ValueError for anything else."""
    if isinstance(path, str):
        path = path.replace("\\", "/")
    if not isinstance(path, str) or os.path.basename(os.path.normpath(path or "none")) in {"", ".", ".."}:
        raise ValueError(f"{path!r:.40} is not the path of a file")
    return f"{path}.png" if path and not os.path.splitext(path)[1] else path


def image_name(path: str) -> str:
    """The path of an image without extension, and without the way up from the file that lists it."""
    return os.path.splitext(_UP.sub("", os.path.normpath(path).replace(os.sep, "/")))[0]


_READERS: Mapping[str, Callable[[FileContent], Trajectory]] = {".log": _log, ".conf": _conf, ".json": _transforms}


def as_camera_to_world(pose: Matrix | None, maps: str, axes: str) -> Matrix | None:
    """A pose from the camera, with y down, to the world.

    Parameters
    ----------
    pose : ndarray or None
        (4, 4).
    maps, axes : str
        As `pose_maps` and `pose_axes` of `Layout`.
    """
    if pose is None:
        return None
    to_world = np.asarray(np.linalg.inv(pose), np.float64) if maps == "world-to-camera" else pose
    return to_world @ OPENGL_AXES if axes == "y-up" else to_world


# The poses of frames.


def motion_between(before: RGBDFrame, after: RGBDFrame) -> Matrix | None:
    """The transform of points [m] from the camera before to the camera after, (4, 4); None if a pose is not known."""
    return None if before.pose is None or after.pose is None else np.linalg.inv(after.pose) @ before.pose


def pose_in(path: Path, image: str) -> Matrix | None:
    """The camera pose of an image, without its suffix, in a text file with the poses of all frames; None if it has
    none at its time."""
    return pose_at_time(_of_all_frames(path, os.stat(path).st_mtime_ns).by_time, image)


def stated_pose(pose: str | tuple[float, ...]) -> Matrix | None:
    """The camera pose of a text file with the three or four rows of its matrix, or with its numbers in one line, or of
    16 numbers; None if they are no pose."""
    if not isinstance(pose, str):
        return checked_pose(np.reshape(pose, (4, 4)))
    found = _rows_or_none(Path(pose)).in_order
    return found[0] if len(found) == 1 else None


@lru_cache(maxsize=2)
def _of_all_frames(path: Path, changed: int) -> Trajectory:
    """The poses of a text file, cached by its modification time: it has a line for each frame."""
    return _rows_or_none(path)


def _rows_or_none(path: Path) -> Trajectory:
    """The poses of a text file; none if it contains anything else."""
    try:
        return _rows_of_text(read_file(path))
    except (InputError, ValueError):
        return Trajectory()
