"""Real frames to train on: registered colour and measured depth, whose licences allow it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...evaluation.bench.frames import load_bench_frame


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
    """Read a frame folder as the bench does, without values that most likely mark missing depth.

    Raises
    ------
    InputError, FormatError
        If it cannot be read.
    """
    frame = load_bench_frame(folder).frame
    return RealFrame(frame.rgb, frame.depth)
