"""Export of results with known poses as data sets of other programs: nerfstudio, 3D Gaussian splatting, Open3D."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from .._runtime.formatting import counted
from .._runtime.writing import write_bytes
from ..data.camera import Camera
from ..data.points import PointCloud, in_world, point_cloud
from ..errors import ExportError, InputError, ParameterError, told_as
from ..io.depth import write_depth
from ..io.encodings import UINT16_MAX
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


class _Folder:
    """A new folder, with what was written into it."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.files: list[Path] = []
        self.notes: list[str] = []

    def write(self, name: str, content: bytes | str) -> None:
        write_bytes(self._new_file(name), content.encode() if isinstance(content, str) else content)

    def write_json(self, name: str, data: object) -> None:
        self.write(name, f"{json.dumps(data, indent=1)}\n")

    def write_colour(self, name: str, colour: NDArray[np.uint8]) -> None:
        # the encoder expects BGR
        self.write(name, encode_image(Path(name).suffix, np.ascontiguousarray(colour[..., ::-1])))

    def write_depth(self, name: str, result: StoredResult) -> None:
        self.notes += [f"{result.name}: {note}" for note in write_depth(self._new_file(name), result.depth, _UNITS)]

    def _new_file(self, name: str) -> Path:
        path = self._path / name
        with told_as(ExportError, f"Could not write into {path.parent}: {{error}}.", OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
        self.files.append(path)
        return path


Placed = Iterator[tuple[StoredResult, Camera, Pose]]
"""Results with their cameras and poses, which are read one after the other."""


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


def _write_nerfstudio(out: _Folder, placed: Placed, total: int) -> None:
    """`transforms.json` lists for each frame the colour, the completed depth (16-bit PNG in millimetres) and, if
    expected errors were written, `depth_weight_file_path`, an 8-bit PNG of `depth_weight` times 255 for custom loss
    functions. Colour has the recorded resolution: nerfstudio accepts depth of another size."""
    frames: list[dict[str, Any]] = []
    for number, (result, depth_camera, pose) in enumerate(placed, 1):
        colour, camera = result.recorded_colour(depth_camera)
        names = {"file_path": f"images/{number:05}.jpg", "depth_file_path": f"depths/{number:05}.png"}
        out.write_colour(names["file_path"], colour)
        out.write_depth(names["depth_file_path"], result)
        if (weight := _weight(result)) is not None:
            names["depth_weight_file_path"] = f"depth_weights/{number:05}.png"
            out.write(names["depth_weight_file_path"], encode_image(".png", np.rint(255 * weight).astype(np.uint8)))
        frames.append(
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
    data = {"camera_model": "OPENCV", "depth_unit_scale_factor": 1 / _UNITS, "frames": frames}
    out.write_json("transforms.json", data)


_STEPS = 65536
_SCALE = 10.0
"""Largest inverse depth [1/m] of 3D Gaussian splatting."""
_POINTS = 100_000
"""Number of points of its model."""
_MIN_WEIGHT = 0.5
_MAX_OFF_CENTRE = 1.0
"""Largest distance [px] of the principal point from the image's centre without a note."""


def _write_gaussian_splatting(out: _Folder, placed: Placed, total: int) -> None:
    """The folder that the published trainer of 3D Gaussian splatting reads (`-s DIR -d depths`): colour, inverse depth,
    and a model of COLMAP with the poses, whose points are depth of the frames.

    A value of `depths` is 65536 * (1 / depth [m] - offset) / scale, by scale and offset in `depth_params.json`. Both
    are the same in all frames, because the trainer ignores frames whose scale differs much from the median."""
    cameras: dict[tuple[float, ...], int] = {}
    images, points, off_centre = list[str](), list[str](), 0.0
    pixels = missing = near = 0
    for number, (result, depth_camera, pose) in enumerate(placed, 1):
        colour, camera = result.recorded_colour(depth_camera)
        height, width = colour.shape[:2]
        inverse = np.rint(_STEPS / _SCALE / result.depth.astype(np.float64))
        pixels += inverse.size
        missing += int(np.count_nonzero(np.isnan(inverse)))
        near += int(np.count_nonzero(inverse > UINT16_MAX))
        values = np.nan_to_num(np.minimum(inverse, UINT16_MAX)).astype(np.uint16)
        out.write_colour(f"images/{number:05}.jpg", colour)
        out.write(f"depths/{number:05}.png", encode_image(".png", values))
        centre = camera.cx + _PIXEL_CENTRE, camera.cy + _PIXEL_CENTRE
        off_centre = max(off_centre, abs(centre[0] - width / 2), abs(centre[1] - height / 2))
        known = cameras.setdefault((width, height, camera.fx, camera.fy, *centre), len(cameras) + 1)
        to_camera = np.linalg.inv(pose)
        x, y, z, w = Rotation.from_matrix(to_camera[:3, :3]).as_quat()
        # the second line lists the points that the image shows, here none
        images.append(f"{number} {_text((w, x, y, z, *to_camera[:3, 3]))} {known} {number:05}.jpg\n\n")
        cloud = _reliable_points(result, depth_camera, pose, number, -(-_POINTS // total))
        points += [
            f"{at} {x:.6f} {y:.6f} {z:.6f} {red} {green} {blue} 0\n"
            for at, ((x, y, z), (red, green, blue)) in enumerate(
                zip(cloud.points.tolist(), cloud.colours.tolist(), strict=True), len(points) + 1
            )
        ]
    described = [
        f"{number} PINHOLE {width:.0f} {height:.0f} {_text(numbers)}\n"
        for (width, height, *numbers), number in cameras.items()
    ]
    for name, lines in (("cameras", described), ("images", images), ("points3D", points)):
        out.write(f"sparse/0/{name}.txt", "".join(lines))
    stems = (f"{number:05}" for number in range(1, len(images) + 1))
    out.write_json("sparse/0/depth_params.json", {stem: {"scale": _SCALE, "offset": 0.0} for stem in stems})
    if missing:
        out.notes.append(
            f"{missing / pixels:.1%} of the pixels have no depth: the published trainer takes them for infinitely far. "
            "Complete the frames with --extrapolate for depth everywhere."
        )
    if near:
        out.notes.append(f"Depth nearer than {1 / _SCALE:g} m was clipped: {counted(near, 'pixel')}.")
    if off_centre > _MAX_OFF_CENTRE:
        out.notes.append(
            f"The principal point lies {off_centre:.1f} px from the images' centre, where the published trainer takes "
            "it to be; others read it from cameras.txt."
        )


def _reliable_points(result: StoredResult, camera: Camera, pose: Pose, number: int, most: int) -> PointCloud:
    """Points of pixels with reliable depth, chosen at random, the same ones in every export; in world coordinates."""
    weight = _weight(result)
    reliable = np.isfinite(result.depth) if weight is None else weight >= _MIN_WEIGHT
    places = np.flatnonzero(reliable)
    chosen = np.zeros(reliable.shape, bool)
    chosen.flat[np.random.default_rng(number).choice(places, min(most, len(places)), replace=False)] = True
    return in_world(point_cloud(result.depth, result.rgb, camera, only=chosen), pose)


def _write_open3d(out: _Folder, placed: Placed, total: int) -> None:
    """The folder that Open3D's reconstruction system reads: colour, depth (16-bit PNG in millimetres), one camera, and
    the poses."""
    of_all: dict[str, Any] = {}
    poses: list[str] = []
    for number, (result, camera, pose) in enumerate(placed, 1):
        height, width = result.depth.shape
        columns = [camera.fx, 0, 0, 0, camera.fy, 0, camera.cx, camera.cy, 1]
        described = {"width": width, "height": height, "intrinsic_matrix": columns}
        if of_all not in ({}, described):
            raise InputError(f"{result} has another camera than the results before it; Open3D has one for all.")
        of_all = described
        out.write_colour(f"color/{number:05}.jpg", result.rgb)
        out.write_depth(f"depth/{number:05}.png", result)
        rows = "".join(f"{_text(row)}\n" for row in pose)
        poses.append(f"{number - 1} {number - 1} {number}\n{rows}")
    out.write("trajectory.log", "".join(poses))
    out.write_json("camera_intrinsic.json", of_all)


def _text(numbers: Iterable[float]) -> str:
    """Numbers with all digits, separated by blanks."""
    return " ".join(repr(float(number)) for number in numbers)


DATA_SETS: dict[str, tuple[Callable[[_Folder, Placed, int], None], str]] = {
    "nerfstudio": (_write_nerfstudio, "images, depths, depth_weights and transforms.json"),
    "3dgs": (
        _write_gaussian_splatting,
        "images, inverse depth with depth_params.json, and a model of COLMAP, for 3D Gaussian splatting",
    ),
    "open3d": (_write_open3d, "color, depth, camera_intrinsic.json and trajectory.log"),
}
"""Name of a data set -> what writes it from some of so many results, its last file at the end, and its contents."""


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
    out, without_pose = _Folder(target), list[str]()
    write, _ = DATA_SETS[to]
    write(out, _placed(opened, without_pose), sum(map(len, opened)))
    notes = out.notes
    if without_pose:
        named = f"{', '.join(without_pose[:3])!s:.200}"
        notes.insert(0, f"Left out, without a known pose: {counted(len(without_pose), 'result')} ({named}).")
    return Written(tuple(out.files), tuple(dict.fromkeys(notes)))


def _placed(opened: Sequence[StoredResults], without_pose: list[str]) -> Placed:
    """Yield the results that have a pose; the keys of the others are added to `without_pose`."""
    number = 0
    for result in (found[at] for found in opened for at in range(len(found))):
        if result.pose is None:
            without_pose.append(result.key)
            continue
        if result.intrinsics is None:
            raise InputError(f"{result}: the camera's intrinsics are not known, but needed. Give --intrinsics.")
        number += 1
        yield result, result.intrinsics, result.pose
    if not number:
        raise InputError("None of the results has a pose. Use frames of a source with poses, or give it in meta.json.")
