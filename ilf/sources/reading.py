"""Reading a frame: a folder with meta.json, two files, or a frame of a recording; also at addresses."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import is_address
from ..data.camera import CAMERA_DOUBT
from ..data.frame import FrameInputs, RGBDFrame
from ..data.guide import Gives
from ..data.lenses import undistorted
from ..errors import FormatError, InputError, ParameterError, PathKind, check_kind, told_as, warn_of_reading
from ..io.cameras import IntrinsicsSpec
from ..io.depth_doubts import DepthReading
from ..io.encodings import EncodingSpec
from ..io.frame_additions import (
    NO_CONFIDENCE_MAP,
    NO_GUIDE,
    UNUSED_CONFIDENCE,
    confidence_doubt,
    load_guide,
    low_confidence,
    read_confidence,
    with_ground_truth_file,
)
from ..io.kinds import kind_at
from .copies import copied, restored, with_addresses
from .frame_folder import FrameFiles, frame_folder, meta_beside, two_files
from .frame_ref import COMPLETED_DEPTH, OPTIONS, FrameRef, ReadingOptions, is_result
from .named_places import named_in, note_opened
from .naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, META_NAME
from .opening import is_recording, opened
from .pairing import time_of
from .read_images import depth_of_files, read_files, read_recorded
from .registration import RawPair


def load_frame(
    rgb: str | os.PathLike[str],
    depth: str | os.PathLike[str] | None = None,
    *,
    depth_units: float | None = None,
    encoding: EncodingSpec | None = None,
    invalid: float | None = None,
    dataset: str | None = None,
    intrinsics: IntrinsicsSpec | None = None,
    depth_intrinsics: IntrinsicsSpec | None = None,
    undistort: bool | None = None,
    view: str | None = None,
    name: str | None = None,
    ground_truth: str | os.PathLike[str] | None = None,
    ground_truth_units: float | None = None,
    guide: str | os.PathLike[str] | None = None,
    guide_gives: Gives | None = None,
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
        Depth in any format of `ilf.io.depth.read_depth_values`: 16-bit PNG, TIFF, PGM, NPY, EXR and others.
    depth_units : float, optional
        File units per metre: the encoding of most files.
    encoding : str or float, optional
        Conversion of the depth file's values to metres: a name of `ilf.io.encodings.ENCODINGS` ("mm", "tum", "sun",
        "nyu-raw", ...), "bop", "bop:SCALE", "disparity:FB", "zbuffer:NEAR,FAR", ..., or file units per metre. It
        replaces `depth_units`. Without both, the value in meta.json is used, also for two files that lie beside it (see
        `meta_beside`); without that, 1000 units per metre for integers and 1 for floats. An explicit encoding skips
        the plausibility check.
    invalid : float, optional
        The file's value for missing depth, besides zero, negative and not finite ones; 0 means that there is none. None
        uses the value in meta.json.
    dataset : str, optional
        The dataset of an HDF5 file that is the depth, if it has several that can be; also named behind the file, as
        "take.h5:/left/depth".
    intrinsics : optional
        Anything that `ilf.io.cameras.intrinsics_from` accepts; it overrides meta.json.
    depth_intrinsics : optional
        The same for a depth file of another size than colour: its depth is registered to colour by both intrinsics, and
        by the transform between the cameras if a file states it for both (DepthAI, Kalibr, RealSense) or a mapping
        has `depth_to_colour`, its rows; else as seen from the same place (see `ilf.sources.registration`). Images of
        the same size are registered so if `view` is given; else they count as registered, and these are the intrinsics
        of both.
    undistort : bool, optional
        Whether colour and depth are undistorted, by the distortion that the intrinsics of each state (OpenCV's models:
        up to 14 coefficients, or a fisheye); `intrinsics` of the frame are then those of the undistorted images. Depth
        is moved, not interpolated, and so are ground truth and confidence.
    view : str, optional
        The camera whose pixels an unregistered frame has after registration, "colour" (None) or "depth": depth stays as
        measured then, colour is brought to it (`ilf.sources.registration.register`), and ground truth, guide and
        confidence have its pixels.
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
    guide_gives : str, optional
        What the guide's values are, see `ilf.data.guide.Guide`; a network with a name states it itself.
    confidence : path-like, optional
        The sensor's confidence of its depth, see `ilf.io.frame_additions.read_confidence`. None uses that of the
        folder, if any: also without meta.json, a file whose name has "confidence" where that of the depth file or its
        folder has "depth".
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
        are given, ground truth units are given without ground truth, the minimum confidence is not a number, or there
        is no such view or kind of guide.
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
    if frame is not None and depth is not None:
        raise ParameterError("A recording contains the depth of its frames: leave the depth file out.")
    options = ReadingOptions.from_arguments(locals())  # the keywords that are reading options
    ref = FrameRef(os.fspath(rgb), None if depth is None else os.fspath(depth), frame, options)
    return read_frame(ref, name=name, beside=beside, warn=warn)


def read_frame(ref: FrameRef, *, name: str | None = None, beside: bool = True, warn: bool = False) -> RGBDFrame:
    """Read the frame of a reference: what `load_frame` does, from one object. Plausibility warnings and notes on what
    was left out are in its `notes`; they are issued as `DepthWarning` only with `warn`.

    Raises
    ------
    InputError, FormatError, ParameterError, ExportError
        As `load_frame`, and as `FrameRef.allowed`.
    """
    own = ref.allowed()
    if any(map(is_address, own.paths)):
        with copied(own) as here:
            loaded, issued = with_addresses(_read(here, name, beside))
    else:
        loaded, issued = _read(own, name, beside)
    for text in issued if warn else ():
        warn_of_reading(text)
    note_opened(*own.paths, *own.options.camera_paths.values(), *loaded.files)
    return loaded


def _read(ref: FrameRef, name: str | None, beside: bool) -> tuple[RGBDFrame, tuple[str, ...]]:
    """Read a frame on this machine; with plausibility warnings and what was left out."""
    if ref.frame is None:
        files = files_of(ref, beside=beside)
        chosen = ref.options.or_else(files.options)
        if ref.depth is None and files.has_meta and chosen.depth_encoding is None:
            lacking = "no depth_units_per_m (1000 for millimetres) and no depth_encoding"
            raise FormatError(f"{Path(ref.rgb) / META_NAME} has {lacking}: add one, or give depth units.")
        images = read_files(files, ref.options, name)
    else:
        images, chosen = read_recorded(ref, name), ref.options
    loaded = images.frame()
    if is_result(ref):
        loaded = replace(loaded, notes=(*loaded.notes, f"{ref.depth or ref.rgb}: {COMPLETED_DEPTH}"))
    issued = [*images.warnings, *(text for text in loaded.notes if text.startswith(CAMERA_DOUBT))]
    chosen = chosen.checked()
    loaded, doubt = _with_min_confidence(loaded, chosen.confidence or images.confidence, chosen.min_confidence)
    issued += [doubt] if doubt else []
    if chosen.guide is not None:
        loaded = loaded.with_guide(load_guide(chosen.guide, loaded.shape, loaded.rgb, chosen.guide_gives))
    elif chosen.guide_gives is not None:
        loaded = replace(loaded, notes=(*loaded.notes, NO_GUIDE))
        issued.append(NO_GUIDE)
    if chosen.ground_truth is not None:
        known = len(loaded.notes)
        loaded = with_ground_truth_file(loaded, chosen.ground_truth, chosen.ground_truth_units)
        issued += loaded.notes[known:]
    elif ref.options.ground_truth_units is not None:
        raise ParameterError("Ground truth units are given without ground truth: give its file, too.")
    return loaded, tuple(issued)


def files_of(ref: FrameRef, *, beside: bool = True) -> FrameFiles:
    """The files of a frame on this machine, and what a meta.json beside them states; with `beside` false, not that
    beside two files. Raises InputError for what is no frame, and as `frame_folder`."""
    if ref.depth is not None:
        return two_files(ref.rgb, ref.depth, beside=beside)
    path = Path(ref.rgb)
    if not os.path.isfile(path / META_NAME) and is_recording(path):
        raise InputError(f"{path} is a recording: give the key of one of its frames (--frame; `ilf info` lists them).")
    if os.path.isdir(path):
        return frame_folder(path)
    if not os.path.exists(path):
        raise InputError(f"{path}: there is no such file or folder. Check the name.")
    kind = kind_at(path)
    if kind is not None and path.suffix.lower() not in {*COLOUR_SUFFIXES, *DEPTH_FILE_SUFFIXES}:
        raise FormatError(f"{path} is {kind[0]}, not a frame. {kind[1]}")
    both = "Give both files (the same one twice if it has both)"
    raise InputError(f"{path}: a frame needs a depth image, too. {both}, or a folder with {META_NAME}.")


def _with_min_confidence(
    frame: RGBDFrame, confidence: str | NDArray[Any] | None, least: float | None
) -> tuple[RGBDFrame, str]:
    """A frame whose depth below the minimum confidence is marked invalid, by a confidence map or its file; and a doubt
    about its scale."""
    if confidence is None or least is None:
        note = UNUSED_CONFIDENCE if confidence is not None else "" if least is None else NO_CONFIDENCE_MAP
        return (replace(frame, notes=(*frame.notes, note)) if note else frame), ""
    values = confidence if isinstance(confidence, np.ndarray) else read_confidence(confidence, frame.shape)
    values = undistorted(values, frame, of_depth=True)
    (low, note), doubt = low_confidence(values, least, frame.depth), confidence_doubt(values, least, frame.depth)
    told = (doubt,) if doubt else ()
    doubts = (*frame.plausibility_warnings, *told)
    return replace(frame, invalid_mask=low, notes=(*frame.notes, note, *told), plausibility_warnings=doubts), doubt


def read_raw_pair(ref: FrameRef) -> RawPair:
    """Read colour and depth as captured by their two cameras, before registration; for registered images both cameras
    are the same. Plausibility warnings are issued as `DepthWarning`.

    Raises
    ------
    InputError
        If a camera is not known, and as `read_frame`.
    """
    own = ref.allowed()
    with copied(own) as here:
        if here.frame is not None:
            images = read_recorded(here)
        else:
            images = read_files(files_of(here), here.options)
            if images.cameras.colour is None:
                raise InputError(f"{ref.rgb}: the camera's intrinsics are not known. Give them to read the raw pair.")
        with told_as(InputError, f"{images.reading.path}: {{error}}", InputError):
            pair = images.pair()
    for text in images.warnings:
        warn_of_reading(restored(text))
    note_opened(*own.paths, *own.options.camera_paths.values())
    return pair if here is own else with_addresses(pair)


def read_depth(ref: FrameRef) -> DepthReading:
    """Read the depth of a frame alone, with its plausibility warnings; raises as `read_frame` but for its scale."""
    with copied(ref) as here:
        return read_recorded(here).reading if here.frame is not None else depth_of_files(files_of(here), here.options)


def described_beside(ref: FrameRef) -> str:
    """A sentence that lists what is read from a meta.json beside two files; "" for nothing."""
    own = ref.allowed()
    files = None if own.depth is None else meta_beside(own.rgb, own.depth)
    if files is None:
        return ""
    added = ref.options.or_else(files.options).given.keys() - ref.options.given.keys()
    used_items = ["name", *(name.replace("_", " ") for name in OPTIONS if name in added)]
    return f"Read from {META_NAME} beside the files: {', '.join(used_items)}."


# The time at which a frame that was read was taken.

_SECONDS = re.compile(r"(\d+)\.(\d{1,9})")


def stamp_of(inputs: FrameInputs, folder: Path | None = None) -> int | None:
    """Return the timestamp of a frame's colour [ns], from its key in a recording, the recording, or its file name; None
    if unknown. `folder` is that of the record that states these inputs.

    Raises
    ------
    InputError
        If the recording has to be read for it and cannot be read; and as `named_in`.
    """
    if inputs.frame is None:
        time = time_of(inputs.rgb.path)
        return None if time is None else round(time * 1e9)
    found = _SECONDS.fullmatch(inputs.frame.rpartition("/")[2])
    if found is not None:
        return int(found[1]) * 10**9 + int(found[2].ljust(9, "0"))
    with opened(inputs.rgb.path if folder is None else named_in(inputs.rgb.path, folder)) as recording:
        taken = recording.frame(inputs.frame).time
    return None if taken is None else round(taken * 1e9)
