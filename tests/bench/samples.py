"""The bundled sample in any size, as a frame without cached results or as a folder."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf._runtime.installation import asset_path
from tests.pins.frames import write_frame

Size = tuple[int, int]


def size_of(text: str) -> Size:
    """Return width and height of "640x480"."""
    width, height = map(int, text.split("x"))
    return width, height


def scaled(size: Size, folder: str | Path | None = None) -> ilf.RGBDFrame:
    """Return a frame, by default the bundled sample, in another size."""
    frame = ilf.load_frame(folder or asset_path("samples/room"))
    width, height = size
    rgb = cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA)
    depth = cv2.resize(np.nan_to_num(frame.depth), size, interpolation=cv2.INTER_NEAREST)
    camera = ilf.Camera(0.8 * width, 0.8 * width, width / 2, height / 2)
    return ilf.RGBDFrame(rgb, depth, camera)


def write_sample(folder: Path, size: Size, number: int = 0) -> Path:
    """Write the bundled sample in another size as a frame folder of PNGs; the number varies it slightly."""
    frame = scaled(size)
    rgb = frame.rgb.copy()
    rgb[0, 0] = number % 256
    return write_frame(folder, replace(frame, rgb=rgb), units=1000)
