"""Reading a frame of a recording as RGBDFrame, or as raw pair where colour and depth are not registered."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..data.camera import DISTORTION_NOTE, Camera, Cameras
from ..data.frame import FrameInputs, InputFile, RGBDFrame
from ..errors import InputError
from ..io.depth_reading import DepthReading, interpret_depth
from ..io.encodings import EncodingSpec
from ..io.images import scaled_colour
from .naming import recorded_frame_name
from .opening import opened
from .recording import RecordedFrame
from .registration import RawPair, register


@dataclass(frozen=True, eq=False)
class ReadFrame:
    """A frame read from a recording: as stored, and its depth in metres.

    Attributes
    ----------
    path : Path
        Absolute path of the recording.
    key : str
        Key of the frame.
    stored : RecordedFrame
    cameras : Cameras
    reading : DepthReading
    pose : ndarray or None
        Its camera pose, as in `RGBDFrame`.
    """

    path: Path
    key: str
    stored: RecordedFrame
    cameras: Cameras
    reading: DepthReading
    pose: NDArray[np.float64] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the resulting RGBDFrame."""
        image = self.reading.metres if self.cameras.is_registered else self.stored.rgb
        return image.shape[0], image.shape[1]

    def frame(self, intrinsics: Camera | None = None, name: str | None = None) -> RGBDFrame:
        """Colour with registered depth.

        Parameters
        ----------
        intrinsics : Camera, optional
            Intrinsics of the result; None uses those of the recording.
        name : str, optional

        Raises
        ------
        InputError
            If depth cannot be registered because calibration is missing, or its values cannot be metres.
        """
        try:
            frame = self._registered(name) if self.cameras.is_registered else register(self._pair(name))
        except InputError as error:
            raise InputError(f"{self.path}: {error}{self.reading.alternative_encodings}") from error
        camera = intrinsics or frame.intrinsics
        inputs = replace(self._inputs(), intrinsics=None if camera is None else camera.numbers)
        plausibility_warnings = tuple(doubt.text for doubt in self.reading.plausibility_warnings)
        return replace(
            frame,
            intrinsics=camera,
            inputs=inputs,
            pose=self.pose,
            plausibility_warnings=plausibility_warnings,
            invalid_marker=self.reading.invalid_marker,
        )

    def pair(self, name: str | None = None) -> RawPair:
        """Colour and depth as captured by the two cameras, which are the same for a registered frame.

        Raises
        ------
        InputError
            If a camera or the transform between them is not known, or an image does not have its camera's size.
        """
        try:
            return self._pair(name)
        except InputError as error:
            raise InputError(f"{self.path}: {error}") from error

    def _registered(self, name: str | None) -> RGBDFrame:
        camera, metres = self.cameras.depth, self.reading.metres
        return RGBDFrame(
            scaled_colour(self.stored.rgb, (metres.shape[0], metres.shape[1])),
            metres,
            camera,
            self._name(name),
            inputs=self._inputs(),
            notes=(*self._notes(), *([DISTORTION_NOTE] if camera is not None and any(camera.distortion) else [])),
        )

    def _pair(self, name: str | None) -> RawPair:
        colour, depth, motion = self.cameras.colour, self.cameras.depth, self.cameras.depth_to_colour
        if colour is None or depth is None or motion is None:
            known = {
                "the calibration of the colour camera": colour,
                "that of the depth camera": depth,
                "the transform between the two": motion,
            }
            lacking = " and ".join(what for what, value in known.items() if value is None)
            raise InputError(
                f"depth is not registered to colour and cannot be, since the recording lacks {lacking}. Record aligned "
                "depth, or also record the cameras' calibration."
            )
        rgb, metres = self.stored.rgb, self.reading.metres
        view = self.stored.depth_view
        return RawPair(rgb, metres, colour, depth, motion, self._name(name), self._inputs(), self._notes(), view)

    def _name(self, given: str | None) -> str:
        return given or recorded_frame_name(self.path, self.key)

    def _notes(self) -> tuple[str, ...]:
        return *((self.cameras.note,) if self.cameras.note else ()), *self.reading.notes

    def _inputs(self) -> FrameInputs:
        """The frame's inputs without intrinsics."""
        encoding = self.reading.encoding
        rgb, depth = (
            InputFile(str(self.path), sha256) for sha256 in (self.stored.rgb_sha256, self.stored.depth_sha256)
        )
        return FrameInputs(
            rgb, depth, encoding.units, None, encoding=encoding.name, invalid=encoding.invalid, frame=self.key
        )


def read_recorded(
    path: str | os.PathLike[str], key: str, given: EncodingSpec | None = None, invalid: float | None = None
) -> ReadFrame:
    """Read a frame of a recording.

    Parameters
    ----------
    path : path-like
        Path of the recording.
    key : str
        Key of the frame.
    given : str or float, optional
        The depth encoding; None uses that of the recording.
    invalid : float, optional
        The depth value for missing; None uses that of the recording.

    Raises
    ------
    InputError
        If there is no such recording, or no such frame in it.
    FormatError
        If the recording is damaged.
    ParameterError
        If there is no such encoding.
    """
    with opened(path) as recording:
        stored, cameras, pose, found = recording.frame(key), recording.cameras(key), recording.pose(key), recording.path
    known = stored.invalid if invalid is None else invalid
    return ReadFrame(
        found, key, stored, cameras, interpret_depth(stored.depth, found, given, stored.encoding, known), pose
    )
