"""Real frames to train on: registered colour and measured depth, whose licences allow it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import read_json
from ...sources.frames import META_NAME
from ..bench.frames import load_bench_frame

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
    """Read a frame folder as the bench does, without values that most likely mark missing depth.

    Raises
    ------
    InputError, FormatError
        If it cannot be read.
    """
    frame = load_bench_frame(folder).frame
    if not read_json(folder / META_NAME).get("rendered"):
        return RealFrame(frame.rgb, frame.depth)
    return RealFrame(frame.rgb, np.where(frame.known, frame.depth, np.float32(SKY)))
