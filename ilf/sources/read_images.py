"""Colour and depth of one moment as read, from two files or a recording: to a frame, or to a raw pair."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, read_file
from .._runtime.formatting import size_text
from ..data.camera import DISTORTION_NOTE, Camera, Cameras, camera_doubt, fitted
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..errors import FormatError, InputError, told_as
from ..io.cameras import depth_place, frame_camera, lens_from
from ..io.depth import interpret_depth, read_depth
from ..io.depth_doubts import DepthReading, is_named_distance, turning_doubt
from ..io.encodings import ray_encoding
from ..io.images import AS_STORED, orientation_claim, read_colour_with_warning, read_mask, scaled_colour, turned
from ..io.orientation import pair_orientation
from .frame_folder import FrameFiles, camera_pose
from .frame_ref import COLOUR_VIEW, DEPTH_VIEW, FrameRef, ReadingOptions
from .naming import META_NAME, recorded_frame_name
from .opening import opened
from .registration import RawPair, register
from .trajectories import stated_pose

_NO_COLOUR_CAMERA = "depth has another size than colour: also give the intrinsics of colour (--intrinsics)."

_SAME_CAMERA = 0.02
"""By how much two cameras of one image may differ: focal lengths as a share, principal points by that of a side."""


@dataclass(frozen=True, eq=False)
class ReadImages:
    """Colour and depth as captured by their cameras, and what is known of them.

    Attributes
    ----------
    name : str
    rgb : ndarray of uint8, shape (h, w, 3)
    metres : ndarray of float32, shape (hd, wd)
        Depth [m], upright.
    reading : DepthReading
        How depth was read.
    cameras : Cameras
    inputs : FrameInputs
    notes : tuple of str
    warnings : tuple of str
        What to issue as Python warnings.
    doubts : tuple of str
        Those of the notes that are plausibility warnings, besides those of `reading`.
    pose : ndarray or None
        The camera pose, as in `RGBDFrame`.
    depth_view, outside_view : ndarray of bool or None
        As in `RawPair` and, where colour and depth have the same pixels, in `RGBDFrame`.
    confidence : ndarray or None
        The sensor's confidence of its depth, if a recording contains it.
    camera : Camera or None
        The intrinsics of the frame, if they are not those of the cameras.
    """

    name: str
    rgb: NDArray[np.uint8]
    metres: NDArray[np.float32]
    reading: DepthReading
    cameras: Cameras
    inputs: FrameInputs
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    pose: NDArray[np.float64] | None = None
    depth_view: NDArray[np.bool_] | None = None
    outside_view: NDArray[np.bool_] | None = None
    confidence: NDArray[Any] | None = None
    camera: Camera | None = None

    def frame(self) -> RGBDFrame:
        """Colour with registered depth, or depth with registered colour in the depth camera's view.

        Raises
        ------
        InputError
            If depth cannot be registered because calibration is missing or, in the depth camera's view, because it is
            registered already; or its values cannot be metres.
        """
        view = self.inputs.view or COLOUR_VIEW
        with told_as(InputError, f"{self.reading.path}: {{error}}{self.reading.alternative_encodings}", InputError):
            frame = self._registered() if self.cameras.is_registered else register(self.pair(), view)
        camera, inputs, pose = self.camera or frame.intrinsics, self.inputs, self.pose
        if view == COLOUR_VIEW or inputs.frame is not None:
            inputs = replace(inputs, intrinsics=None if camera is None else camera.numbers)
        if pose is not None and frame.brought is not None:
            pose = pose @ frame.brought.depth_to_colour  # it is that of the colour camera
        return replace(
            frame,
            intrinsics=camera,
            inputs=inputs,
            pose=pose,
            plausibility_warnings=(*self.doubts, *(doubt.text for doubt in self.reading.plausibility_warnings)),
            invalid_marker=self.reading.invalid_marker,
        )

    def _registered(self) -> RGBDFrame:
        if self.inputs.view is not None:
            told = "colour and depth have the same pixels already: leave out the depth camera's view (--view depth)"
            raise InputError(f"{told} or, if they are not registered, give --depth-intrinsics, too.")
        camera = self.cameras.depth
        is_distorted = camera is not None and any(camera.distortion)
        return RGBDFrame(
            scaled_colour(self.rgb, self.metres.shape),
            self.metres,
            camera,
            self.name,
            inputs=self.inputs,
            notes=(*self.notes, DISTORTION_NOTE) if is_distorted else self.notes,
            outside_view=self.outside_view,
        )

    def pair(self) -> RawPair:
        """Colour and depth as captured by the two cameras, which are the same for registered images.

        Raises
        ------
        InputError
            If a camera or the transform between them is not known, or an image does not have its camera's size.
        """
        colour, depth, motion = self.cameras.colour, self.cameras.depth, self.cameras.depth_to_colour
        if colour is None or depth is None or motion is None:
            known = {
                "the calibration of the colour camera": colour,
                "that of the depth camera": depth,
                "the transform between the two": motion,
            }
            lacking = " and ".join(what for what, value in known.items() if value is None)
            raise InputError(f"depth is not registered, and the recording lacks {lacking}. Record it or aligned depth.")
        images = self.rgb, self.metres
        return RawPair(*images, colour, depth, motion, self.name, self.inputs, self.notes, self.depth_view)


# Of two files.


def read_files(
    files: FrameFiles,
    options: ReadingOptions,
    name: str | None = None,
    depth: DepthReading | None = None,
    contents: tuple[FileContent, FileContent] | None = None,
) -> ReadImages:
    """Read a colour and a depth file; `options` are those of the user, which replace the ones stated beside the files.
    `depth` is what `depth_of_files` gives, if it is read already; `contents` are those of the files, likewise.

    Raises
    ------
    InputError
        If a file is missing, or the sizes differ and the cameras are not known.
    FormatError
        If a file is damaged, or the stated size is another one.
    """
    rgb_file, depth_file = contents or (read_file(files.rgb), read_file(files.depth))
    colour, colour_doubt = read_colour_with_warning(rgb_file)
    of_colour = (colour_doubt,) if colour_doubt else ()
    read, chosen = depth or depth_of_files(files, options, depth_file), options.or_else(files.options)
    metres, tags, turning, is_doubt = read.metres, AS_STORED, "", False
    claims = [orientation_claim(rgb_file), orientation_claim(depth_file)]
    if any(tag != 1 for tag, _ in claims):
        tags, turning, is_doubt = pair_orientation(rgb_file, colour, depth_file, metres, claims)
        colour, metres = turned(colour, tags[0]), turned(metres, tags[1])
    if not turning and colour.shape[:2] == metres.shape:
        turning, is_doubt = turning_doubt(colour, metres), True
    shape, is_same = colour.shape[:2], is_registered(chosen, colour.shape[:2], metres.shape)
    if not is_same and chosen.depth_intrinsics is None:
        is_exchanged = shape[0] * metres.shape[0] == shape[1] * metres.shape[1] and shape[0] != shape[1]
        hint = " Width and height are exchanged: one of the files is turned by 90 degrees." if is_exchanged else ""
        told = f"{files.rgb} is {size_text(shape)} but {files.depth} is {size_text(metres.shape)} pixels. Give both "
        told += "cameras (--intrinsics and --depth-intrinsics), or register and resize one to the other first."
        raise InputError(f"{told}{hint} {turning}".rstrip())
    if files.size not in {None, (metres.shape[1], metres.shape[0])}:
        meta = files.rgb.with_name(META_NAME)
        raise FormatError(f"{meta} has the size {files.size}, not {size_text(metres.shape)}. Correct its size.")
    cameras, notes, issued = _cameras(chosen, shape, metres.shape)
    if not is_same and cameras.colour is None:
        raise InputError(f"{files.depth}: {_NO_COLOUR_CAMERA}{read.alternative_encodings}")
    colour_camera, depth_camera = cameras.colour, None if cameras.is_registered else cameras.depth
    lenses = (colour_camera, depth_camera) if chosen.undistort and colour_camera and depth_camera else None
    of_pair, moved = (turning,) if turning else (), cameras.depth_to_colour
    inputs = _inputs(
        (str(rgb_file.path), rgb_file.sha256),
        (str(depth_file.path), depth_file.sha256),
        read,
        options=chosen,
        intrinsics=None if colour_camera is None else colour_camera.numbers,
        dataset=chosen.dataset,
        depth_intrinsics=None if depth_camera is None or lenses is not None else depth_camera.numbers,
        orientations=None if tags == AS_STORED else tags,
        lenses=lenses,
        depth_to_colour=None if moved is None or np.array_equal(moved, np.eye(4)) else tuple(moved.ravel().tolist()),
    )
    return ReadImages(
        name or files.name,
        colour,
        metres,
        read,
        cameras,
        inputs,
        notes=(*of_colour, *of_pair, *read.notes, *notes),
        warnings=(*(f"{files.rgb}: {text}" for text in of_colour), *of_pair, *read.warnings, *issued),
        doubts=(*of_colour, *(of_pair if is_doubt else ())),
        pose=pose_of_files(files, chosen),
        outside_view=read_mask(files.outside_view, shape) if is_same and files.outside_view is not None else None,
    )


def _inputs(
    rgb: tuple[str, str], depth: tuple[str, str], read: DepthReading, options: ReadingOptions, **others: Any
) -> FrameInputs:
    """What a frame is read from: colour and depth by path and hash, and how."""
    return FrameInputs(
        InputFile(*rgb),
        InputFile(*depth),
        read.encoding.units,
        encoding=read.encoding.name,
        invalid=read.encoding.invalid,
        view=DEPTH_VIEW if options.view == DEPTH_VIEW else None,
        **others,
    )


def depth_of_files(files: FrameFiles, options: ReadingOptions, content: FileContent | None = None) -> DepthReading:
    """The depth alone; its scale is not checked. `content` is that of its file, if it is read already. A name that
    states distances along rays is followed if the camera is known."""
    chosen, file = options.or_else(files.options), content or read_file(files.depth)
    read = read_depth(file, options.depth_encoding, files.options.depth_encoding, chosen.invalid, chosen.dataset)
    intrinsics = chosen.intrinsics if chosen.depth_intrinsics is None else chosen.depth_intrinsics
    if not (read.is_assumed and is_named_distance(files.depth)) or intrinsics is None:
        return read
    camera = frame_camera(intrinsics, read.values.shape)[0]
    along = None if camera is None else ray_encoding(read.encoding.units, camera)
    return interpret_depth(read.values, file.path, None, along, chosen.invalid)


def pose_of_files(files: FrameFiles, options: ReadingOptions) -> NDArray[np.float64] | None:
    """The camera pose, (4, 4): as `options` state it, or else from files beside the depth; None if not known."""
    return camera_pose(files.depth) if options.pose is None else stated_pose(options.pose)


def is_registered(options: ReadingOptions, shape: tuple[int, int], depth_shape: tuple[int, int]) -> bool:
    """Whether depth has the pixels of colour: images of the same size do, unless the options give depth a camera of its
    own and say in which camera's pixels both are to be."""
    return shape == depth_shape and (options.depth_intrinsics is None or options.view is None)


def _cameras(
    options: ReadingOptions, shape: tuple[int, int], depth_shape: tuple[int, int]
) -> tuple[Cameras, tuple[str, ...], tuple[str, ...]]:
    """The cameras of colour and depth, notes on both, and those among them to issue as warnings."""
    is_same = is_registered(options, shape, depth_shape)
    motion, is_rectified, placed = (
        (np.eye(4), False, ()) if is_same else depth_place(options.intrinsics, options.depth_intrinsics)
    )
    if options.undistort:
        colour, depth, notes = _lenses(options, shape, depth_shape)
        depth = replace(depth, distortion=(), model="pinhole") if is_rectified else depth
        return Cameras(colour, depth, motion), (*notes, *placed), placed
    if is_same:
        given = options.intrinsics if options.depth_intrinsics is None else options.depth_intrinsics
        camera, notes = frame_camera(given, shape)
        doubts = _doubt_of_registration(options, camera, shape)
        return Cameras.registered(camera), (*notes, *doubts), notes if camera is None else doubts
    camera, notes = frame_camera(options.intrinsics, shape)
    depth_camera, depth_notes = frame_camera(options.depth_intrinsics, depth_shape)
    is_one = repr(options.intrinsics) == repr(options.depth_intrinsics)  # a mapping may contain arrays
    if camera is not None and is_one:  # that of colour, as of a phone
        depth_camera, depth_notes = fitted(replace(camera, size=(shape[1], shape[0])), depth_shape), ()
    if depth_camera is None or (camera is None and notes):
        raise InputError((depth_notes if depth_camera is None else notes)[0])
    doubt = camera_doubt(depth_camera, depth_shape)
    issued = (*((f"Depth camera: {doubt}",) if doubt else ()), *placed)
    return Cameras(camera, depth_camera, motion), (*notes, *depth_notes, *issued), issued


def _doubt_of_registration(options: ReadingOptions, depth: Camera | None, shape: tuple[int, int]) -> tuple[str, ...]:
    """A doubt whether depth has the pixels of colour, if both cameras are stated and differ; else none."""
    colour = None if options.depth_intrinsics is None else frame_camera(options.intrinsics, shape)[0]
    if depth is None or colour is None:
        return ()
    height, width = shape
    differences = np.abs(np.subtract(colour.numbers, depth.numbers)) / (depth.fx, depth.fy, width, height)
    if differences.max() <= _SAME_CAMERA:
        return ()
    told = f"Colour and depth count as registered, but their cameras differ (fx {colour.fx:g}, {depth.fx:g})"
    return (f"{told}. Give --view colour, or depth, to register them; or leave out --depth-intrinsics.",)


def _lenses(
    options: ReadingOptions, shape: tuple[int, int], depth_shape: tuple[int, int]
) -> tuple[Camera, Camera, tuple[str, ...]]:
    """The cameras of colour and depth with their distortion, and notes on scaling; raises InputError if none is
    stated."""
    if options.intrinsics is None:
        raise InputError("To undistort a frame, give a file of intrinsics that states the distortion of the lens.")
    colour, notes = lens_from(options.intrinsics, shape)
    of_own = options.intrinsics if options.depth_intrinsics is None else options.depth_intrinsics
    depth, of_depth = lens_from(of_own, depth_shape)
    if not (colour.is_bent or depth.is_bent):
        raise InputError("The intrinsics state no lens distortion that could be corrected: do not undistort.")
    return colour, depth, tuple(dict.fromkeys(notes + of_depth))


# Of a recording.


def read_recorded(ref: FrameRef, name: str | None = None) -> ReadImages:
    """Read the images of a frame of a recording; options that are not given are those of the recording.

    Raises
    ------
    InputError
        If there is no such recording, or no such frame in it.
    FormatError
        If the recording is damaged.
    ParameterError
        If there is no such encoding.
    """
    key, options, given = ref.frame or "", ref.options, ref.options.depth_encoding
    if options.dataset is not None:
        raise InputError(f"{ref.rgb} is a recording: a dataset is that of a depth file. Leave it out.")
    with opened(ref.rgb) as recording:
        stored, cameras, pose, path = recording.frame(key), recording.cameras(key), recording.pose(key), recording.path
    rgb, lenses, intrinsics = stored.rgb, None, options.intrinsics
    if options.undistort and cameras.is_registered:  # registration undistorts others
        shape = stored.depth.shape[0], stored.depth.shape[1]
        lens = cameras.depth if intrinsics is None else lens_from(intrinsics, shape)[0]
        if lens is None or not lens.is_bent:
            told = f"{path} states no lens distortion that could be corrected: do not undistort. {cameras.note}"
            raise InputError(told.rstrip())
        rgb, lenses, cameras, intrinsics = scaled_colour(rgb, shape), (lens, lens), Cameras(lens, lens, np.eye(4)), None
    invalid = stored.invalid if options.invalid is None else options.invalid
    reading = interpret_depth(stored.depth, path, given, stored.encoding, invalid)
    image = reading.metres if cameras.is_registered or options.view == DEPTH_VIEW else rgb
    camera, camera_notes = frame_camera(intrinsics, image.shape[:2])
    if camera is None and camera_notes:
        raise InputError(camera_notes[0])
    return ReadImages(
        name or recorded_frame_name(path, key),
        rgb,
        reading.metres,
        reading,
        cameras,
        _inputs(
            (str(path), stored.rgb_sha256),
            (str(path), stored.depth_sha256),
            reading,
            options=options,
            intrinsics=None,
            frame=key,
            lenses=lenses,
        ),
        notes=(*((cameras.note,) if cameras.note else ()), *reading.notes, *camera_notes),
        warnings=reading.warnings,
        pose=pose if options.pose is None else stated_pose(options.pose),
        depth_view=stored.depth_view,
        confidence=stored.confidence,
        camera=camera,
    )
