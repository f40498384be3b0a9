"""What is hidden from the methods: the same pixels whenever frame name and seed are the same."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from ...errors import InputError
from ...evaluation.hold_out import HIDDEN_PATTERNS, frame_without, hidden_pixels
from .frames import BenchFrame

PATTERNS = HIDDEN_PATTERNS | {
    "truth": "the frame's own holes, where there is a measured or exact truth",
}
"""Name -> what it is."""


@dataclass(frozen=True, eq=False)
class Task:
    """What a method is given, and what it is scored on.

    Attributes
    ----------
    frame : RGBDFrame
        With the hidden depth removed.
    truth : ndarray of float32, shape (H, W)
        True depth [m].
    scored : ndarray of bool, shape (H, W)
        Pixels that are missing in `frame` and known in `truth`.
    """

    frame: RGBDFrame
    truth: NDArray[np.float32]
    scored: NDArray[np.bool_]

    @property
    def sha256(self) -> str:
        """Of the colour and depth that methods are given, the pixels that they are scored on, and the truth there."""
        digest = hashlib.sha256()
        for values in (self.frame.rgb, self.frame.depth, self.scored, self.truth[self.scored]):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()


def make_task(source: BenchFrame, pattern: str, seed: int = 0) -> Task:
    """Hide depth of a frame by a pattern.

    Parameters
    ----------
    source : BenchFrame
    pattern : str
        One of `PATTERNS`.
    seed : int
        Base seed, not negative; the pixels hidden follow from it, the pattern and the frame's name.

    Raises
    ------
    InputError
        If the pattern leaves nothing to score or nothing known, or is not known itself.
    """
    frame = source.frame
    if pattern == "truth":
        if source.truth is None:
            raise InputError("There is no measured or exact truth.")
        return _checked(Task(frame, source.truth, ~frame.known & np.isfinite(source.truth)))
    if pattern not in PATTERNS:
        raise InputError(f"There is no pattern {pattern!r}. Known: {', '.join(PATTERNS)}.")
    hidden = hidden_pixels(frame, pattern, seed)
    return _checked(Task(frame_without(frame, pattern, seed), frame.depth, hidden & frame.known))


def _checked(task: Task) -> Task:
    if not task.scored.any():
        raise InputError("There is no hidden pixel to score.")
    return task
