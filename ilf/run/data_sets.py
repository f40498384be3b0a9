"""Export of results with known poses as data sets of other programs: nerfstudio, 3D Gaussian splatting, Open3D."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from .._runtime.formatting import counted
from .._runtime.writing import write_bytes
from ..data.camera import Camera
from ..data.points import in_world, point_cloud
from ..errors import ExportError, InputError, ParameterError, told_as
from ..io.depth import UINT16_MAX, write_depth
from ..io.images import encode_image
from ..sources.trajectories import OPENGL_AXES
from .stored_results import StoredResult, StoredResults
from .writing import Written

Pose = NDArray[np.float64]

_UNITS = 1000.0
"""Units per metre of depth images."""

_PIXEL_CENTRE = 0.5
"""Position of the first pixel's centre in nerfstudio and COLMAP; 0 here and in Open3D."""

_HALF_WEIGHT = 0.01
"""Expected error, as a share of the depth, that halves its weight."""


class _DataSet(ABC):
    """A data set of another program, written frame by frame into a new folder."""

    contents: ClassVar[str]
    """What it consists of, for the help."""

    def __init__(self, folder: Path, count: int) -> None:
        self._folder, self._count = folder, count
        self.files: list[Path] = []
        self.notes: list[str] = []

    @abstractmethod
    def add(self, result: StoredResult, camera: Camera, pose: Pose, number: int) -> None:
        """Write the images of a frame with its camera and pose; `number` is its place in the data set, from 1."""

    @abstractmethod
    def finish(self) -> None:
        """Write the files about all frames; the last one completes the data set."""

    def _write(self, name: str, content: bytes | str) -> None:
        self._new_file(name)
        write_bytes(self._folder / name, content.encode() if isinstance(content, str) else content)

    def _write_colour(self, name: str, colour: NDArray[np.uint8]) -> None:
        # the encoder expects BGR
        self._write(name, encode_image(Path(name).suffix, np.ascontiguousarray(colour[..., ::-1])))

    def _write_depth(self, name: str, result: StoredResult) -> None:
        self._new_file(name)
        written = write_depth(self._folder / name, result.depth, _UNITS)
        self.notes += [f"{result.name}: {note}" for note in written]

    def _new_file(self, name: str) -> None:
        path = self._folder / name
        with told_as(ExportError, f"Could not write into {path.parent}: {{error}}.", OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
        self.files.append(path)


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


def _weight(result: StoredResult) -> NDArray[np.float32] | None:
    """None where no expected errors were written."""
    if result.expected_error is None:
        return None
    return depth_weight(result.depth, result.expected_error, result.unsupported)


class _Nerfstudio(_DataSet):
    """`transforms.json` lists for each frame the colour, the completed depth (16-bit PNG in millimetres) and, if
    expected errors were written, `depth_weight_file_path`, an 8-bit PNG of `depth_weight` times 255 for custom loss
    functions. Colour has the recorded resolution: nerfstudio accepts depth of another size."""

    contents = "images, depths, depth_weights and transforms.json"

    def __init__(self, folder: Path, count: int) -> None:
        super().__init__(folder, count)
        self._frames: list[dict[str, Any]] = []

    def add(self, result: StoredResult, camera: Camera, pose: Pose, number: int) -> None:
        stem = f"{number:05}"
        colour, camera = result.recorded_colour(camera)
        names = {"file_path": f"images/{stem}.jpg", "depth_file_path": f"depths/{stem}.png"}
        self._write_colour(names["file_path"], colour)
        self._write_depth(names["depth_file_path"], result)
        if (weight := _weight(result)) is not None:
            names["depth_weight_file_path"] = f"depth_weights/{stem}.png"
            self._write(names["depth_weight_file_path"], encode_image(".png", np.rint(255 * weight).astype(np.uint8)))
        self._frames.append(
            {
                **names,
                "name": result.name,
                "transform_matrix": (pose @ OPENGL_AXES).tolist(),
                "fl_x": camera.fx,
                "fl_y": camera.fy,
                "cx": camera.cx + _PIXEL_CENTRE,
                "cy": camera.cy + _PIXEL_CENTRE,
                "w": colour.shape[1],
                "h": colour.shape[0],
                **dict.fromkeys(("k1", "k2", "p1", "p2"), 0.0),
            }
        )

    def finish(self) -> None:
        data = {"camera_model": "OPENCV", "depth_unit_scale_factor": 1 / _UNITS, "frames": self._frames}
        self._write("transforms.json", f"{json.dumps(data, indent=1)}\n")


class _GaussianSplatting(_DataSet):
    """The folder that the published trainer of 3D Gaussian splatting reads (`-s DIR -d depths`): colour, inverse depth,
    and a model of COLMAP with the poses, whose points are depth of the frames.

    A value of `depths` is 65536 * (1 / depth [m] - offset) / scale, by scale and offset in `depth_params.json`. Both
    are the same in all frames, because the trainer ignores frames whose scale differs much from the median."""

    contents = "images, inverse depth with depth_params.json, and a model of COLMAP, for 3D Gaussian splatting"

    _STEPS = 65536
    _SCALE = 10.0
    """Largest inverse depth [1/m]."""
    _POINTS = 100_000
    """Number of points of the model."""
    _MIN_WEIGHT = 0.5
    _MAX_OFF_CENTRE = 1.0
    """Largest distance [px] of the principal point from the image's centre without a note."""

    def __init__(self, folder: Path, count: int) -> None:
        super().__init__(folder, count)
        self._cameras: dict[tuple[float, ...], int] = {}
        self._images: list[str] = []
        self._points: list[str] = []
        self._parameters: dict[str, dict[str, float]] = {}
        self._missing = self._near = self._pixels = 0
        self._off_centre = 0.0

    def add(self, result: StoredResult, camera: Camera, pose: Pose, number: int) -> None:
        stem, depth_camera = f"{number:05}", camera
        colour, camera = result.recorded_colour(depth_camera)
        height, width = colour.shape[:2]
        self._write_colour(f"images/{stem}.jpg", colour)
        self._write(f"depths/{stem}.png", encode_image(".png", self._inverse(result.depth)))
        self._parameters[stem] = {"scale": self._SCALE, "offset": 0.0}
        centre = camera.cx + _PIXEL_CENTRE, camera.cy + _PIXEL_CENTRE
        self._off_centre = max(self._off_centre, abs(centre[0] - width / 2), abs(centre[1] - height / 2))
        known = self._cameras.setdefault((width, height, camera.fx, camera.fy, *centre), len(self._cameras) + 1)
        to_camera = np.linalg.inv(pose)
        x, y, z, w = Rotation.from_matrix(to_camera[:3, :3]).as_quat()
        # the second line lists the points that the image shows, here none
        self._images.append(f"{number} {_text((w, x, y, z, *to_camera[:3, 3]))} {known} {stem}.jpg\n\n")
        self._add_points(result, depth_camera, pose, number)

    def _inverse(self, depth: NDArray[np.float32]) -> NDArray[np.uint16]:
        """Values (H, W) of the image of inverse depth, 0 where it is missing; counts what cannot be expressed."""
        values = np.rint(self._STEPS / self._SCALE / depth.astype(np.float64))
        self._pixels += depth.size
        self._missing += int(np.count_nonzero(np.isnan(depth)))
        self._near += int(np.count_nonzero(values > UINT16_MAX))
        return np.nan_to_num(np.minimum(values, UINT16_MAX)).astype(np.uint16)

    def _add_points(self, result: StoredResult, camera: Camera, pose: Pose, number: int) -> None:
        """Choose pixels of reliable depth at random, the same ones in every export."""
        weight = _weight(result)
        reliable = np.isfinite(result.depth) if weight is None else weight >= self._MIN_WEIGHT
        places = np.flatnonzero(reliable)
        count = min(-(-self._POINTS // self._count), len(places))
        chosen = np.zeros(reliable.shape, bool)
        chosen.flat[np.random.default_rng(number).choice(places, count, replace=False)] = True
        cloud = in_world(point_cloud(result.depth, result.rgb, camera, only=chosen), pose)
        self._points += [
            f"{at} {x:.6f} {y:.6f} {z:.6f} {red} {green} {blue} 0\n"
            for at, ((x, y, z), (red, green, blue)) in enumerate(
                zip(cloud.points.tolist(), cloud.colours.tolist(), strict=True), len(self._points) + 1
            )
        ]

    def finish(self) -> None:
        model = "sparse/0"
        cameras = [
            f"{number} PINHOLE {width:.0f} {height:.0f} {_text(numbers)}\n"
            for (width, height, *numbers), number in self._cameras.items()
        ]
        for name, lines in (("cameras", cameras), ("images", self._images), ("points3D", self._points)):
            self._write(f"{model}/{name}.txt", "".join(lines))
        self._write(f"{model}/depth_params.json", f"{json.dumps(self._parameters, indent=1)}\n")
        if self._missing:
            self.notes.append(
                f"{self._missing / self._pixels:.1%} of the pixels have no depth: the published trainer takes them for "
                "infinitely far. Complete the frames with --extrapolate for depth everywhere."
            )
        if self._near:
            self.notes.append(f"Depth nearer than {1 / self._SCALE:g} m was clipped: {counted(self._near, 'pixel')}.")
        if self._off_centre > self._MAX_OFF_CENTRE:
            self.notes.append(
                f"The principal point lies {self._off_centre:.1f} px from the images' centre, where the published "
                "trainer takes it to be; others read it from cameras.txt."
            )


class _Open3D(_DataSet):
    """The folder that Open3D's reconstruction system reads: colour, depth (16-bit PNG in millimetres), one camera, and
    the poses."""

    contents = "color, depth, camera_intrinsic.json and trajectory.log"

    def __init__(self, folder: Path, count: int) -> None:
        super().__init__(folder, count)
        self._camera: dict[str, Any] = {}
        self._poses: list[str] = []

    def add(self, result: StoredResult, camera: Camera, pose: Pose, number: int) -> None:
        height, width = result.depth.shape
        columns = [camera.fx, 0, 0, 0, camera.fy, 0, camera.cx, camera.cy, 1]
        described = {"width": width, "height": height, "intrinsic_matrix": columns}
        if self._camera not in ({}, described):
            raise InputError(f"{result} has another camera than the results before it; Open3D has one for all.")
        self._camera = described
        self._write_colour(f"color/{number:05}.jpg", result.rgb)
        self._write_depth(f"depth/{number:05}.png", result)
        rows = "".join(f"{_text(row)}\n" for row in pose)
        self._poses.append(f"{number - 1} {number - 1} {number}\n{rows}")

    def finish(self) -> None:
        self._write("trajectory.log", "".join(self._poses))
        self._write("camera_intrinsic.json", f"{json.dumps(self._camera, indent=1)}\n")


def _text(numbers: Iterable[float]) -> str:
    """Numbers with all digits, separated by blanks."""
    return " ".join(repr(float(number)) for number in numbers)


DATA_SETS: dict[str, type[_DataSet]] = {"nerfstudio": _Nerfstudio, "3dgs": _GaussianSplatting, "open3d": _Open3D}
"""Name of a data set -> its writer."""


def write_data_set(
    folder: str | os.PathLike[str], results: Sequence[str | os.PathLike[str]], to: str = "nerfstudio"
) -> Written:
    """Write results as a data set of another program.

    Depth is 16-bit PNG in millimetres, inverse depth for 3D Gaussian splatting. Frames of phones have their colour at
    the recorded resolution if the recording is available, except for Open3D.

    Parameters
    ----------
    folder : path-like
        Created if missing; must be empty otherwise.
    results : sequence of path-like
        Folders with results, see `StoredResults`. Frames without a known pose are left out, with a note.
    to : str
        One of `DATA_SETS`: "nerfstudio", "3dgs" or "open3d".

    Returns
    -------
    Written

    Raises
    ------
    InputError
        If none of them has a pose, one has no camera or another camera than the data set allows, or one of them is not
        a result or incomplete.
    FormatError
        If one of them is damaged.
    ExportError
        If the folder is not empty, or cannot be written into.
    ParameterError
        For an unknown data set.
    """
    if to not in DATA_SETS:
        raise ParameterError(f"There is no data set {to!r:.40}. Known: {', '.join(DATA_SETS)}.")
    target = Path(folder).absolute()
    opened = [StoredResults(path) for path in results]
    if os.path.exists(target) and (not target.is_dir() or any(target.iterdir())):
        raise ExportError(f"{target} already exists and is not an empty folder. Choose another one.")
    total, number = sum(map(len, opened)), 0
    data_set, without_pose = DATA_SETS[to](target, total), []
    for result in (found[at] for found in opened for at in range(len(found))):
        if result.pose is None:
            without_pose.append(result.key)
            continue
        if result.intrinsics is None:
            raise InputError(f"{result}: the camera's intrinsics are not known, but needed. Give --intrinsics.")
        number += 1
        data_set.add(result, result.intrinsics, result.pose, number)
    if not number:
        raise InputError("None of the results has a pose. Use frames of a source with poses, or give it in meta.json.")
    data_set.finish()
    notes = data_set.notes
    if without_pose:
        named = f"{', '.join(without_pose[:3])!s:.200}"
        notes.insert(0, f"Left out, without a known pose: {counted(len(without_pose), 'result')} ({named}).")
    return Written(tuple(data_set.files), tuple(dict.fromkeys(notes)))
