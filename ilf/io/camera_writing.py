"""Files with the camera of an image, for other programs; `--intrinsics` reads them, too."""

from __future__ import annotations

import json

import cv2
import numpy as np
import yaml

from ..data.camera import Camera


def camera_json(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) as JSON: by names, and as Open3D reads it."""
    columns = [camera.fx, 0.0, 0.0, 0.0, camera.fy, 0.0, camera.cx, camera.cy, 1.0]
    numbers = dict(zip(("fx", "fy", "cx", "cy"), camera.numbers, strict=True))
    content = {"width": shape[1], "height": shape[0], **numbers, "intrinsic_matrix": columns}
    return f"{json.dumps(content, indent=1)}\n".encode()


def opencv_yaml(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) for OpenCV's FileStorage, with the names of its calibration program."""
    storage = cv2.FileStorage(".yaml", cv2.FileStorage_WRITE | cv2.FileStorage_MEMORY)
    storage.write("image_width", shape[1])
    storage.write("image_height", shape[0])
    storage.write("camera_matrix", camera.matrix)
    storage.write("distortion_coefficients", np.zeros((1, 5)))
    return str(storage.releaseAndGetString()).encode()


def camera_info_yaml(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) as ROS's camera_info_manager reads it."""

    def matrix(values: np.ndarray) -> dict[str, object]:
        return {"rows": values.shape[0], "cols": values.shape[1], "data": values.ravel().tolist()}

    content = {
        "image_width": shape[1],
        "image_height": shape[0],
        "camera_name": "camera",
        "camera_matrix": matrix(camera.matrix),
        "distortion_model": "plumb_bob",
        "distortion_coefficients": matrix(np.zeros((1, 5))),
        "rectification_matrix": matrix(np.eye(3)),
        "projection_matrix": matrix(np.column_stack((camera.matrix, np.zeros(3)))),
    }
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None).encode()
