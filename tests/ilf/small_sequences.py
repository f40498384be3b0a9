"""A small sequence: a camera that moves past a wavy, coloured wall whose depth is known exactly."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf

SHAPE = 60, 80
CAMERA = ilf.Camera(80.0, 76.0, 41.3, 27.8)
CAMERA_TEXT = "80,76,41.3,27.8"


def pose_of(number: float) -> NDArray[np.float64]:
    """Camera to world: 3 cm to the right, 4 mm down and 6 mm on, and half a degree to the left and 0.1 up, a frame."""
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.radians([0.1 * number, -0.5 * number, 0.0]))[0]
    pose[:3, 3] = 0.03 * number, 0.004 * number, 0.006 * number
    return pose


def exact_view(pose: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Colour and exact depth [m] from a pose."""
    rows, columns = np.indices(SHAPE)
    rays = CAMERA.points(columns, rows, np.ones(SHAPE)) @ pose[:3, :3].T
    depth = np.full(SHAPE, 2.0)
    for _ in range(40):  # to the fixed point of the wall z = 2 + 0.1 sin(2 x) cos(3 y)
        x, y, _ = np.moveaxis(pose[:3, 3] + rays * depth[..., None], -1, 0)
        depth = (2 + 0.1 * np.sin(2 * x) * np.cos(3 * y) - pose[2, 3]) / rays[..., 2]
    rgb = np.stack([128 + 90 * np.sin(a * x + b * y) for a, b in ((5, 2), (-3, 6), (4, -5))], axis=-1)
    return rgb.astype(np.uint8), depth.astype(np.float32)


def sequence(count: int = 5) -> list[ilf.RGBDFrame]:
    """Frames with poses, each with a hole of 12 x 16 pixels at a place of its own."""
    frames = []
    for number in range(count):
        rgb, depth = exact_view(pose_of(number))
        depth[10 + 8 * number : 22 + 8 * number, 20:36] = np.nan
        frames.append(ilf.RGBDFrame(rgb, depth, CAMERA, f"frame {number}", pose=pose_of(number)))
    return frames


def write_sequence(folder: Path, count: int = 5, poses: bool = True) -> Path:
    """Write it in the layout of 7-Scenes, with depth in millimetres."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, frame in enumerate(sequence(count)):
        name = f"frame-{number:06}"
        cv2.imwrite(str(folder / f"{name}.color.png"), frame.rgb[..., ::-1])
        cv2.imwrite(str(folder / f"{name}.depth.png"), np.nan_to_num(frame.depth * 1000).astype(np.uint16))
        if poses:
            np.savetxt(folder / f"{name}.pose.txt", frame.pose)
    return folder
