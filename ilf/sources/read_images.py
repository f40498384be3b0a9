"""Colour and depth of one moment as read, from two files or a recording: to a frame, or to a raw pair."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.camera import DISTORTION_NOTE, Camera, Cameras
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..errors import InputError, told_as
from ..io.cameras import IntrinsicsSpec, lens_from
from ..io.depth_reading import DepthReading, interpret_depth
from ..io.images import scaled_colour
from .frame_ref import FrameRef
from .naming import recorded_frame_name
from .opening import opened
from .reading_options import COLOUR_VIEW, DEPTH_VIEW
from .registration import RawPair, register
from .trajectories import stated_pose


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

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the resulting frame."""
        image = self.metres if self.cameras.is_registered or self.inputs.view is not None else self.rgb
        return image.shape[0], image.shape[1]

    def frame(self, intrinsics: Camera | None = None, notes: tuple[str, ...] = ()) -> RGBDFrame:
        """Colour with registered depth, or depth with registered colour in the depth camera's view.

        Parameters
        ----------
        intrinsics : Camera, optional
            Intrinsics of the result; None uses those of the cameras.
        notes : tuple of str
            Further notes.

        Raises
        ------
        InputError
            If depth cannot be registered because calibration is missing or, in the depth camera's view, because it is
            registered already; or its values cannot be metres.
        """
        view = self.inputs.view or COLOUR_VIEW
        with told_as(InputError, f"{self.reading.path}: {{error}}{self.reading.alternative_encodings}", InputError):
            frame = self._registered() if self.cameras.is_registered else register(self.pair(), view)
        camera, inputs, pose = intrinsics or frame.intrinsics, self.inputs, self.pose
        if view == COLOUR_VIEW or inputs.frame is not None:
            inputs = replace(inputs, intrinsics=None if camera is None else camera.numbers)
        if pose is not None and frame.brought is not None:
            pose = pose @ frame.brought.depth_to_colour  # it is that of the colour camera
        return replace(
            frame,
            intrinsics=camera,
            inputs=inputs,
            notes=(*frame.notes, *notes),
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
            scaled_colour(self.rgb, self.shape),
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
    rgb, lenses = stored.rgb, None
    if options.undistort and cameras.is_registered:  # registration undistorts others
        shape = stored.depth.shape[0], stored.depth.shape[1]
        lens = _lens(options.intrinsics, cameras, shape, path)
        rgb, lenses, cameras = scaled_colour(rgb, shape), (lens, lens), Cameras(lens, lens, np.eye(4))
    invalid = stored.invalid if options.invalid is None else options.invalid
    reading = interpret_depth(stored.depth, path, given, stored.encoding, invalid)
    return ReadImages(
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
