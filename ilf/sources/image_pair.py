"""Reading a colour and a depth file: both upright, depth in metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, read_file
from .._runtime.formatting import size_text
from ..data.camera import Camera, Cameras, camera_doubt
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..errors import FormatError, InputError
from ..io.cameras import depth_place, frame_camera, lens_from
from ..io.depth_doubts import is_named_distance
from ..io.depth_reading import DepthReading, interpret_depth, read_depth
from ..io.encodings import ray_encoding
from ..io.images import read_colour_with_warning, turned
from ..io.labels import read_mask
from ..io.orientation import AS_STORED, pair_orientation
from .frame_folder import FrameFiles
from .naming import META_NAME
from .read_images import ReadImages
from .reading_options import COLOUR_VIEW, DEPTH_VIEW, ReadingOptions
from .registration import RawPair, register
from .trajectories import camera_pose, stated_pose

_NO_COLOUR_CAMERA = "depth has another size than colour: also give the intrinsics of colour (--intrinsics)."

_SAME_CAMERA = 0.02
"""By how much two cameras of one image may differ: focal lengths as a share, principal points by that of a side."""


def read_files(
    files: FrameFiles, options: ReadingOptions, name: str | None = None, depth: DepthReading | None = None
) -> ReadImages:
    """Read a colour and a depth file; `options` are those of the user, which replace the ones stated beside the files.
    `depth` is what `depth_of_files` gives, if it is read already.

    Raises
    ------
    InputError
        If a file is missing, or the sizes differ and the cameras are not known.
    FormatError
        If a file is damaged, or the stated size is another one.
    """
    rgb_file, depth_file = read_file(files.rgb), read_file(files.depth)
    colour, colour_doubt = read_colour_with_warning(rgb_file)
    of_colour = (colour_doubt,) if colour_doubt else ()
    read, chosen = depth or depth_of_files(files, options, depth_file), options.or_else(files.options)
    tags, turning, is_doubt = pair_orientation(rgb_file, colour, depth_file, read.metres)
    colour, metres = turned(colour, tags[0]), turned(read.metres, tags[1])
    shape, is_same = colour.shape[:2], is_registered(chosen, colour.shape[:2], metres.shape)
    if not is_same and chosen.depth_intrinsics is None:
        is_exchanged = shape == metres.shape[::-1]
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
    of_pair = (turning,) if turning else ()
    return ReadImages(
        name or files.name,
        colour,
        metres,
        read,
        cameras,
        FrameInputs(
            InputFile(str(rgb_file.path), rgb_file.sha256),
            InputFile(str(depth_file.path), depth_file.sha256),
            read.encoding.units,
            None if colour_camera is None else colour_camera.numbers,
            encoding=read.encoding.name,
            invalid=read.encoding.invalid,
            dataset=chosen.dataset,
            depth_intrinsics=None if depth_camera is None or lenses is not None else depth_camera.numbers,
            orientations=None if tags == AS_STORED else tags,
            lenses=lenses,
            view=DEPTH_VIEW if chosen.view == DEPTH_VIEW else None,
            depth_to_colour=_moved_by(cameras),
        ),
        notes=(*of_colour, *of_pair, *read.notes, *notes),
        warnings=(*(f"{files.rgb}: {text}" for text in of_colour), *of_pair, *read.warnings, *issued),
        doubts=(*of_colour, *(of_pair if is_doubt else ())),
        pose=pose_of_files(files, chosen),
        outside_view=read_mask(files.outside_view, shape) if is_same and files.outside_view is not None else None,
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
    return (
        f"Colour and depth are taken as registered, with the camera of depth (fx {depth.fx:g}), but that of colour "
        f"differs (fx {colour.fx:g}). Give --view colour, or depth, to register them; or leave out --depth-intrinsics.",
    )


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


def frame_of_images(
    colour: NDArray[np.uint8],
    metres: NDArray[np.float32],
    camera: Camera | None,
    inputs: FrameInputs,
    name: str,
) -> RGBDFrame:
    """A frame with this camera of colour (H, W, 3) and depth [m] that were read as `inputs` say, upright; depth of
    another size is registered. Raises InputError as `RGBDFrame` and `register`, and if the intrinsics of colour are not
    known though its size differs."""
    if inputs.lenses is not None:
        lenses = inputs.lenses
    elif inputs.depth_intrinsics is None:
        return RGBDFrame(colour, metres, camera, name, inputs=inputs)
    else:
        if inputs.view is not None and inputs.intrinsics is not None:  # the frame's camera is that of depth
            camera = Camera(*inputs.intrinsics)
        if camera is None:
            raise InputError(_NO_COLOUR_CAMERA)
        lenses = camera, Camera(*inputs.depth_intrinsics)
    motion = np.eye(4) if inputs.depth_to_colour is None else np.reshape(inputs.depth_to_colour, (4, 4))
    return register(RawPair(colour, metres, *lenses, motion, name, inputs), inputs.view or COLOUR_VIEW)


def _moved_by(cameras: Cameras) -> tuple[float, ...] | None:
    motion = cameras.depth_to_colour
    return None if motion is None or np.array_equal(motion, np.eye(4)) else tuple(motion.ravel().tolist())
