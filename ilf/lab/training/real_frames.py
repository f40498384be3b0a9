"""Real frames to train on: registered colour and measured depth, whose licences allow it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError


@dataclass(frozen=True, eq=False)
class RealFrame:
    """A registered frame of a real sensor.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    depth : ndarray of float32, shape (H, W)
        Measured depth [m], NaN = missing.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


def read_real_frame(folder: Path) -> RealFrame:
    """Read a folder with `rgb.jpg`, `depth.png` and `meta.json`, which names `depth_units_per_m`.

    Raises
    ------
    InputError
        If it does not have these files.
    """
    try:
        units = float(json.loads((folder / "meta.json").read_text())["depth_units_per_m"])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{folder} has no meta.json with depth_units_per_m. Name folders of such frames.") from error
    bgr = cv2.imread(str(folder / "rgb.jpg"))
    stored = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED)
    if bgr is None or stored is None:
        raise InputError(f"{folder} has no readable rgb.jpg and depth.png.")
    depth = np.where(stored > 0, stored / np.float32(units), np.float32(np.nan)).astype(np.float32)
    return RealFrame(np.ascontiguousarray(bgr[..., ::-1], np.uint8), depth)
