"""A RealSense camera that exists in software only: the device of the maker's library, with frames of the tests."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.ilf.bags import COLOUR, DEPTH, H, W


class SoftwareDevice:
    """A device of software with a depth and a colour camera, 15 mm apart."""

    def __init__(self, library: Any) -> None:
        self.library = library
        self.device = library.software_device()
        self.sensors = {name: self.device.add_sensor(name) for name in ("Stereo Module", "RGB Camera")}
        stereo, colour = self.sensors.values()
        stereo.add_read_only_option(library.option.depth_units, 0.001)
        self.depth_profile = stereo.add_video_stream(self._stream(library.stream.depth, library.format.z16, 2, 25.0))
        self.colour_profile = colour.add_video_stream(self._stream(library.stream.color, library.format.rgb8, 3, 30.0))
        motion = library.extrinsics()
        # a quarter of a degree about the viewing axis, column by column
        sine, cosine = math.sin(0.004), math.cos(0.004)
        motion.rotation, motion.translation = [cosine, sine, 0, -sine, cosine, 0, 0, 0, 1], [0.015, 0, 0]
        self.depth_profile.register_extrinsics_to(self.colour_profile, motion)
        self._kept: list[np.ndarray] = []

    def _stream(self, kind: Any, pixels: Any, size: int, focal: float) -> Any:
        seen = self.library.intrinsics()
        seen.width, seen.height, seen.fx, seen.fy, seen.ppx, seen.ppy = W, H, focal, focal, 15.5, 11.5
        seen.model, seen.coeffs = self.library.distortion.brown_conrady, [0.0] * 5
        stream = self.library.video_stream()
        stream.type, stream.index, stream.uid, stream.fps = kind, 0, size, 30
        stream.width, stream.height, stream.bpp, stream.fmt, stream.intrinsics = W, H, size, pixels, seen
        return stream

    def show(self, number: int) -> None:
        """Send a frame."""
        stereo, colour = self.sensors.values()
        for sensor, profile, pixels in (
            (stereo, self.depth_profile, DEPTH + np.uint16(number) * (DEPTH > 0)),
            (colour, self.colour_profile, COLOUR + np.uint8(number)),
        ):
            pixels = np.ascontiguousarray(pixels)
            self._kept.append(pixels)  # the library does not copy them
            frame = self.library.software_video_frame()
            frame.pixels, frame.bpp = pixels, pixels.nbytes // (W * H)
            frame.stride, frame.timestamp = W * frame.bpp, 33.0 * number
            frame.domain, frame.frame_number = self.library.timestamp_domain.system_time, number
            frame.profile = profile.as_video_stream_profile()
            if sensor is stereo:
                frame.depth_units = 0.001
            sensor.on_video_frame(frame)


class ConnectedDevice(SoftwareDevice):
    """A device of software whose frames come through the library's own synchroniser, one at each request.

    Parameters
    ----------
    library : module
    last : int, optional
        Number of frames after which the camera is lost.
    """

    def __init__(self, library: Any, last: int | None) -> None:
        super().__init__(library)
        self.device.create_matcher(library.matchers.default)
        self.running: list[Any] = []
        """Sensors that have been started."""
        self._last, self._shown, self._syncer = last, 0, library.syncer()

    def start(self, _wish: Any) -> None:
        """Start the sensors."""
        for sensor in self.sensors.values():
            sensor.open(sensor.get_stream_profiles())
            sensor.start(self._syncer)
            self.running.append(sensor)

    def wait_for_frames(self, patience: int) -> Any:
        """The next frame; once the camera is lost, the library raises its own error."""
        while True:
            if self._shown == self._last:
                return self._syncer.wait_for_frames(50)
            self.show(self._shown)
            self._shown += 1
            frames = self._syncer.wait_for_frames(patience)
            if frames.get_depth_frame() and frames.get_color_frame():
                return frames

    def stop(self) -> None:
        """Stop the sensors."""
        while self.running:
            sensor = self.running.pop()
            sensor.stop()
            sensor.close()


def connect(library: Any, monkeypatch: pytest.MonkeyPatch, last: int | None = None) -> ConnectedDevice:
    """Make a device of software the connected camera, until the test ends."""
    device = ConnectedDevice(library, last)
    monkeypatch.setattr(library, "pipeline", lambda: device)
    monkeypatch.setattr(library, "context", lambda: SimpleNamespace(query_devices=lambda: [device.device]))
    return device
