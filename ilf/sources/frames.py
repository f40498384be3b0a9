"""Reading and writing RGB-D frames: colour and depth files, or a folder with both."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.addresses import is_address
from .._runtime.files import FileContent, read_file, read_json, write_bytes
from .._runtime.named_places import NotAllowed, first_allowed, named_in, note_opened
from ..data.camera import CAMERA_DOUBT, Camera, as_camera, camera_doubt, checked_transform
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..errors import (
    ExportError,
    FormatError,
    InputError,
    ParameterError,
    PathKind,
    cause,
    check_kind,
    one_line,
    warn_of_reading,
)
from ..io.cameras import IntrinsicsSpec, frame_camera
from ..io.depth import DEPTH_READERS, checked_units, write_depth
from ..io.depth_reading import DepthReading, read_depth
from ..io.encodings import EncodingSpec, checked_invalid, encoding_of, needs_scene, single_encoding
from ..io.frame_additions import (
    CONFIDENCE_SUFFIXES,
    GUIDE_SUFFIXES,
    NO_CONFIDENCE_MAP,
    UNUSED_CONFIDENCE,
    checked_min_confidence,
    confidence_doubt,
    is_ground_truth,
    load_guide,
    low_confidence,
    read_confidence,
    with_ground_truth_file,
)
from ..io.images import encode_image, read_colour_with_warning, turned
from ..io.kinds import kind_at
from ..io.labels import read_mask
from ..io.orientation import AS_STORED, PairOrientation, companion_doubts, orientation_tag, pair_orientation
from .naming import name_from_path
from .opening import is_recording
from .own_results import is_result
from .poses import camera_pose, stated_pose
from .reading_options import AS_STATED, ReadingOptions, path_text
from .recorded import read_recorded
from .registration import RawPair, register
from .remote import copied_frame, restored, with_addresses

META_NAME = "meta.json"
COMPLETED_DEPTH = (
    "the depth was completed by ILF Studio, so that filled depth counts as measured. Give the frame that was completed."
)
_DEPTH_WORD = re.compile(r"(?<![a-z])depth(?![a-z])", re.IGNORECASE)
COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")
USUAL_DEPTH_SUFFIXES = (".png", ".tif", ".tiff", ".pgm", ".npy")
DEPTH_FILE_SUFFIXES = tuple(dict.fromkeys((*USUAL_DEPTH_SUFFIXES, *DEPTH_READERS)))


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
    pose : tuple of tuple of float, or None
        The camera's pose as rows of a matrix, if stated.
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
    pose: tuple[tuple[float, ...], ...] | None = None
    outside_view: Path | None = None
    has_meta: bool = False

    @property
    def camera_pose(self) -> NDArray[np.float64] | None:
        """The camera's pose, (4, 4): as stated, or else from files beside the depth; None if not known."""
        if self.options.pose is not None:
            return stated_pose(self.options.pose)
        return camera_pose(self.depth) if self.pose is None else np.array(self.pose)


def load_frame(
    rgb: str | os.PathLike[str],
    depth: str | os.PathLike[str] | None = None,
    *,
    depth_units: float | None = None,
    encoding: EncodingSpec | None = None,
    invalid: float | None = None,
    intrinsics: IntrinsicsSpec | None = None,
    depth_intrinsics: IntrinsicsSpec | None = None,
    name: str | None = None,
    ground_truth: str | os.PathLike[str] | None = None,
    ground_truth_units: float | None = None,
    guide: str | os.PathLike[str] | None = None,
    confidence: str | os.PathLike[str] | None = None,
    min_confidence: float | None = None,
    pose: str | os.PathLike[str] | ArrayLike | None = None,
    frame: str | None = None,
    beside: bool = True,
    warn: bool = True,
) -> RGBDFrame:
    """Read an RGB-D frame from registered images or from a recording. Unregistered depth of a recording is registered.

    Paths may be addresses (s3://, gs://, https://, hf://), whose files are copied to a temporary folder first.

    Parameters
    ----------
    rgb : path-like
        Colour PNG, JPEG or TIFF, or the depth file if it contains colour (.pcd, .heic); or, without `depth`, a folder
        with a colour image `rgb.*` and depth `depth.*`, as meta.json describes them if it has one; or, with `frame`, a
        recording.
    depth : path-like, optional
        Depth in any format of `ilf.io.read_depth_values`: 16-bit PNG, TIFF, PGM, NPY, EXR and others.
    depth_units : float, optional
        File units per metre: the encoding of most files.
    encoding : str or float, optional
        Conversion of the depth file's values to metres: a name of `ilf.io.ENCODINGS` ("mm", "tum", "sun", "nyu-raw",
        ...), "bop", "bop:SCALE", "disparity:FB", or file units per metre. It replaces `depth_units`. Without both, the
        value in meta.json is used, also for two files that lie beside it (see `meta_beside`); without that, 1000 units
        per metre for integers and 1 for floats. An explicit encoding skips the plausibility check.
    invalid : float, optional
        The file's value for missing depth, besides zero, negative and not finite ones; 0 means that there is none. None
        uses the value in meta.json.
    intrinsics : optional
        Anything that `ilf.io.intrinsics_from` accepts; it overrides meta.json.
    depth_intrinsics : optional
        The same for a depth file of another size than colour: its depth is registered to colour by both intrinsics, as
        seen from the same place (see `ilf.registration`). Where both images have the same size, they are the
        intrinsics of both.
    name : str, optional
        Name of the frame; None takes it from meta.json or the file names.
    ground_truth : path-like, optional
        Ground truth for evaluating results, in a file like the depth file. None uses that of the folder, if any.
    ground_truth_units : float, optional
        Its file units per metre. None uses the value in meta.json; otherwise those of the depth file if both contain
        integers, 1 if it contains floats.
    guide : path-like, optional
        Depth from another origin, or a network that predicts it, see `ilf.load_guide`. None uses that of the folder, if
        any.
    confidence : path-like, optional
        The sensor's confidence of its depth, see `ilf.io.read_confidence`. None uses that of the folder, if any: also
        without meta.json, a file whose name has "confidence" where that of the depth file or its folder has "depth".
    min_confidence : float, optional
        Depth of a lower confidence counts as missing: it goes into the frame's invalid mask. None uses the value in
        meta.json; without that, all depth counts. Without a confidence map it has no effect, which a note reports.
    pose : path-like or array_like, optional
        The camera's pose, see `RGBDFrame`: a matrix (4, 4), or a text file with its rows. None uses that of the folder
        or of a file beside the depth, if any.
    frame : str, optional
        The key of a frame of a recording, see `ilf.open_source`.
    beside : bool
        Whether a meta.json, or a confidence map, beside two files is used.
    warn : bool
        Whether plausibility warnings and notes on what was left out are also issued as `DepthWarning`, not only stored
        in the frame's `notes`.

    Returns
    -------
    RGBDFrame
        Its `inputs` contain the absolute paths of the files, the SHA-256 of the bytes that were read, the depth units
        and the intrinsics; its `sources` contain what is needed to read the same frame again.

    Raises
    ------
    InputError
        If a file is missing, the sizes differ, no depth is known or none has enough confidence, the depth scale is
        absurd, or the scale of the ground truth does not fit it.
    FormatError
        If a file is damaged or has the wrong kind of content.
    ParameterError
        If depth or ground truth units are not a positive number, there is no such encoding, both units and an encoding
        are given, ground truth units are given without ground truth, or the minimum confidence is not a number.
    ExportError
        If files at addresses cannot be copied to this machine.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> frame = load_frame(asset_path("samples/room"))
    >>> frame.name, frame.shape, round(frame.missing_share, 3), frame.ground_truth is None
    ('room', (480, 640), 0.173, False)
    """
    for path in (rgb, rgb if depth is None else depth):
        check_kind(path, PathKind, "A frame is read from files", "make one from arrays by ilf.RGBDFrame(rgb, depth).")
    options = ReadingOptions(
        encoding=encoding,
        depth_units=depth_units,
        invalid=invalid,
        min_confidence=min_confidence,
        intrinsics=intrinsics,
        ground_truth=path_text(ground_truth),
        ground_truth_units=ground_truth_units,
        guide=path_text(guide),
        confidence=path_text(confidence),
        depth_intrinsics=depth_intrinsics,
        pose=_pose_spec(pose),
    )
    if frame is not None and depth is not None:
        raise ParameterError("A recording contains the depth of its frames: leave the depth file out.")
    report = warn_of_reading if warn else lambda text: None
    paths = os.fspath(rgb), path_text(depth)
    given = *paths, *options.paths.values(), *options.camera_paths.values()
    if not any(map(is_address, filter(None, given))):
        loaded = _load(*paths, options, name, frame, beside, report)
    else:
        with copied_frame(*paths, options, is_recorded=frame is not None) as copies:
            loaded = with_addresses(_load(*copies, name, frame, beside, lambda text: report(restored(text))))
    note_opened(*given, *loaded.files)
    return loaded


def _load(
    rgb: str,
    depth: str | None,
    options: ReadingOptions,
    name: str | None,
    frame: str | None,
    beside: bool,
    report: Callable[[str], None],
) -> RGBDFrame:
    """Read a frame as `load_frame`, and report plausibility warnings and what was left out."""
    given, sensor_confidence = options.depth_encoding, None
    if frame is not None:
        recorded = read_recorded(rgb, frame, given, options.invalid)
        camera, notes = frame_camera(options.intrinsics, recorded.shape)
        if camera is None and notes:
            raise InputError(notes[0])
        loaded = recorded.frame(camera, name)
        loaded, reported = replace(loaded, notes=(*loaded.notes, *notes)), recorded.reading.warnings
        stated, sensor_confidence = AS_STATED, recorded.stored.confidence
    else:
        files = files_of(rgb, depth, beside)
        stated = files.options
        if depth is None and files.has_meta and stated.depth_encoding is None and given is None:
            raise FormatError(
                f"{Path(rgb) / META_NAME} has no depth_units_per_m and no depth_encoding: add the file units per metre "
                "(1000 for millimetres) or the encoding's name, or give depth units."
            )
        loaded, reported = _from_files(files, options, name)
    if is_result(rgb, depth, frame):
        loaded = replace(loaded, notes=(*loaded.notes, f"{depth or rgb}: {COMPLETED_DEPTH}"))
    for text in (*reported, *(one for one in loaded.notes if one.startswith(CAMERA_DOUBT))):
        report(text)
    chosen = options.checked().or_else(stated)
    if frame is not None and chosen.pose is not None:
        loaded = replace(loaded, pose=stated_pose(chosen.pose))
    confidence_map = sensor_confidence if chosen.confidence is None else chosen.confidence
    loaded = _with_min_confidence(loaded, confidence_map, chosen.min_confidence, report)
    if chosen.guide is not None:
        loaded = loaded.with_guide(load_guide(chosen.guide, loaded.shape, loaded.rgb))
    if chosen.ground_truth is None:
        if options.ground_truth_units is not None:
            raise ParameterError("Ground truth units are given without ground truth: give its file, too.")
        return loaded
    known = len(loaded.notes)
    loaded = with_ground_truth_file(loaded, chosen.ground_truth, chosen.ground_truth_units)
    for text in loaded.notes[known:]:
        report(text)
    return loaded


def _from_files(files: FrameFiles, options: ReadingOptions, name: str | None) -> tuple[RGBDFrame, tuple[str, ...]]:
    """A frame without ground truth and guide, and the warnings about reading it."""
    rgb_file, depth_file = read_file(files.rgb), read_file(files.depth)
    colour, colour_doubt = read_colour_with_warning(rgb_file)
    of_colour = (colour_doubt,) if colour_doubt else ()
    read = _read_depth(files, depth_file, options)
    orientation = pair_orientation(rgb_file, colour, depth_file, read.metres)
    colour, values = turned(colour, orientation.tags[0]), turned(read.metres, orientation.tags[1])
    chosen, is_same = options.or_else(files.options), colour.shape[:2] == values.shape
    if not is_same and chosen.depth_intrinsics is None:
        raise InputError(
            f"{files.rgb} is {_size(colour)} but {files.depth} is {_size(values)} pixels. Both must have the same "
            "pixels: give the intrinsics of both (--intrinsics and --depth-intrinsics), by which depth is registered, "
            f"or register and resize one to the other first.{_exchanged(colour, values)} {orientation.note}".rstrip()
        )
    if files.size not in {None, (values.shape[1], values.shape[0])}:
        raise FormatError(
            f"{files.rgb.with_name(META_NAME)} has the size {files.size}, but the images are {_size(values)} pixels. "
            "Correct its size, or load the two files separately."
        )
    camera, depth_camera, notes, issued = _cameras(chosen, colour.shape[:2], values.shape)
    inputs = FrameInputs(
        _input_file(rgb_file),
        _input_file(depth_file),
        read.encoding.units,
        _numbers(camera),
        encoding=read.encoding.name,
        invalid=read.encoding.invalid,
        depth_intrinsics=_numbers(depth_camera),
        orientations=None if orientation.tags == AS_STORED else orientation.tags,
    )
    unlike = unlike_companions(chosen, depth_file, orientation)
    of_pair = (*([orientation.note] if orientation.note else []), *unlike)
    doubts = (*of_colour, *(of_pair if orientation.is_doubt else unlike))
    try:
        frame = replace(
            frame_of_images(colour, values, camera, inputs, name or files.name),
            notes=(*of_colour, *of_pair, *read.notes, *notes),
            plausibility_warnings=(*doubts, *(doubt.text for doubt in read.plausibility_warnings)),
            pose=(files if chosen.pose is None else replace(files, options=chosen)).camera_pose,
            invalid_marker=read.invalid_marker,
        )
        if is_same and files.outside_view is not None:
            frame = replace(frame, outside_view=read_mask(files.outside_view, colour.shape[:2]))
    except InputError as error:
        raise InputError(f"{files.depth}: {error}{read.alternative_encodings}") from error
    return frame, (*(f"{files.rgb}: {text}" for text in of_colour), *of_pair, *read.warnings, *issued)


def unlike_companions(
    options: ReadingOptions, depth_file: FileContent, orientation: PairOrientation
) -> tuple[str, ...]:
    """Doubts about ground truth, guide and confidence map whose orientation is not that of the pair, as it is read."""
    beside = filter(None, (options.ground_truth, options.guide, options.confidence))
    companions = [read_file(path) for path in beside if Path(path).suffix.lower() in COLOUR_SUFFIXES]
    return companion_doubts(companions, orientation_tag(depth_file) if orientation.tags == AS_STORED else 1)


def _exchanged(colour: NDArray[np.uint8], depth: NDArray[np.float32]) -> str:
    """A hint for an image that is turned by 90 degrees; "" otherwise."""
    is_so = colour.shape[:2] == depth.shape[::-1]
    return " Width and height are exchanged: one of the files is turned by 90 degrees." if is_so else ""


def _cameras(
    options: ReadingOptions, shape: tuple[int, int], depth_shape: tuple[int, int]
) -> tuple[Camera | None, Camera | None, tuple[str, ...], tuple[str, ...]]:
    """The camera of colour, that of depth of another size, notes on both, and those among them to issue as warnings."""
    if shape == depth_shape:
        given = options.intrinsics if options.depth_intrinsics is None else options.depth_intrinsics
        camera, notes = frame_camera(given, shape)
        return camera, None, notes, notes if camera is None else ()
    camera, notes = frame_camera(options.intrinsics, shape)
    depth_camera, depth_notes = frame_camera(options.depth_intrinsics, depth_shape)
    if depth_camera is None or (camera is None and notes):
        raise InputError((depth_notes if depth_camera is None else notes)[0])
    doubt = camera_doubt(depth_camera, depth_shape)
    issued = (f"Depth camera: {doubt}",) if doubt else ()
    return camera, depth_camera, (*notes, *depth_notes, *issued), issued


def frame_of_images(
    colour: NDArray[np.uint8],
    metres: NDArray[np.float32],
    camera: Camera | None,
    inputs: FrameInputs,
    name: str,
) -> RGBDFrame:
    """A frame of colour (H, W, 3) and depth [m] of the same size; depth of another size is registered to colour.

    Parameters
    ----------
    colour, metres : ndarray
    camera : Camera or None
        Intrinsics of colour.
    inputs : FrameInputs
        With the intrinsics of depth of another size.
    name : str

    Raises
    ------
    InputError
        As `RGBDFrame` and `register`, and if the intrinsics of colour are not known though its size differs.
    """
    if inputs.depth_intrinsics is None:
        return RGBDFrame(colour, metres, camera, name, inputs=inputs)
    return register(pair_of_images(colour, metres, camera, inputs, name))


def pair_of_images(
    colour: NDArray[np.uint8],
    metres: NDArray[np.float32],
    camera: Camera | None,
    inputs: FrameInputs,
    name: str,
) -> RawPair:
    """The raw pair of two images of different sizes, seen from the same place; as `frame_of_images`."""
    if camera is None or inputs.depth_intrinsics is None:
        raise InputError(
            "depth has another size than colour: to register it, also give the intrinsics of colour (--intrinsics)."
        )
    return RawPair(colour, metres, camera, Camera(*inputs.depth_intrinsics), np.eye(4), name, inputs)


def _numbers(camera: Camera | None) -> tuple[float, float, float, float] | None:
    return None if camera is None else camera.numbers


def _pose_spec(pose: str | os.PathLike[str] | ArrayLike | None) -> str | tuple[float, ...] | None:
    """A pose as the options hold it; raises InputError for a matrix that is no pose."""
    if pose is None or isinstance(pose, str | os.PathLike):
        return path_text(pose)
    array = np.asarray(pose)
    return tuple(checked_transform(array.reshape(4, 4) if array.shape == (16,) else array, "pose").ravel().tolist())


def _with_min_confidence(
    frame: RGBDFrame,
    confidence: str | NDArray[Any] | None,
    min_value: float | None,
    report: Callable[[str], None],
) -> RGBDFrame:
    """A frame whose depth below the minimum confidence is marked invalid, by a confidence map or its file; reports a
    doubt about its scale."""
    low, note, doubt = None, UNUSED_CONFIDENCE, ""
    if confidence is None:
        note = "" if min_value is None else NO_CONFIDENCE_MAP
    elif min_value is not None:
        values = confidence if isinstance(confidence, np.ndarray) else read_confidence(confidence, frame.shape)
        low, note = low_confidence(values, min_value, frame.depth)
        doubt = confidence_doubt(values, min_value)
    if doubt:
        report(doubt)
        frame = replace(frame, plausibility_warnings=(*frame.plausibility_warnings, doubt))
    found = tuple(text for text in (note, doubt) if text)
    return replace(frame, invalid_mask=low, notes=(*frame.notes, *found)) if found else frame


def read_frame_depth(rgb: str, depth: str | None, options: ReadingOptions) -> DepthReading:
    """Read the depth of a frame alone, as `load_frame` does; raises the same errors except for the depth scale."""
    files = files_of(rgb, depth, beside=True)
    return _read_depth(files, read_file(files.depth), options)


def _read_depth(files: FrameFiles, content: FileContent, options: ReadingOptions) -> DepthReading:
    invalid = options.or_else(files.options).invalid
    return read_depth(content, options.depth_encoding, files.options.depth_encoding, invalid)


def files_of(rgb: str | os.PathLike[str], depth: str | os.PathLike[str] | None, beside: bool) -> FrameFiles:
    """The files given by two paths or a folder, and what meta.json states about them."""
    if depth is not None:
        return (meta_beside(rgb, depth) if beside else None) or _two_files(Path(rgb), Path(depth), beside)
    if is_recording(rgb):
        raise InputError(f"{rgb} is a recording: give the key of one of its frames (--frame; `ilf info` lists them).")
    if os.path.isdir(rgb):
        return frame_folder(rgb)
    if not os.path.exists(rgb):
        raise InputError(f"{rgb}: there is no such file or folder. Check the name.")
    kind = kind_at(Path(rgb))
    if kind is not None and Path(rgb).suffix.lower() not in {*COLOUR_SUFFIXES, *DEPTH_FILE_SUFFIXES}:
        raise FormatError(f"{rgb} is {kind[0]}, not a frame. {kind[1]}")
    raise InputError(
        f"{rgb}: a frame needs a depth image besides its colour image. Give both files, or one folder with {META_NAME}."
    )


def is_frame_folder(folder: str | os.PathLike[str]) -> bool:
    """Whether a folder is a single frame: it has meta.json, or colour rgb.* and depth depth.*."""
    root = Path(folder)
    if os.path.isfile(root / META_NAME):
        return True
    return bool(_found(root, "rgb", COLOUR_SUFFIXES) and _found(root, "depth", DEPTH_FILE_SUFFIXES))


def frame_folder(folder: str | os.PathLike[str]) -> FrameFiles:
    """Read the meta.json of a frame folder, without the images.

    Parameters
    ----------
    folder : path-like
        Contains colour `rgb.*` and depth `depth.*`, or meta.json with the optional keys `name`, `size` [width, height],
        `depth_units_per_m` or
        `depth_encoding` (see `load_frame`), `depth_invalid` (the depth file's value for missing depth), `K` [fx, fy,
        cx, cy], `rgb` and `depth` (paths of the images; default: `rgb.*` and `depth.*` in the folder), `gt` (path of
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
    meta_path = root / META_NAME
    if not is_frame_folder(root):
        raise InputError(
            f"{root} has neither {META_NAME} nor rgb.* and depth.*. Give the colour and the depth file separately, or "
            "the key of one of its frames (--frame) if it contains several."
        )
    has_meta = os.path.isfile(meta_path)
    meta = read_json(meta_path) if has_meta else {}
    if not isinstance(meta, dict):
        raise FormatError(f"{meta_path} must hold a JSON object with size, depth_units_per_m and K.")
    try:
        stated = (meta.get(key) for key in ("depth_units_per_m", "gt_units_per_m"))
        units, ground_truth_units = (None if value is None else checked_units(value) for value in stated)
        encoding = _meta_encoding(meta.get("depth_encoding"))
        single_encoding(encoding, units)
        invalid = None if meta.get("depth_invalid") is None else checked_invalid(meta["depth_invalid"])
        camera = None if meta.get("K") is None else as_camera({"K": meta["K"]}, None)
        min_value = None if meta.get("min_confidence") is None else checked_min_confidence(meta["min_confidence"])
        pose = None if meta.get("pose") is None else checked_transform(meta["pose"], "pose")
        size, name = _meta_size(meta.get("size")), meta.get("name") or root.name
        named = {key: meta.get(key) for key in ("rgb", "depth", "gt", "guide", "confidence", "outside_view", "run")}
        for key, value in {"name": name, **named}.items():
            if not isinstance(value, str | None):
                raise InputError(f"{key} must be text, not {value!r:.60}.")
        if name != one_line(name):
            raise InputError(f"name must be one line of text, not {name!r:.60}.")
    except (InputError, ParameterError) as error:
        raise FormatError(f"{meta_path}: {error}") from error
    if named["run"] and not os.path.isfile(named_in(named["run"], root)):
        raise InputError(
            f"{root} contains an interrupted export: its {named['run']} is missing, so its files may not belong "
            "together. Export again."
        )
    if not has_meta:
        _check_alone(root, ("rgb", COLOUR_SUFFIXES), ("depth", DEPTH_FILE_SUFFIXES))
    rgb = _named_image(root, named["rgb"], named["run"]) or _image_in(root, "rgb", COLOUR_SUFFIXES, "")
    hint = ""
    if os.path.isfile(root / "gt.png"):
        hint = (
            f" To use gt.png as depth, load {rgb.name} and gt.png as two files"
            f" with depth units {meta.get('gt_units_per_m')}."
        )
    depth = _named_image(root, named["depth"]) or _image_in(root, "depth", DEPTH_FILE_SUFFIXES, hint)
    options = ReadingOptions(
        encoding=encoding,
        depth_units=units,
        invalid=invalid,
        min_confidence=min_value,
        intrinsics=camera,
        ground_truth=path_text(_ground_truth_in(root, named["gt"])),
        ground_truth_units=ground_truth_units,
        guide=path_text(_named_image(root, named["guide"]) or _found(root, "guide", GUIDE_SUFFIXES)),
        confidence=path_text(
            _named_image(root, named["confidence"]) or _found(root, "confidence", CONFIDENCE_SUFFIXES)
        ),
    )
    return FrameFiles(
        *(rgb, depth, name, options, size),
        pose=None if pose is None else tuple(map(tuple, pose.tolist())),
        outside_view=_named_image(root, named["outside_view"]),
        has_meta=has_meta,
    )


def _ground_truth_in(root: Path, description: str | None) -> Path | None:
    """The ground truth file of a frame folder: as listed in meta.json, or `gt.*`; None if there is none."""
    if description and Path(description).suffix.lower() in DEPTH_FILE_SUFFIXES and not re.search(r"\s", description):
        return _named_image(root, description)
    return _found(root, "gt", DEPTH_FILE_SUFFIXES) if is_ground_truth(description) else None


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


def _input_file(content: FileContent) -> InputFile:
    return InputFile(str(content.path), content.sha256)


def _two_files(rgb: Path, depth: Path, beside: bool) -> FrameFiles:
    rgb, depth = rgb.absolute(), depth.absolute()
    confidence = path_text(_confidence_beside(depth)) if beside else None
    return FrameFiles(rgb, depth, name_from_path(rgb), ReadingOptions(confidence=confidence))


def _confidence_beside(depth: Path) -> Path | None:
    """The confidence map whose name has "confidence" where that of the depth file or of its folder has "depth"."""
    stem, folder = (_DEPTH_WORD.sub("confidence", name) for name in (depth.stem, depth.parent.name))
    beside = depth.parent if folder == depth.parent.name else depth.parent.with_name(folder)
    places = ((depth.parent, stem), (beside, depth.stem), (beside, stem))
    found = (_found(root, name, CONFIDENCE_SUFFIXES) for root, name in places if root / name != depth.with_suffix(""))
    return next((path for path in found if path is not None), None)


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


def _image_in(root: Path, stem: str, suffixes: tuple[str, ...], hint: str) -> Path:
    if path := _found(root, stem, suffixes):
        return path
    others = ", ".join(sorted(entry.name for entry in root.iterdir() if entry.name != META_NAME)) or "nothing else"
    what = "raw depth" if stem == "depth" else "colour image"
    raise InputError(f"{root} has no {what} ({stem}{suffixes[0]}); it contains {others}.{hint}")


def _check_alone(root: Path, *images: tuple[str, tuple[str, ...]]) -> None:
    """Raise InputError if a folder has several files of the name and suffixes of one image."""
    for stem, suffixes in images:
        names = [stem + suffix for suffix in suffixes if os.path.isfile(root / (stem + suffix))]
        if len(names) > 1:
            raise InputError(f"{root} has {' and '.join(names)}: give the colour and the depth file that are meant.")


def _found(root: Path, stem: str, suffixes: tuple[str, ...]) -> Path | None:
    return next((root / (stem + suffix) for suffix in suffixes if os.path.isfile(root / (stem + suffix))), None)


def _meta_encoding(spec: Any) -> EncodingSpec | None:
    if not isinstance(spec, str | int | float | None):
        raise InputError(f"depth_encoding must be a name or a number, not {spec!r:.60}.")
    if spec is not None and not needs_scene(spec):
        encoding_of(spec)
    return spec


def _meta_size(size: Any) -> tuple[int, int] | None:
    if size is None:
        return None
    if not (isinstance(size, list) and len(size) == 2 and all(type(number) is int for number in size)):
        raise InputError(f"size must be [width, height] in whole pixels, not {size!r:.60}.")
    return size[0], size[1]


def _size(array: Any) -> str:
    return f"{array.shape[1]} x {array.shape[0]}"


# Writing an RGBDFrame to a frame folder that `ilf.load_frame` reads.

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
    try:
        root.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{root} cannot be created ({cause(error)}). Choose another folder.") from error
    write_bytes(paths[0], encode_image(".png", frame.rgb[..., ::-1]))
    write_depth(paths[1], frame.measured)
    write_bytes(paths[2], f"{json.dumps(meta, indent=2)}\n".encode())
    return paths
