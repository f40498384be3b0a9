"""The calibration of an Azure Kinect: one for its sensors, from which those of its modes follow."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...camera import CameraIntrinsics
from ...errors import FormatError, InputError
from ...registration import Camera
from ...sections import Section
from .recording import Cameras

_DEPTH, _COLOUR = "CALIBRATION_CameraLocationD0", "CALIBRATION_CameraLocationPV0"
_PARAMETERS = 14


class _Mode(NamedTuple):
    """How a mode's image lies in the picture of the whole sensor: that picture's size, and what is cut off at its left
    and top."""

    whole: tuple[int, int]
    cut: tuple[int, int]
    size: tuple[int, int]


_DEPTH_MODES = {
    "NFOV_2X2BINNED": _Mode((512, 512), (96, 90), (320, 288)),
    "NFOV_UNBINNED": _Mode((1024, 1024), (192, 180), (640, 576)),
    "WFOV_2X2BINNED": _Mode((512, 512), (0, 0), (512, 512)),
    "WFOV_UNBINNED": _Mode((1024, 1024), (0, 0), (1024, 1024)),
}
_COLOUR_MODES = {
    "720P": _Mode((1280, 960), (0, 120), (1280, 720)),
    "1080P": _Mode((1920, 1440), (0, 180), (1920, 1080)),
    "1440P": _Mode((2560, 1920), (0, 240), (2560, 1440)),
    "1536P": _Mode((2048, 1536), (0, 0), (2048, 1536)),
    "2160P": _Mode((3840, 2880), (0, 360), (3840, 2160)),
    "3072P": _Mode((4096, 3072), (0, 0), (4096, 3072)),
}


def cameras_of(content: bytes, depth_mode: str, colour_mode: str) -> Cameras:
    """The cameras of a recording.

    Parameters
    ----------
    content : bytes
        Of calibration.json.
    depth_mode, colour_mode : str
        As the recording's tracks name them: "NFOV_UNBINNED", "MJPG_720P".

    Raises
    ------
    FormatError
        If the calibration is damaged, or there is no such mode.
    """
    resolution = colour_mode.rpartition("_")[2]
    for what, mode, known in (("depth", depth_mode, _DEPTH_MODES), ("colour", resolution, _COLOUR_MODES)):
        if mode not in known:
            raise FormatError(f"the {what} mode {mode!r:.40} is not known; {', '.join(known)} are.")
    try:
        data = json.loads(content.rstrip(b"\0"))
        listed = Section("calibration", data).section("CalibrationInformation").items("Cameras", dict)
        by_place = {camera.get("Location"): Section("camera", camera) for camera in listed}
        depth, colour = by_place[_DEPTH], by_place[_COLOUR]
        return Cameras(
            _camera(colour, _COLOUR_MODES[resolution]),
            _camera(depth, _DEPTH_MODES[depth_mode]),
            _motion(colour) @ np.linalg.inv(_motion(depth)),
            is_registered=False,
        )
    except (ValueError, KeyError, RecursionError, AttributeError, InputError, np.linalg.LinAlgError) as error:
        raise FormatError(f"its calibration is damaged ({error!s:.120}).") from error


def _camera(section: Section, mode: _Mode) -> Camera:
    """The camera of a mode: the numbers of the file are shares of the whole sensor's width and height."""
    values = section.section("Intrinsics").items("ModelParameters", float)
    if len(values) != _PARAMETERS:
        raise FormatError(f"a camera has {len(values)} parameters in place of {_PARAMETERS}.")
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, centre_x, centre_y, p2, p1 = values
    if centre_x or centre_y:
        raise FormatError("a camera's distortion has a centre of its own, which is not supported.")
    (width, height), (left, top) = mode.whole, mode.cut
    intrinsics = CameraIntrinsics(fx * width, fy * height, cx * width - left - 0.5, cy * height - top - 0.5)
    return Camera(intrinsics, mode.size, (k1, k2, p1, p2, k3, k4, k5, k6))


def _motion(section: Section) -> NDArray[Any]:
    """What takes points [m] to a camera."""
    place, matrix = section.section("Rt"), np.eye(4)
    matrix[:3, :3] = np.reshape(place.items("Rotation", float), (3, 3))
    matrix[:3, 3] = place.items("Translation", float)
    return matrix
