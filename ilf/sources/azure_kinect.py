"""Recordings of Azure Kinect and Femto cameras (.mkv), read by PyAV."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import optional
from .._runtime.memory import check_memory
from .._runtime.schema import Section
from ..data.camera import Camera, Cameras, rigid_transform
from ..errors import FormatError, told_as
from ..io.depth import eight_bit_error
from ..io.images import read_colour
from .pairing import TimedPairs, stamped
from .recording import PairedRecording, RecordedFrame, part_of, sha256_of

# The calibration of an Azure Kinect: stored for the full sensors; those of the modes are derived from it.

_DEPTH_CAMERA, _COLOUR_CAMERA = "CALIBRATION_CameraLocationD0", "CALIBRATION_CameraLocationPV0"
_PARAMETERS = 14


# name of a mode -> size of the sensor image, pixels cropped at its left and top, size of the mode's image
_DEPTH_MODES = {
    "NFOV_2X2BINNED": ((512, 512), (96, 90), (320, 288)),
    "NFOV_UNBINNED": ((1024, 1024), (192, 180), (640, 576)),
    "WFOV_2X2BINNED": ((512, 512), (0, 0), (512, 512)),
    "WFOV_UNBINNED": ((1024, 1024), (0, 0), (1024, 1024)),
}
_COLOUR_MODES = {
    "720P": ((1280, 960), (0, 120), (1280, 720)),
    "1080P": ((1920, 1440), (0, 180), (1920, 1080)),
    "1440P": ((2560, 1920), (0, 240), (2560, 1440)),
    "1536P": ((2048, 1536), (0, 0), (2048, 1536)),
    "2160P": ((3840, 2880), (0, 360), (3840, 2160)),
    "3072P": ((4096, 3072), (0, 0), (4096, 3072)),
}


def cameras_of(content: bytes, depth_mode: str, colour_mode: str) -> Cameras:
    """The cameras of a recording.

    Parameters
    ----------
    content : bytes
        Content of calibration.json.
    depth_mode, colour_mode : str
        As stored in the recording's tracks, such as "NFOV_UNBINNED" and "MJPG_720P".

    Raises
    ------
    FormatError
        If a mode or the model of a lens is unknown; any other error if the calibration is damaged.
    """
    resolution = colour_mode.rpartition("_")[2]
    for what, mode, known in (("depth", depth_mode, _DEPTH_MODES), ("colour", resolution, _COLOUR_MODES)):
        if mode not in known:
            raise FormatError(f"the {what} mode {mode!r:.40} is unknown; known are {', '.join(known)}.")
    data = json.loads(content.rstrip(b"\0"))
    listed = Section("calibration", data).section("CalibrationInformation").get("Cameras", list[dict[str, Any]])
    by_place = {camera.get("Location"): Section("camera", camera) for camera in listed}
    depth, colour = by_place[_DEPTH_CAMERA], by_place[_COLOUR_CAMERA]
    return Cameras(
        _camera(colour, *_COLOUR_MODES[resolution]),
        _camera(depth, *_DEPTH_MODES[depth_mode]),
        _motion(colour) @ np.linalg.inv(_motion(depth)),
    )


def _camera(section: Section, whole: tuple[int, int], cut: tuple[int, int], size: tuple[int, int]) -> Camera:
    """The camera of a mode. The file's numbers are fractions of the full sensor's width and height."""
    values = section.section("Intrinsics").get("ModelParameters", list[float])
    if len(values) != _PARAMETERS:
        raise FormatError(f"a camera has {len(values)} parameters instead of {_PARAMETERS}.")
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, centre_x, centre_y, p2, p1 = values
    if centre_x or centre_y:
        raise FormatError("a camera has a separate distortion centre, which is not supported.")
    (width, height), (left, top) = whole, cut
    numbers = fx * width, fy * height, cx * width - left - 0.5, cy * height - top - 0.5
    return Camera(*numbers, size=size, distortion=(k1, k2, p1, p2, k3, k4, k5, k6))


def _motion(section: Section) -> NDArray[Any]:
    """The transform of points [m] to a camera, (4, 4)."""
    place = section.section("Rt")
    return rigid_transform(place.get("Rotation", list[float]), place.get("Translation", list[float]))


_COLOUR_TRACK, _DEPTH_TRACK, _INFRARED_TRACK = "K4A_COLOR_TRACK", "K4A_DEPTH_TRACK", "K4A_IR_TRACK"
_CALIBRATION = "K4A_CALIBRATION_FILE"
_PER_SECOND = 1_000_000


class AzureKinect(PairedRecording):
    """A recording of k4arecorder or a compatible program. A frame is a colour image with the depth image nearest in
    time; its key is the device time of the colour image."""

    kind = "a recording of an Azure Kinect"
    suffixes = (".mkv",)
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        av = optional("av", "ilf-studio[sensors]", "A recording of an Azure Kinect")
        self._container = av.open(str(path), format="matroska")  # a list names other files
        self._colour, self._depth = self._needed_track(_COLOUR_TRACK), self._needed_track(_DEPTH_TRACK)
        if _has_8_bits(self._depth.codec_context):
            raise eight_bit_error(path)
        self._infrared = self._track(_INFRARED_TRACK)

    def close(self) -> None:
        self._container.close()

    @cached_property
    def pairs(self) -> TimedPairs[int]:  # type: ignore[override]
        stamps: dict[int, list[int]] = {self._colour.index: [], self._depth.index: []}
        for packet in self._from(None, self._colour, self._depth):
            stamps[packet.stream.index].append(_stamp(packet))
        return TimedPairs(*(stamped(some, _PER_SECOND) for some in stamps.values()))

    def frame(self, key: str) -> RecordedFrame:
        colour_stamp, depth_stamp = self.at(key)
        colour, depth = self._packet(self._colour, colour_stamp), self._packet(self._depth, depth_stamp)
        return RecordedFrame(
            self._decoded(colour),
            self._values(depth),
            sha256_of(bytes(colour)),
            sha256_of(bytes(depth)),
            1000.0,
            time=colour_stamp / _PER_SECOND,
            depth_view=self._illuminated(depth_stamp),
        )

    def _values(self, packet: Any) -> NDArray[np.uint16]:
        """Values of a depth or infrared packet."""
        width, height = packet.stream.codec_context.width, packet.stream.codec_context.height
        data = bytes(packet)
        if len(data) != 2 * width * height:
            raise FormatError(f"{self.path}: an image has {len(data)} bytes instead of {2 * width * height}.")
        return np.frombuffer(data, ">u2").reshape(height, width).astype(np.uint16)

    def _illuminated(self, stamp: int) -> NDArray[np.bool_] | None:
        """Pixels that the depth camera's light source illuminates, a hexagon or a circle. It cannot measure others, and
        the infrared image is black there. None without an infrared image."""
        packet = None if self._infrared is None else self._find(self._infrared, stamp)
        if packet is None:
            return None
        infrared = self._values(packet)
        points = np.argwhere(infrared)[:, ::-1].astype(np.int32)
        lit = np.zeros(infrared.shape, np.uint8)
        if len(points):
            cv2.fillConvexPoly(lit, cv2.convexHull(points), 1)
        return lit.astype(bool)

    def cameras(self, key: str) -> Cameras:
        attached = [one for one in self._container.streams.attachments if _CALIBRATION in one.metadata]
        if not attached:
            raise FormatError(f"{self.path}: the recording contains no calibration. Record it again.")
        depth_mode, colour_mode = (
            track.metadata.get(name, "")
            for track, name in ((self._depth, "K4A_DEPTH_MODE"), (self._colour, "K4A_COLOR_MODE"))
        )
        with told_as(FormatError, f"{self.path}: {{error}}", FormatError):
            return cameras_of(attached[0].data, depth_mode, colour_mode)

    def _needed_track(self, tag: str) -> Any:
        found = self._track(tag)
        if found is None:
            what = "colour" if tag == _COLOUR_TRACK else "depth"
            raise FormatError(
                f"{self.path} has no {what} track of an Azure Kinect or Femto camera. Give its recording."
            )
        check_memory(self.path, found.codec_context.width, found.codec_context.height)
        return found

    def _track(self, tag: str) -> Any:
        """The track with a tag and a known image format; None if there is none."""
        videos = (stream for stream in self._container.streams.video if stream.codec_context is not None)
        return next((stream for stream in videos if tag in stream.metadata), None)

    def _packet(self, track: Any, stamp: int) -> Any:
        """The packet of a track with a stamp that the index contains."""
        found = self._find(track, stamp)
        if found is None:
            raise FormatError(f"{self.path}: an image of the index is missing. The recording is damaged.")
        return found

    def _find(self, track: Any, stamp: int) -> Any:
        """The packet of a track with a stamp; None if there is none."""
        packets = takewhile(lambda packet: _stamp(packet) <= stamp, self._from(stamp, track))
        return next((packet for packet in packets if _stamp(packet) == stamp), None)

    def _from(self, stamp: int | None, *tracks: Any) -> Iterator[Any]:
        """Packets that are not empty, from at or slightly before a stamp, or from the start."""
        self._container.seek(0 if stamp is None else stamp, backward=True)
        for packet in self._container.demux(*tracks):
            if packet.size and packet.pts is not None:
                yield packet

    def _decoded(self, packet: Any) -> NDArray[np.uint8]:
        """Colour image of a packet, RGB."""
        if self._colour.codec_context.name == "mjpeg":
            return read_colour(part_of(str(self.path), bytes(packet)))
        return np.ascontiguousarray(packet.decode()[0].to_ndarray(format="rgb24"))


def _has_8_bits(codec: Any) -> bool:
    """Whether a track has pixels of 8 bits; raw ones of 16 bits may be of any format of that size."""
    is_raw, pixels = codec.name == "rawvideo", codec.format
    return pixels is not None and (pixels.name == "gray" if is_raw else pixels.components[0].bits <= 8)


def _stamp(packet: Any) -> int:
    """Time of a packet [microseconds]."""
    return round(packet.pts * packet.time_base * _PER_SECOND)
