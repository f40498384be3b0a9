"""Recordings of an Azure Kinect, written small in the layout of k4arecorder."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np

from tests.ilf.bags import COLOUR

SIZE = {"NFOV_2X2BINNED": (320, 288), "NFOV_UNBINNED": (640, 576)}
_MILLISECOND = Fraction(1, 1000)
_RAW = {"NV12": "nv12", "YUY2": "yuyv422", "BGRA": "bgra"}


def calibration() -> dict[str, Any]:
    """Two cameras of a little distortion, the colour camera 32 mm to the side."""

    def camera(place: str, values: list[float], shift: list[float]) -> dict[str, Any]:
        return {
            "Location": f"CALIBRATION_CameraLocation{place}",
            "Intrinsics": {"ModelParameterCount": 14, "ModelParameters": values},
            "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": shift},
        }

    depth = [0.51, 0.52, 0.49, 0.5, 0.01, 0.002, 0.003, 0.004, 0.005, 0.006, 0, 0, 2e-4, 1e-4]
    colour = [0.5, 0.5, 0.48, 0.64, 0.02, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    return {
        "CalibrationInformation": {"Cameras": [camera("D0", depth, [0, 0, 0]), camera("PV0", colour, [-0.032, 0, 0])]}
    }


def write_azure(
    path: Path,
    frames: int = 3,
    colour: str = "MJPG",
    depth_mode: str = "NFOV_2X2BINNED",
    attached: bytes | None = None,
    depth_tag: str = "K4A_DEPTH_TRACK",
    depth_pixels: str = "gray16be",  # or "gray"
) -> Path:
    """Write 720p colour and depth, 30 frames a second, with the depth 2 ms after its colour; returns the path.

    The depth of frame n is 1000 + n mm, with nothing in its upper half.
    """
    content = json.dumps(calibration()).encode() if attached is None else attached
    with av.open(str(path), "w", options={"allow_raw_vfw": "1"}) as out:
        pixels = _RAW.get(colour, "yuvj420p")
        first = out.add_stream("mjpeg" if colour == "MJPG" else "rawvideo", rate=30)
        first.width, first.height, first.pix_fmt = 1280, 720, pixels
        first.metadata.update({"K4A_COLOR_TRACK": "1", "K4A_COLOR_MODE": f"{colour}_720P"})
        second = out.add_stream("rawvideo", rate=30)
        (second.width, second.height), second.pix_fmt = SIZE[depth_mode], depth_pixels
        second.metadata.update({depth_tag: "2", "K4A_DEPTH_MODE": depth_mode})
        for stream in (first, second):
            stream.time_base = stream.codec_context.time_base = _MILLISECOND
        if content:
            attachment = out.add_attachment("calibration.json", "application/octet-stream", content)
            attachment.metadata["K4A_CALIBRATION_FILE"] = "calibration.json"
        image = cv2.resize(COLOUR, (1280, 720), interpolation=cv2.INTER_LINEAR)
        for number in range(frames):
            stamp = 100 + number * 33
            picture = av.VideoFrame.from_ndarray(image, "rgb24").reformat(format=pixels)
            depth = np.full((second.height, second.width), 1000 + number, np.uint16)
            depth[: second.height // 2] = 0
            values = av.VideoFrame.from_ndarray(
                depth.astype(np.uint8) if depth_pixels == "gray" else depth, depth_pixels
            )
            for stream, shown, time in ((first, picture, stamp), (second, values, stamp + 2)):
                shown.pts, shown.time_base = time, _MILLISECOND
                out.mux(stream.encode(shown))
        for stream in (first, second):
            out.mux(stream.encode())
    return path
