"""The files of a frame on this machine, and what a meta.json beside them states; and writing both."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_json, split_dataset, with_dataset
from .._runtime.schema import converted
from .._runtime.writing import write_bytes
from ..data.camera import as_camera, checked_transform
from ..data.frame import RGBDFrame
from ..errors import ExportError, FormatError, InputError, ParameterError, one_line, told_as
from ..io.depth import write_depth
from ..io.encodings import EncodingSpec, single_encoding
from ..io.frame_additions import CONFIDENCE_SUFFIXES, GUIDE_SUFFIXES, is_ground_truth
from ..io.images import encode_image
from .frame_ref import AS_STATED, ReadingOptions
from .named_places import NotAllowed, first_allowed, named_in
from .naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, META_NAME, name_from_path, no_frame_folder
from .trajectories import pose_in, stated_pose

_DEPTH_WORD = re.compile(r"(?<![a-z])depth(?![a-z])", re.IGNORECASE)
_DEPTH_ENDING = re.compile(r"[-_.]?depth$", re.IGNORECASE)
_POSE_FOLDERS, _TRAJECTORY = ("pose", "poses"), "groundtruth.txt"
_IMAGES = ("rgb", COLOUR_SUFFIXES), ("depth", DEPTH_FILE_SUFFIXES)
"""Names of colour and depth in a folder that does not state others, with their suffixes."""


@dataclass(frozen=True)
class FrameFiles:
    """The files of a frame, and what meta.json states about them.

    Attributes
    ----------
    rgb, depth : Path
        Absolute paths.
    name : str
    options : ReadingOptions
        As stated, with the ground truth, guide and confidence map that lie beside the images.
    size : (int, int) or None
        Width and height of both images, if stated.
    outside_view : Path or None
        Mask of what the depth camera could not see, if stated.
    has_meta : bool
        Whether a meta.json was read.
    """

    rgb: Path
    depth: Path
    name: str
    options: ReadingOptions = AS_STATED
    size: tuple[int, int] | None = None
    outside_view: Path | None = None
    has_meta: bool = False


def two_files(rgb: str | os.PathLike[str], depth: str | os.PathLike[str], *, beside: bool = True) -> FrameFiles:
    """Two files of a frame; with `beside`, also what a meta.json, or else a confidence map, beside them states."""
    if beside and (files := meta_beside(rgb, depth)) is not None:
        return files
    rgb, depth = Path(rgb).absolute(), Path(depth).absolute()
    confidence = _confidence_beside(depth) if beside else None
    return FrameFiles(rgb, depth, name_from_path(rgb), ReadingOptions(confidence=confidence))


def is_frame_folder(folder: str | os.PathLike[str]) -> bool:
    """Whether a folder is a single frame: it has meta.json, or colour rgb.* and depth depth.*."""
    root = Path(folder)
    return os.path.isfile(root / META_NAME) or all(image_at(root, *image) for image in _IMAGES)


def frame_folder(folder: str | os.PathLike[str]) -> FrameFiles:
    """Read the meta.json of a frame folder, without the images.

    Parameters
    ----------
    folder : path-like
        Contains colour `rgb.*` and depth `depth.*`, or meta.json with the optional keys `name`, `size` [width, height],
        `depth_units_per_m` or
        `depth_encoding` (see `load_frame`), `depth_invalid` (the depth file's value for missing depth), `K` [fx, fy,
        cx, cy], `rgb` and `depth` (paths of the images, a dataset of HDF5 as FILE.h5:/NAME; default: `rgb.*` and
        `depth.*` in the folder), `gt` (path of
        the ground truth; default: `gt.*` in the folder; or a description of it, by which `gt.*` is ignored if it was
        filled in or the description is empty), `gt_units_per_m`, `guide` (path of a guide; default: `guide.*` in the
        folder), `confidence` (path of a confidence map; default: `confidence.*` in the folder), `min_confidence` (below
        which depth counts as missing), `pose` (the camera's pose, see `RGBDFrame`), `outside_view` (path of the mask of
        what the depth camera could not see), and `run` (path of the run record; without that file the folder is an
        incomplete export).

    Raises
    ------
    InputError
        If meta.json or one of the images is missing.
    FormatError
        If meta.json is not JSON or has values of the wrong kind.
    """
    root = Path(folder).absolute()
    path = root / META_NAME
    if not is_frame_folder(root):
        raise no_frame_folder(root)
    has_meta = os.path.isfile(path)
    meta = read_json(path) if has_meta else {}
    if not isinstance(meta, dict):
        raise FormatError(f"{path} must hold a JSON object with depth_units_per_m.")
    with told_as(FormatError, f"{path}: {{error}}", (InputError, ParameterError)):
        stated = converted({**meta, "name": meta.get("name") or one_line(root.name)}, Meta, META_NAME)
        options = stated.options
        if stated.name != one_line(stated.name):
            raise InputError(f"name must be one line of text, not {stated.name!r:.60}.")
    if stated.run and not os.path.isfile(named_in(stated.run, root)):
        raise InputError(f"{root} contains an interrupted export: its {stated.run} is missing. Export again.")
    for stem, suffixes in () if has_meta else _IMAGES:
        names = [stem + suffix for suffix in suffixes if os.path.isfile(root / (stem + suffix))]
        if len(names) > 1:
            raise InputError(f"{root} has {' and '.join(names)}: give the colour and the depth file that are meant.")
    rgb = _named_image(root, stated.rgb, stated.run) or _image_in(root, "rgb", COLOUR_SUFFIXES)
    named_depth, dataset = split_dataset(stated.depth or "")
    hint = f" To use gt.png as depth, give {rgb.name} and it, with depth units {stated.gt_units_per_m}."
    hint = hint if os.path.isfile(root / "gt.png") else ""
    depth = _named_image(root, named_depth) or _image_in(root, "depth", DEPTH_FILE_SUFFIXES, hint)
    description, truth_dataset = (None, None) if stated.gt is None else split_dataset(stated.gt)
    truth = _ground_truth_in(root, description)
    options = replace(
        options,
        dataset=dataset,
        ground_truth=None if truth is None else with_dataset(truth, truth_dataset),
        guide=_beside(root, stated.guide, "guide", GUIDE_SUFFIXES),
        confidence=_beside(root, stated.confidence, "confidence", CONFIDENCE_SUFFIXES),
    )
    size, outside_view = stated.size, _named_image(root, stated.outside_view)
    return FrameFiles(rgb, depth, stated.name, options, size, outside_view, has_meta)


class StatedDepth(msgspec.Struct, kw_only=True):
    """How depth is stored, by a file of JSON beside it."""

    depth_units_per_m: Annotated[float, msgspec.Meta(gt=0)] | None = None
    depth_encoding: str | float | None = None
    depth_invalid: float | None = None

    @property
    def encoding(self) -> EncodingSpec | None:
        """The encoding; raises ParameterError if it is none, or is stated twice."""
        return single_encoding(self.depth_encoding, self.depth_units_per_m)


class Meta(StatedDepth, kw_only=True):
    """What meta.json states, see `frame_folder`."""

    name: str
    rgb: str | None = None
    depth: str | None = None
    gt: str | None = None
    guide: str | None = None
    confidence: str | None = None
    outside_view: str | None = None
    run: str | None = None
    size: tuple[int, int] | None = None
    gt_units_per_m: Annotated[float, msgspec.Meta(gt=0)] | None = None
    min_confidence: float | None = None
    K: Any = None
    pose: Any = None

    @property
    def options(self) -> ReadingOptions:
        """The reading options but for files; raises InputError or ParameterError for wrong values."""
        encoding, units = self.encoding, self.depth_units_per_m
        return ReadingOptions(
            encoding=encoding if units is None else None,
            depth_units=units,
            invalid=self.depth_invalid,
            min_confidence=self.min_confidence,
            intrinsics=None if self.K is None else as_camera({"K": self.K}, None),
            ground_truth_units=self.gt_units_per_m,
            pose=None if self.pose is None else tuple(checked_transform(self.pose, "pose").ravel().tolist()),
        )


def meta_beside(rgb: str | os.PathLike[str], depth: str | os.PathLike[str]) -> FrameFiles | None:
    """Read the meta.json in the folder of two files: units, intrinsics and name, as for the folder.

    Returns
    -------
    FrameFiles or None
        None if there is none, if it cannot be read, or if it lists other files: two files can be read without it. Its
        `size` is not checked.
    """
    colour_path, depth_path = Path(rgb).absolute(), Path(depth).absolute()
    try:
        files = frame_folder(colour_path.parent)
    except NotAllowed:
        raise
    except InputError:
        return None
    is_theirs = files.has_meta and _is_same(files.rgb, colour_path) and _is_same(files.depth, depth_path)
    return replace(files, rgb=colour_path, depth=depth_path, size=None) if is_theirs else None


def _is_same(file: Path, other: Path) -> bool:
    return file == other or (os.path.exists(other) and file.samefile(other))


def _confidence_beside(depth: Path) -> str | None:
    """The confidence map whose name has "confidence" where that of the depth file or of its folder has "depth"."""
    stem, folder = (_DEPTH_WORD.sub("confidence", name) for name in (depth.stem, depth.parent.name))
    beside = depth.parent if folder == depth.parent.name else depth.parent.with_name(folder)
    places = ((depth.parent, stem), (beside, depth.stem), (beside, stem))
    found = (image_at(root, name, CONFIDENCE_SUFFIXES) for root, name in places if root / name != depth.with_suffix(""))
    return next((str(path) for path in found if path is not None), None)


def pose_files(depth: str | Path) -> tuple[Path, ...]:
    """The files beside a depth file that may contain the pose of its frame; the last one, those of all frames."""
    path = Path(depth)
    name = _DEPTH_ENDING.sub("", path.stem)
    return (
        path.with_name(f"{name}.pose.txt".lstrip(".")),
        *(path.parent.parent / folder / f"{name}.txt" for folder in _POSE_FOLDERS),
        path.parent.parent / _TRAJECTORY,
    )


def camera_pose(depth: str | Path) -> NDArray[np.float64] | None:
    """The camera pose of a frame: the transform of its points [m] to the world.

    Parameters
    ----------
    depth : path
        The frame's depth file. Its pose is searched in the layouts of the TUM benchmark (`groundtruth.txt` in the
        parent folder, by the time in the file's name), 7-Scenes (`NAME.pose.txt` beside it, or `pose.txt`), and ScanNet
        (`pose/NAME.txt` beside its folder).

    Returns
    -------
    ndarray of float64, shape (4, 4), or None
        x to the right, y down, z forward. None if there is no such file, or it does not contain the pose.
    """
    place = next(filter(os.path.isfile, pose_files(depth)), None)
    if place is None:
        return None
    return pose_in(place, Path(depth).stem) if place.name == _TRAJECTORY else stated_pose(str(place))


def _ground_truth_in(root: Path, description: str | None) -> Path | None:
    """The ground truth file of a frame folder: as listed in meta.json, or `gt.*`; None if there is none."""
    if description and Path(description).suffix.lower() in DEPTH_FILE_SUFFIXES and not re.search(r"\s", description):
        return _named_image(root, description)
    return image_at(root, "gt", DEPTH_FILE_SUFFIXES) if is_ground_truth(description) else None


def _beside(root: Path, named: str | None, stem: str, suffixes: tuple[str, ...]) -> str | None:
    """A further file of a frame folder: as listed in meta.json, or by its usual name; None if there is none."""
    found = _named_image(root, named) or image_at(root, stem, suffixes)
    return None if found is None else str(found)


def _named_image(root: Path, named: str | None, run: str | None = None) -> Path | None:
    """An image listed in meta.json: at its path, or in the folder under its file name; None if none is listed. If it is
    the colour of a run, the run's record states its hash."""
    if not named:
        return None
    plain = named.replace("\\", "/")
    sha256 = _recorded_colour_sha256(root / run) if run and os.path.dirname(plain) else ""
    if path := first_allowed((named, plain, plain.rpartition("/")[2]), root, sha256=sha256):
        return Path(path)
    raise InputError(f"{root / META_NAME} lists {named}, which is missing. Put it beside {META_NAME}, or correct it.")


def _recorded_colour_sha256(record: Path) -> str:
    """The hash of the colour file in a run record; "" if there is none."""
    try:
        return str(read_json(record)["inputs"]["rgb"]["sha256"])
    except (InputError, KeyError, TypeError):
        return ""


def _image_in(root: Path, stem: str, suffixes: tuple[str, ...], hint: str = "") -> Path:
    if path := image_at(root, stem, suffixes):
        return path
    others = ", ".join(sorted(entry.name for entry in root.iterdir() if entry.name != META_NAME)) or "nothing else"
    what = "raw depth" if stem == "depth" else "colour image"
    raise InputError(f"{root} has no {what} ({stem}{suffixes[0]}); it contains {others}.{hint}")


def image_at(root: Path, stem: str, suffixes: tuple[str, ...]) -> Path | None:
    """The file of this name with the first of the suffixes that there is; None if there is none."""
    paths = (root / (stem + suffix) for suffix in suffixes)
    return next((path for path in paths if os.path.isfile(path) or os.path.islink(path)), None)  # a broken link is told


# Writing a frame to a frame folder that `ilf.load_frame` reads.

_COLOUR, _DEPTH = "rgb.png", "depth.tiff"


def new_frame_files(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The files that `write_frame` writes: colour, depth and meta.json; raises ExportError if one exists."""
    paths = tuple(Path(folder) / name for name in (_COLOUR, _DEPTH, META_NAME))
    for path in paths:
        if path.exists():
            raise ExportError(f"{path} already exists. Choose another folder.")
    return paths


def write_frame(folder: str | os.PathLike[str], frame: RGBDFrame) -> tuple[Path, ...]:
    """Write a frame to a separate folder: rgb.png, depth.tiff (float32 [m], NaN = missing) and meta.json.

    Parameters
    ----------
    folder : path-like
        Created if missing; it must not contain a frame.
    frame : RGBDFrame
        Its measured depth is written, including invalid depth.

    Returns
    -------
    tuple of Path
        The files.

    Raises
    ------
    ExportError
        If the folder already contains a frame, or a file cannot be written.
    """
    root, camera = Path(folder), frame.intrinsics
    meta = {
        "name": frame.name,
        "size": [frame.shape[1], frame.shape[0]],
        "depth_units_per_m": 1.0,
        "K": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
    }
    if frame.pose is not None:
        meta["pose"] = frame.pose.tolist()
    paths = new_frame_files(root)
    with told_as(ExportError, f"{root} cannot be created ({{error}}). Choose another folder.", OSError):
        root.mkdir(parents=True, exist_ok=True)
    write_bytes(paths[0], encode_image(".png", frame.rgb[..., ::-1]))
    write_depth(paths[1], frame.measured)
    write_bytes(paths[2], f"{json.dumps(meta, indent=2)}\n".encode())
    return paths
