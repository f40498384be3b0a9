"""A reference to a frame: where its files are and how they are read, and whether this program has completed it.

The options of reading are declared once, for files, the command line, projects and the window.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import NoneType
from typing import Any, Self, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from .._runtime.files import absolute, is_address, read_json, split_dataset, with_dataset
from .._runtime.folders import folder_at
from .._runtime.schema import Section, converted, plain
from ..data.camera import INTRINSICS, Camera, checked_transform, is_preset
from ..data.frame import FrameInputs
from ..data.guide import Gives
from ..errors import InputError, ParameterError
from ..io.cameras import IntrinsicsSpec, is_numbers
from ..io.encodings import ENCODING_DESCRIPTIONS, EncodingSpec, checked_finite, single_encoding
from ..io.guide_models import is_guide_name
from .named_places import NotAllowed, named_in
from .naming import name_from_path, recorded_frame_name
from .pairing import MAX_TIME_GAP_S


@dataclass(frozen=True)
class ReadingOption:
    """Declaration of one option.

    Attributes
    ----------
    flag, metavar : str
        Its flag on the command line, "" for none; and the placeholder of its value, if it has one.
    help : str
        The flag's help of `ilf`.
    exclusive : bool
        Whether only one of the options marked so can be given.
    is_path : bool
        Whether it is the path of a file that belongs to the frame.
    one_frame : bool
        Whether it applies to a single frame only, not to all frames of a source.
    of_source : bool
        Whether it says how the frames of a source are found, not how each is read.
    """

    flag: str = ""
    metavar: str = "N"
    help: str = ""
    exclusive: bool = False
    is_path: bool = False
    one_frame: bool = False
    of_source: bool = False


COLOUR_VIEW, DEPTH_VIEW = VIEWS = "colour", "depth"
"""The camera whose pixels are those of a frame that is registered on reading."""

_CAMERAS = "intrinsics", "depth_intrinsics"

PoseSpec = str | tuple[float, ...]
"""A camera pose: the path of a text file with the rows of its matrix, or the 16 numbers of the matrix, row by row."""


def _option(**declared: Any) -> Any:
    """Return a field of `ReadingOptions`, which is not given by default, with its declaration as metadata."""
    return field(default=None, metadata={"option": declared})


@dataclass(frozen=True)
class ReadingOptions:
    """How the files of a frame are read, as in `ilf.load_frame`, and how the frames of a source are found, as in
    `ilf.open_source`; None: as stated beside the files, or the default."""

    encoding: EncodingSpec | None = _option(
        flag="--depth-encoding",
        metavar="NAME",
        help=f"encoding of the depth file: {', '.join(ENCODING_DESCRIPTIONS)}, bop:SCALE, or units per metre as a "
        "number (default: from meta.json; for two files, mm for integers and m for floats). An explicit encoding "
        "skips the plausibility check",
        exclusive=True,
    )
    depth_units: float | None = _option(
        help="units per metre of the depth file (1000: millimetres)",
        exclusive=True,
    )
    invalid: float | None = _option(
        help="value of missing depth in the depth file, besides 0: 65535 for 7-Scenes; 0 for none (default: from "
        "meta.json)",
    )
    dataset: str | None = _option(
        metavar="NAME",
        help="dataset of HDF5 and MATLAB 7.3 files that is the depth, where a file has several: /left/depth; for "
        "one file also FILE.h5:/left/depth",
    )
    min_confidence: float | None = _option(
        help="treat depth of a lower confidence as missing, where there is a confidence map: 2 for ARKit's high "
        "(default: from meta.json, otherwise all depth is used)",
    )
    intrinsics: IntrinsicsSpec | None = _option(
        metavar="CAMERA",
        help="camera preset, fx,fy,cx,cy[,width,height] or a file (JSON, YAML, OpenCV's, numbers as text or NPY; "
        f"FILE#NAME for one of its cameras), for point clouds and meshes. Presets: {', '.join(INTRINSICS)}",
    )
    depth_intrinsics: IntrinsicsSpec | None = _option(
        metavar="CAMERA",
        help="intrinsics of a depth image of another size than colour, or of the same size with --view: depth is "
        "registered to colour by both intrinsics, and by the transform between the cameras if their file states it "
        "(else as seen from the same place). In the same forms as --intrinsics",
    )
    undistort: bool | None = _option(
        help="correct the lens distortion of colour and depth, which the files of --intrinsics and "
        "--depth-intrinsics or the recording state; the camera of the results is that of the corrected images",
    )
    view: str | None = _option(
        metavar="CAMERA",
        help="the camera in whose pixels unregistered images are registered and completed: colour, or depth, into "
        "which colour is brought (black where colour sees nothing); the result is in that camera, and depth is "
        "aligned to colour afterwards (default: colour)",
    )
    ground_truth: str | None = _option(
        metavar="FILE",
        help="depth to evaluate the result against, in the format of the depth file; also FILE.h5:/NAME (default: "
        "gt.* in the frame's folder)",
        is_path=True,
        one_frame=True,
    )
    ground_truth_units: float | None = _option(
        help="units per metre of the ground truth (default: from meta.json, otherwise those of the depth file; 1 "
        "for floats)",
        one_frame=True,
    )
    guide: str | None = _option(
        metavar="FILE|NAME",
        help="depth or inverse depth of the frame from another source (monocular network, other sensor), in any "
        "unit: 8- or 16-bit PNG, TIFF, NPY or NPZ; 0 and NaN are ignored. Or a network that predicts it from "
        "colour: an ONNX file, or a name of `ilf models list` where there is no such file. It is used if hidden "
        "depth is better with it (default: guide.* in the frame's folder)",
        is_path=True,
        one_frame=True,
    )
    guide_gives: Gives | None = _option(
        metavar="KIND",
        help=f"what the values of a guide's file are, as which they are fitted: {', '.join(get_args(Gives))} "
        "(default: any that rise or fall with depth; a network with a name states it itself)",
    )
    confidence: str | None = _option(flag="", is_path=True, one_frame=True)
    pose: PoseSpec | None = _option(flag="", is_path=True, one_frame=True)
    max_gap: float | None = _option(
        metavar="S",
        help="largest time difference [s] between colour and depth of a frame that are paired by time (default: "
        f"{MAX_TIME_GAP_S:g})",
        of_source=True,
    )
    topics: tuple[str, str] | None = _option(
        metavar="COLOUR,DEPTH",
        help="image topics of ROS recordings with several cameras (default: aligned depth and its colour; `ilf "
        "info` lists them)",
        of_source=True,
    )
    layout: str | None = _option(
        metavar="LAYOUT",
        help="how the files of a folder are named and read: 'rgb=image/*.png depth=depth/*.png units=1000 "
        "K=K.txt', the name of a layout, or a TOML file (default: recognised; `ilf info --layouts` lists them)",
        of_source=True,
    )

    def __post_init__(self) -> None:
        for name in _CAMERAS:
            camera = getattr(self, name)
            if isinstance(camera, np.ndarray) and camera.shape == (3, 3):  # options can be compared
                object.__setattr__(self, name, tuple(camera.astype(float).ravel().tolist()))

    @property
    def given(self) -> dict[str, Any]:
        """The options that are given, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}

    @property
    def paths(self) -> dict[str, str]:
        """The files that are given, by the option's name; without the dataset of the ground truth."""
        paths = {name: value for name, value in self.given.items() if OPTIONS[name].is_path and isinstance(value, str)}
        if "guide" in paths and is_guide_name(paths["guide"]):
            del paths["guide"]
        return {name: split_dataset(path)[0] for name, path in paths.items()}

    @property
    def depth_encoding(self) -> EncodingSpec | None:
        """The encoding from `encoding` or `depth_units`; raises ParameterError as `single_encoding`."""
        return single_encoding(self.encoding, self.depth_units)

    @property
    def of_all_frames(self) -> Self:
        """Only the options for reading a frame that can apply to all frames of a source."""
        return replace(self.of_frame, **{name: None for name, option in OPTIONS.items() if option.one_frame})

    @property
    def of_frame(self) -> Self:
        """Only the options for reading a frame."""
        return replace(self, **{name: None for name, option in OPTIONS.items() if option.of_source})

    @property
    def time_gap(self) -> float:
        """Maximum time difference [s] of colour and depth of one frame, where they are matched by time."""
        return MAX_TIME_GAP_S if self.max_gap is None else self.max_gap

    def checked(self) -> Self:
        """The same options; raises ParameterError if both an encoding and units are given, the minimum confidence is
        not a number, the time gap is no duration, or there is no such encoding, view or kind of guide."""
        single_encoding(self.encoding, self.depth_units)
        for name, known in (("view", VIEWS), ("guide_gives", get_args(Gives))):
            if (value := getattr(self, name)) not in {None, *known}:
                raise ParameterError(f"The option {name} must be {' or '.join(known)}, not {value!r:.60}.")
        if not self.time_gap >= 0:
            raise ParameterError(f"The maximum time gap must be 0 s or more, not {self.max_gap!r:.60}.")
        if self.min_confidence is None:
            return self
        lowest = checked_finite(self.min_confidence, "The min. confidence", ", a value of the confidence map")
        return replace(self, min_confidence=lowest)

    def or_else(self, other: ReadingOptions) -> ReadingOptions:
        """These options, with those of another where none is given. An encoding and units replace each other; units of
        the ground truth belong to its file.

        Examples
        --------
        >>> ReadingOptions(encoding="tum").or_else(ReadingOptions(depth_units=1000.0, invalid=65535.0)).given
        {'encoding': 'tum', 'invalid': 65535.0}
        """
        rest = other.given
        if self.encoding is not None or self.depth_units is not None:
            rest = {name: value for name, value in rest.items() if not OPTIONS[name].exclusive}
        if self.ground_truth is not None:
            rest.pop("ground_truth_units", None)
        return ReadingOptions(**{**rest, **self.given})

    @property
    def camera_paths(self) -> dict[str, str]:
        """The files with intrinsics that are given, by the option's name."""
        return {
            name: os.fspath(value)
            for name in _CAMERAS
            if isinstance(value := getattr(self, name), str | os.PathLike)
            and not (is_preset(os.fspath(value)) or is_numbers(os.fspath(value)))
        }

    def with_paths(self, change: Callable[[str], str], *, cameras: bool = False) -> Self:
        """The same options with changed paths; with `cameras`, also those of files with intrinsics."""
        paths = self.paths | (self.camera_paths if cameras else {})
        changed: dict[str, Any] = {name: change(path) for name, path in paths.items()}
        if self.ground_truth is not None:
            changed["ground_truth"] = with_dataset(changed["ground_truth"], split_dataset(self.ground_truth)[1])
        return replace(self, **changed)

    @classmethod
    def from_arguments(cls, arguments: Mapping[str, Any]) -> Self:
        """The options among the arguments of a function or of the command line, by name; raises InputError for a pose
        that is no pose."""
        given = {name: arguments.get(name) for name in OPTIONS}
        for name, value in given.items():
            if value is not None and (OPTIONS[name].is_path or name == "layout"):
                given[name] = _pose_numbers(value) if name == "pose" else os.fspath(value)
        return cls(**given)

    def to_json(self) -> dict[str, Any]:
        """The given options for reading a frame as values for JSON, by name."""
        given = self.of_frame.given
        cameras = {name: _camera_to_json(given.pop(name)) for name in _CAMERAS if name in given}
        return {**plain(given), **cameras}

    @classmethod
    def from_json(cls, data: Section) -> Self:
        """The options in an object of a JSON file, which may contain other values; raises FormatError for a value of
        the wrong type."""
        stated = (name for name, option in OPTIONS.items() if name in data.values and not option.of_source)
        found = {name: data.get(name, *KINDS[name]) for name in stated}
        for name, value in found.items():
            if isinstance(value, list):
                found[name] = tuple(data.get(name, list[float]))
            elif isinstance(value, dict) and {*_CAMERA_FIELDS[:5]} <= value.keys() <= {*_CAMERA_FIELDS}:
                found[name] = converted(value, Camera, data.name, name)
        return cls(**found)


def _pose_numbers(pose: str | os.PathLike[str] | ArrayLike) -> PoseSpec:
    """A pose as the options hold it; raises InputError for a matrix that is no pose."""
    if isinstance(pose, str | os.PathLike):
        return os.fspath(pose)
    numbers = np.asarray(pose)
    matrix = numbers.reshape(4, 4) if numbers.shape == (16,) else numbers
    return tuple(checked_transform(matrix, "pose").ravel().tolist())


def _camera_to_json(given: IntrinsicsSpec) -> Any:
    """Intrinsics for JSON: text, a list of four or nine numbers, or an object."""
    if isinstance(given, Camera):
        return given.to_json()
    if isinstance(given, os.PathLike):
        return os.fspath(given)
    return plain(given if isinstance(given, str | Mapping) else np.asarray(given, float).ravel().tolist())


_CAMERA_FIELDS = tuple(one.name for one in fields(Camera))

AS_STATED = ReadingOptions()
"""No option is given."""

OPTIONS: Mapping[str, ReadingOption] = {
    one.name: ReadingOption(**{"flag": f"--{one.name.replace('_', '-')}", **one.metadata["option"]})
    for one in fields(ReadingOptions)
}
"""Name -> declaration."""

KINDS: Mapping[str, tuple[type, ...]] = {
    **{name: get_args(hint) for name, hint in get_type_hints(ReadingOptions).items()},
    **dict.fromkeys(_CAMERAS, (str, list, dict, NoneType)),
    "pose": (str, list, NoneType),
    "guide_gives": (str, NoneType),
}
"""Name -> types of its value in JSON."""


@dataclass(frozen=True)
class FrameRef:
    """Reference to a frame: a folder with meta.json, a colour file with its depth file, or a frame of a recording.
    `ilf.sources.reading.read_frame` reads it.

    `frame` is the key of a frame in a recording; `rgb` is then the recording, and `depth` is None. `stated_in` is the
    opened folder, or the address, of the file that states these paths, "" if it is not known, or None for paths of the
    user. What a file states is read only where `named_in` allows it. A dataset that is named behind the depth file, as
    FILE.h5:/depth, becomes the option.
    """

    rgb: str
    depth: str | None = None
    frame: str | None = None
    options: ReadingOptions = AS_STATED
    stated_in: str | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        depth, dataset = (None, None) if self.depth is None else split_dataset(self.depth)
        if dataset is not None:
            object.__setattr__(self, "depth", depth)
            object.__setattr__(self, "options", replace(self.options, dataset=dataset))

    @classmethod
    def of(cls, inputs: FrameInputs) -> Self:
        """The reference to a frame with these inputs, without its guide and its invalid mask."""
        return cls.from_json(Section("frame", {"frame": None, **inputs.arguments}))

    @classmethod
    def from_json(cls, data: Section, stated_in: str | None = None) -> Self:
        """The reference in an object of a JSON file; raises FormatError for missing or wrong values."""
        depth, frame = (data.get(key, str, NoneType) for key in ("depth", "frame"))
        return cls(data.get("rgb", str), depth, frame, ReadingOptions.from_json(data), stated_in)

    def to_json(self) -> dict[str, Any]:
        """The reference as an object for JSON: the location and the given options."""
        return {"rgb": self.rgb, "depth": self.depth, "frame": self.frame, **self.options.to_json()}

    @property
    def key(self) -> str:
        """Unique key: the path of the file or folder with the depth, followed by the dataset, or by the frame's key in
        a recording."""
        path = with_dataset(absolute(self.depth or self.rgb), self.options.dataset)
        return path if self.frame is None else f"{path}#{self.frame}"

    @property
    def name(self) -> str:
        """Name of the frame before it has been read."""
        path = Path(absolute(self.rgb))
        if self.frame is not None:
            return recorded_frame_name(path, self.frame)
        return path.name if self.depth is None else name_from_path(path)

    @property
    def paths(self) -> tuple[str, ...]:
        """All given paths: of the colour file, folder or recording, the depth file and the files of the options."""
        return self.rgb, *(() if self.depth is None else (self.depth,)), *self.options.paths.values()

    def with_paths(self, change: Callable[[str], str], *, cameras: bool = False) -> Self:
        """A copy with changed paths; with `cameras`, also those of files with intrinsics."""
        rgb, depth = change(self.rgb), None if self.depth is None else change(self.depth)
        return replace(self, rgb=rgb, depth=depth, options=self.options.with_paths(change, cameras=cameras))

    def with_options(self, **changes: Any) -> Self:
        """A copy with changed reading options."""
        return replace(self, options=replace(self.options, **changes))

    def absolute(self) -> Self:
        """A copy with absolute paths; itself if all paths are absolute."""
        return self if all(map(os.path.isabs, self.paths)) else self.with_paths(absolute)

    def allowed(self) -> Self:
        """The reference with paths that may be opened; raises as `named_in`."""
        if self.stated_in is None:
            return self
        base, refused = self.stated_in, list[str]()

        def checked(path: str) -> str:
            try:
                return named_in(path, base)
            except NotAllowed as error:
                refused.extend(error.places)
                return path

        found = replace(self.with_paths(checked, cameras=True), stated_in=None)
        if refused:
            raise NotAllowed(*refused)
        return found


# Results of this program, whose depth was completed, beside measured frames.

RECORD_FILE = "run.json"
"""File of the record of a run, beside its results."""

SHARDS_FILE = "shards.json"
"""File of a folder of shards that states what they contain."""

COMPLETED_DEPTH = (
    "the depth was completed by ILF Studio, so that filled depth counts as measured. Give the frame that was completed."
)


def is_shards(path: str | os.PathLike[str]) -> bool:
    """Whether a folder or an address contains shards, finished or not."""
    return folder_at(path).exists(SHARDS_FILE)


def is_result_folder(ref: FrameRef) -> bool:
    """Whether a frame is a folder with the result and the record of a run."""
    return ref.depth is None and ref.frame is None and is_result(ref)


def is_result(ref: FrameRef) -> bool:
    """Whether the depth of a frame was completed by this program, so that not all of it was measured. False at
    addresses."""
    if ref.frame is not None:
        return not is_address(ref.rgb) and is_shards(ref.rgb)
    record = os.path.join(ref.rgb if ref.depth is None else os.path.dirname(ref.depth), RECORD_FILE)
    if is_address(record) or not os.path.isfile(record):
        return False
    if ref.depth is None:
        return True
    try:
        data = read_json(record)
    except InputError:
        return False
    outputs = data.get("outputs") if isinstance(data, dict) else None
    return isinstance(outputs, dict) and os.path.basename(ref.depth) in outputs
