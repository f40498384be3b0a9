"""A depth camera, drawn at random, in front of a path-traced frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scenes.sensing import sense

from ilf.data.frame import RGBDFrame
from ilf.data.surface import surface_normals

RENDERED = "rendered"
"""What the `sensor` of a path-traced frame begins with, in its meta.json."""


def simulated(frame: RGBDFrame, rng: np.random.Generator) -> NDArray[np.float32]:
    """What a depth camera measures of a frame with exact depth, in m, NaN = missing; its materials are not known."""
    camera = frame.intrinsics
    assert camera is not None
    nowhere = np.zeros(frame.shape, bool)
    flags = dict.fromkeys(("black", "glossy", "transparent", "emitting"), nowhere)
    normals = surface_normals(frame.depth, camera)
    behind = np.full(frame.shape, np.float32(np.nan))
    focal = (camera.fx, camera.fy, camera.cx, camera.cy)
    while True:
        measured = sense(frame.depth, normals, frame.rgb, flags, behind, nowhere, focal, rng)
        if np.isfinite(measured).any():
            return measured
