"""Hold-out patterns: the same pixels for the same frame name and seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from ...data.pixel_grids import drawn_from
from ...errors import InputError
from ..hold_out import HOLD_OUT_PATTERNS, frame_without, generator, hidden_pixels
from .frames import BenchFrame

POINTS, LINES = 500, 16
"""Number of known pixels that the pattern "points" keeps, and of rows that the pattern "lines" keeps."""

PATTERNS = HOLD_OUT_PATTERNS | {
    "ground-truth": "the frame's own holes, where a measured or exact ground truth exists",
    "points": f"{POINTS} of the known pixels kept",
    "lines": f"{LINES} rows of the frame kept, at equal distances, as of a lidar",
}
"""Name -> description."""


@dataclass(frozen=True, eq=False)
class Task:
    """Input of a method, and the pixels that it is scored on.

    Attributes
    ----------
    frame : RGBDFrame
        Without the held-out depth.
    ground_truth : ndarray of float32, shape (H, W)
        True depth [m].
    scored : ndarray of bool, shape (H, W)
        Pixels that are missing in `frame` and known in `ground_truth`.
    """

    frame: RGBDFrame
    ground_truth: NDArray[np.float32]
    scored: NDArray[np.bool_]


def make_task(source: BenchFrame, pattern: str, seed: int = 0) -> Task:
    """Hold out depth of a frame by a pattern.

    Parameters
    ----------
    source : BenchFrame
    pattern : str
        One of `PATTERNS`.
    seed : int
        Base seed, not negative; the held-out pixels depend on it, the pattern and the frame's name.

    Raises
    ------
    InputError
        If the pattern leaves no pixel to score or no known depth, or does not exist.
    """
    frame = source.frame
    if pattern not in PATTERNS:
        raise InputError(f"There is no pattern {pattern!r}. Known: {', '.join(PATTERNS)}.")
    if pattern == "ground-truth":
        if source.ground_truth is None:
            raise InputError("There is no measured or exact ground truth.")
        task = Task(frame, source.ground_truth, ~frame.known & np.isfinite(source.ground_truth))
    elif pattern in HOLD_OUT_PATTERNS:
        hidden = hidden_pixels(frame, pattern, seed)
        task = Task(frame_without(frame, pattern, seed), frame.depth, hidden & frame.known)
    else:
        rng = generator(frame.name, pattern, seed)
        kept = drawn_from(frame.known, rng, slice(POINTS)) if pattern == "points" else _lines(frame.known)
        if not kept.any():
            raise InputError(f"The pattern {pattern!r} leaves no known depth.")
        depth = np.where(kept, frame.depth, np.float32(np.nan))
        left = RGBDFrame(frame.rgb, depth, frame.intrinsics, frame.name, outside_view=frame.outside_view)
        task = Task(left, frame.depth, frame.known & ~kept)
    if not task.scored.any():
        raise InputError("There is no held-out pixel to score.")
    return task


def _lines(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    rows = ((np.arange(LINES) + 0.5) * len(known) / LINES).astype(int)
    kept = np.zeros_like(known)
    kept[rows] = known[rows]
    return kept
