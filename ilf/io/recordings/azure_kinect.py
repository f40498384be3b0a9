"""Recordings of Azure Kinect and Femto cameras (.mkv), read by PyAV."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError
from ...extras import optional
from ..files import FileContent
from ..images import check_pixel_count, read_colour
from ..time_lists import MOST_APART_S
from .azure_calibration import cameras_of
from .recording import Cameras, RecordedFrame, Recording, RecordingIndex, Topics, sha256_of
from .stamps import StampedPairs

_COLOUR, _DEPTH, _CALIBRATION = "K4A_COLOR_TRACK", "K4A_DEPTH_TRACK", "K4A_CALIBRATION_FILE"
_PER_SECOND = 1_000_000


class AzureKinect(Recording):
    """A recording of k4arecorder, or of what writes the same: a frame is a colour image with the depth image that is
    nearest in time. A key is the device's time of the colour."""

    kind = "a recording of an Azure Kinect"
    suffixes = (".mkv",)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._av = optional("av", "sequences", "A recording of an Azure Kinect")
        with self._reading():
            self._container = self._av.open(str(path))
        self._colour, self._depth = self._track(_COLOUR), self._track(_DEPTH)
        self._paired: StampedPairs | None = None

    def close(self) -> None:
        self._container.close()

    def index(self, max_gap: float = MOST_APART_S, topics: Topics | None = None) -> RecordingIndex:
        return self._pairs().index(max_gap, self.path)

    def frame(self, key: str) -> RecordedFrame:
        stamps = self._stamps(key)
        colour, depth = self._packets(*stamps)
        width, height = self._depth.codec_context.width, self._depth.codec_context.height
        data = bytes(depth)
        if len(data) != 2 * width * height:
            raise FormatError(f"{self.path}: a depth image has {len(data)} bytes in place of {2 * width * height}.")
        values = np.frombuffer(data, ">u2").reshape(height, width).astype(np.uint16)
        rgb = self._decoded(colour)
        return RecordedFrame(
            rgb, values, sha256_of(bytes(colour)), sha256_of(data), 1000.0, time=stamps[0] / _PER_SECOND
        )

    def colour(self, key: str) -> NDArray[np.uint8]:
        return self._decoded(self._packets(self._stamps(key)[0])[0])

    def cameras(self, key: str) -> Cameras:
        attached = [one for one in self._container.streams.attachments if _CALIBRATION in one.metadata]
        if not attached:
            raise FormatError(f"{self.path}: the calibration that such a recording has is not in it. Record it again.")
        depth_mode, colour_mode = (
            track.metadata.get(name, "")
            for track, name in ((self._depth, "K4A_DEPTH_MODE"), (self._colour, "K4A_COLOR_MODE"))
        )
        try:
            return cameras_of(attached[0].data, depth_mode, colour_mode)
        except FormatError as error:
            raise FormatError(f"{self.path}: {error}") from error

    def _track(self, tag: str) -> Any:
        found = next((stream for stream in self._container.streams.video if tag in stream.metadata), None)
        if found is None:
            what = "colour" if tag == _COLOUR else "depth"
            raise FormatError(
                f"{self.path} has no {what} track of an Azure Kinect or Femto camera; other videos are not read."
            )
        check_pixel_count(self.path, found.codec_context.width, found.codec_context.height)
        return found

    def _pairs(self) -> StampedPairs:
        if self._paired is None:
            stamps: dict[int, list[int]] = {self._colour.index: [], self._depth.index: []}
            for packet in self._from(None):
                stamps[packet.stream.index].append(_stamp(packet))
            self._paired = StampedPairs(stamps[self._colour.index], stamps[self._depth.index], _PER_SECOND)
        return self._paired

    def _stamps(self, key: str) -> tuple[int, int]:
        stamps = self._pairs().find(key)
        if stamps is None:
            raise self.unknown(key)
        return stamps

    def _packets(self, colour: int, depth: int | None = None) -> list[Any]:
        """The packets of colour and depth with these stamps."""
        wanted = [(self._colour.index, colour), *([] if depth is None else [(self._depth.index, depth)])]
        found: dict[tuple[int, int], Any] = {}
        for packet in self._from(min(stamp for _, stamp in wanted)):
            name = packet.stream.index, _stamp(packet)
            if name in wanted:
                found[name] = packet
            if len(found) == len(wanted):
                return [found[name] for name in wanted]
        raise FormatError(f"{self.path}: an image that was there when it was listed is gone. It is damaged.")

    def _from(self, stamp: int | None) -> Iterator[Any]:
        """Packets of colour and depth that are not empty, from a stamp on or a little before, or from the start."""
        with self._reading():
            self._container.seek(0 if stamp is None else stamp, backward=True)
            for packet in self._container.demux(self._colour, self._depth):
                if packet.size and packet.pts is not None:
                    yield packet

    def _decoded(self, packet: Any) -> NDArray[np.uint8]:
        """Colour of a packet, red first."""
        if self._colour.codec_context.name == "mjpeg":
            return read_colour(FileContent(self.path, np.frombuffer(bytes(packet), np.uint8)))
        with self._reading():
            images = packet.decode()
            if images:
                return np.ascontiguousarray(images[0].to_ndarray(format="rgb24"))
        raise FormatError(f"{self.path}: a colour image cannot be decoded. It is damaged.")

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Whatever the library stumbles over becomes one FormatError."""
        try:
            yield
        except PermissionError as error:
            raise InputError(f"{self.path}: cannot be read ({error.strerror}). Check its permissions.") from error
        except (self._av.FFmpegError, ValueError, OverflowError) as error:
            raise FormatError(
                f"{self.path}: this recording is truncated, damaged or of a rare kind ({error!s:.120})."
            ) from error


def _stamp(packet: Any) -> int:
    """Time of a packet [microseconds]."""
    return round(packet.pts * packet.time_base * _PER_SECOND)
