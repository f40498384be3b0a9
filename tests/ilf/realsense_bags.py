"""Recordings of RealSense cameras, written small: of the Viewer in ROS 1, and of newer libraries in ROS 2."""

import math
from pathlib import Path

import cv2
import numpy as np

from .bags import COLOUR, DEPTH, bag, compressed_depth, path_of, storage_of

STREAMS = {"depth": "/device_0/sensor_0/Depth_0", "colour": "/device_0/sensor_1/Color_0"}
SHIFTS = {"depth": (0.0, 0.0, 0.0), "colour": (0.015, 0.0, 0.0)}


def write_viewer_bag(
    folder: Path, units: float = 0.001, option: str = "Depth Units", name: str = "recording", silent: str = ""
) -> Path:
    """The Viewer's layout: one coordinate frame "0" for all, and transforms from a group of streams to each; that to a
    silent stream has a topic, and no message."""
    turn = (0.0, math.sin(0.01), 0.0, math.cos(0.01))
    with bag(folder, "ros1", name) as out:
        unit = out.make("std_msgs/msg/Float32", units)
        out.write(f"/device_0/sensor_0/option/{option}/value", unit, 0)
        for stream, shift in SHIFTS.items():
            out.info(f"{STREAMS[stream]}/info/camera_info")
            transform = out.transform(shift, turn)
            if stream == silent:
                out.announce(f"{STREAMS[stream]}/tf/0", transform)
            else:
                out.write(f"{STREAMS[stream]}/tf/0", transform, 0)
        for number in range(2):
            stamp = number * 33_000_000
            out.image(f"{STREAMS['depth']}/image/data", DEPTH, "mono16", stamp + 1_000_000, "0")
            out.image(f"{STREAMS['colour']}/image/data", COLOUR + np.uint8(number), "rgb8", stamp, "0")
            out.image("/device_0/sensor_0/Infrared_1/image/data", COLOUR[..., 0], "8UC1", stamp, "0")
    return path_of(folder, "ros1", name)


def write_library_db3(folder: Path, name: str = "recording") -> Path:
    """What the library has written since its version 2.59: units and much else as text, images compressed."""
    turn = (0.0, 0.0, math.sin(0.002), math.cos(0.002))
    with bag(folder, "sqlite3", name) as out:
        units = out.make("std_msgs/msg/String", "0.001000")
        out.write("/device_0/sensor_0/option/Depth_Units/value", units, 0)
        out.tf_static(*(("ref_1", stream.title(), shift, turn) for stream, shift in SHIFTS.items()))
        for stream in STREAMS.values():
            out.info(f"{stream}/image/camera_info")
        for number in range(2):
            stamp, colour = number * 33_000_000, COLOUR + np.uint8(number)
            packed = cv2.imencode(".png", colour[..., ::-1])[1].tobytes()
            out.compressed(
                f"{STREAMS['depth']}/image/data/compressedDepth",
                compressed_depth(DEPTH),
                "16UC1; compressedDepth png",
                stamp,
                "Depth",
            )
            out.compressed(
                f"{STREAMS['colour']}/image/data/compressed", packed, "rgb8; png compressed", stamp, "Colour"
            )
    return storage_of(folder, "sqlite3", name)
