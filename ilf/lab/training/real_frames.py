"""Real frames to train on: registered colour and measured depth, whose licences allow it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

SKY = 100.0
"""Depth [m] of what a path-traced frame has no depth of: the sky, seen through doors and windows, too."""


@dataclass(frozen=True, eq=False)
class RealFrame:
    """A registered frame of a real sensor, or path traced.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    depth : ndarray of float32, shape (H, W)
        Measured or exact depth [m], NaN = missing; `SKY` where a path-traced frame has none.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


def read_real_frame(folder: Path) -> RealFrame:
    """Read a folder with `rgb.jpg` or `rgb.png`, `depth.png` and `meta.json`, which names `depth_units_per_m`.

    Raises
    ------
    InputError
        If it does not have these files.
    """
    try:
        meta = json.loads((folder / "meta.json").read_text())
        units = float(meta["depth_units_per_m"])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{folder} has no meta.json with depth_units_per_m. Name folders of such frames.") from error
    bgr = cv2.imread(str(next(folder.glob("rgb.*g"), folder / "rgb.jpg")))
    stored = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED)
    if bgr is None or stored is None:
        raise InputError(f"{folder} has no readable rgb.jpg or rgb.png, and depth.png.")
    missing = np.float32(SKY if meta.get("rendered") else np.nan)
    depth = np.where(stored > 0, stored / np.float32(units), missing).astype(np.float32)
    return RealFrame(np.ascontiguousarray(bgr[..., ::-1], np.uint8), depth)
