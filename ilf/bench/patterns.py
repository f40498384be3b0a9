"""What is hidden from the methods: the same pixels whenever frame name and seed are the same."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from .frames import BenchFrame

RANDOM_KEPT = 0.4277
"""Share of the known depth that the pattern "random" keeps; that of the paper's Table 1."""

AREAS_HIDDEN = 0.25
"""Share of the known depth that the pattern "areas" hides."""

AREA_SEMI_AXES = (0.03, 0.12)
"""Shortest and longest semi-axis of its ellipses, in widths of the frame."""

PATTERNS = {
    "random": f"{RANDOM_KEPT:.2%} of the known depth kept, pixel by pixel",
    "areas": f"{AREAS_HIDDEN:.0%} of the known depth hidden in ellipses",
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
    rng = _generator(frame.name, pattern, seed)
    hidden = _random(frame.known, rng) if pattern == "random" else _areas(frame.known, rng)
    depth = np.where(hidden, np.float32(np.nan), frame.depth)
    if not np.isfinite(depth).any():
        raise InputError("Too little depth is known: all of it would be hidden.")
    return _checked(Task(RGBDFrame(frame.rgb, depth, frame.intrinsics, frame.name), frame.depth, hidden))


def _checked(task: Task) -> Task:
    if not task.scored.any():
        raise InputError("There is no hidden pixel to score.")
    return task


def _generator(name: str, pattern: str, seed: int) -> np.random.Generator:
    digest = hashlib.sha256(f"{pattern}:{name}".encode()).digest()
    return np.random.default_rng([seed, *np.frombuffer(digest, "<u4").tolist()])


def _random(known: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
    places = np.flatnonzero(known)
    hidden = np.zeros(known.size, bool)
    hidden[rng.permutation(places)[round(RANDOM_KEPT * places.size) :]] = True
    return hidden.reshape(known.shape)


def _areas(known: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
    """Ellipses around known pixels; the last one is as small as the share asks for."""
    rows, columns = np.indices(known.shape, np.float32)
    visible = known.copy()
    left = round(AREAS_HIDDEN * np.count_nonzero(known))
    while left > 0:
        row, column = divmod(int(rng.choice(np.flatnonzero(visible))), known.shape[1])
        semi_axes = np.maximum(rng.uniform(*AREA_SEMI_AXES, 2) * known.shape[1], 1.0)
        angle = rng.uniform(0, math.pi)
        along = (columns - column) * math.cos(angle) + (rows - row) * math.sin(angle)
        across = (rows - row) * math.cos(angle) - (columns - column) * math.sin(angle)
        distance = (along / semi_axes[0]) ** 2 + (across / semi_axes[1]) ** 2
        inside = np.flatnonzero(visible & (distance <= 1))
        nearest = inside[np.argsort(distance.ravel()[inside], kind="stable")[:left]]
        visible.ravel()[nearest] = False
        left -= nearest.size
    return known & ~visible
