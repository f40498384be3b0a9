"""A small frame in files: two walls in different colours at different depths, each with a hole."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

import ilf
from ilf.segmentation.edges.frame_edges import FrameEdges, find_edges

CAMERA = "80,76,41.3,27.8"
QUICK = {"max_iterations": 25}


def write_small_frame(folder: Path) -> tuple[Path, Path]:
    """Write rgb.png and depth.png (16-bit millimetres), 80 x 60 pixels; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    rows, columns = np.mgrid[:60, :80]
    left = columns < 40
    colour = np.where(left[..., None], (40, 90, 200), (220, 200, 60)).astype(np.uint8)
    depth = np.where(left, 1500 + 4 * rows, 2600 + 3 * columns).astype(np.uint16)
    depth[20:34, 10:25] = 0
    depth[15:40, 55:66] = 0
    cv2.imwrite(str(folder / "rgb.png"), colour)
    cv2.imwrite(str(folder / "depth.png"), depth)
    return folder / "rgb.png", folder / "depth.png"


def without_edges(frame: ilf.RGBDFrame) -> FrameEdges:
    """Edges of a frame with none for the filter to see."""
    found = find_edges(frame, ilf.BlockParameters(detector="canny"))
    return replace(found, strength=np.zeros(frame.shape, np.float32))
