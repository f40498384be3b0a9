"""Reading the images of a frame of a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..data.camera import Camera, Cameras
from ..data.frame import FrameInputs, InputFile
from ..errors import InputError
from ..io.cameras import IntrinsicsSpec, lens_from
from ..io.depth_reading import interpret_depth
from ..io.images import scaled_colour
from .frame_ref import FrameRef
from .naming import recorded_frame_name
from .opening import opened
from .read_images import ReadImages
from .reading_options import DEPTH_VIEW
from .trajectories import stated_pose


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
    rgb, lenses = stored.rgb, None
    if options.undistort and cameras.is_registered:  # registration undistorts others
        shape = stored.depth.shape[0], stored.depth.shape[1]
        lens = _lens(options.intrinsics, cameras, shape, path)
        rgb, lenses, cameras = scaled_colour(rgb, shape), (lens, lens), Cameras(lens, lens, np.eye(4))
    invalid = stored.invalid if options.invalid is None else options.invalid
    reading = interpret_depth(stored.depth, path, given, stored.encoding, invalid)
    return ReadImages(
        path,
        name or recorded_frame_name(path, key),
        rgb,
        reading.metres,
        reading,
        cameras,
        FrameInputs(
            InputFile(str(path), stored.rgb_sha256),
            InputFile(str(path), stored.depth_sha256),
            reading.encoding.units,
            None,
            encoding=reading.encoding.name,
            invalid=reading.encoding.invalid,
            frame=key,
            lenses=lenses,
            view=DEPTH_VIEW if options.view == DEPTH_VIEW else None,
        ),
        notes=(*((cameras.note,) if cameras.note else ()), *reading.notes),
        warnings=reading.warnings,
        pose=pose if options.pose is None else stated_pose(options.pose),
        depth_view=stored.depth_view,
        confidence=stored.confidence,
    )


def _lens(stated: IntrinsicsSpec | None, cameras: Cameras, shape: tuple[int, int], path: Path) -> Camera:
    """The camera of registered images (H, W) with its distortion: as stated, or else as in the recording."""
    lens = cameras.depth if stated is None else lens_from(stated, shape)[0]
    if lens is None or not lens.is_bent:
        told = f"{path} states no lens distortion that could be corrected: do not undistort. {cameras.note}"
        raise InputError(told.rstrip())
    return lens
