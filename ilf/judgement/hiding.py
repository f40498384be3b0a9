"""Which known depth is hidden to see how well it comes back: the same pixels whenever frame and seed are the same."""

from __future__ import annotations

import hashlib
import math

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..per_frame import once_per_frame

RANDOM_KEPT = 0.4277
"""Share of the known depth that the pattern "random" keeps; that of the paper's Table 1."""

AREAS_HIDDEN = 0.25
"""Share of the known depth that the pattern "areas" hides."""

AREA_SEMI_AXES = (0.03, 0.12)
"""Shortest and longest semi-axis of its ellipses, in widths of the frame."""

HIDDEN_PATTERNS = {
    "random": f"{RANDOM_KEPT:.2%} of the known depth kept, pixel by pixel",
    "areas": f"{AREAS_HIDDEN:.0%} of the known depth hidden in ellipses",
}
"""Name -> what it is."""


def hidden_pixels(frame: RGBDFrame, pattern: str, seed: int = 0) -> NDArray[np.bool_]:
    """Pixels whose depth a pattern hides.

    Parameters
    ----------
    frame : RGBDFrame
        Its name and where depth was measured decide; which depth is distrusted does not.
    pattern : str
        One of `HIDDEN_PATTERNS`.
    seed : int
        Not negative.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Some of the pixels with measured depth.

    Raises
    ------
    InputError
        For another pattern.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> int(hidden_pixels(frame, "areas").sum()), int(hidden_pixels(frame, "random", seed=3).sum())
    (500, 1145)
    """
    if pattern not in HIDDEN_PATTERNS:
        raise InputError(f"There is no pattern {pattern!r}. Known: {', '.join(HIDDEN_PATTERNS)}.")
    return _hidden_pixels(frame, pattern, seed)


def frame_without(frame: RGBDFrame, pattern: str, seed: int = 0) -> RGBDFrame:
    """A frame of the same colour that has never had what a pattern hides, nor what is distrusted, nor a truth.

    Parameters
    ----------
    frame, pattern, seed
        As for `hidden_pixels`.

    Raises
    ------
    InputError
        If nothing would be left, or for another pattern.

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 50, 3), np.uint8), np.full((40, 50), 2.0))
    >>> frame_without(frame, "areas").missing_share
    0.25
    """
    return _frame_without(frame, pattern, seed)


@once_per_frame
def _hidden_pixels(frame: RGBDFrame, pattern: str, seed: int) -> NDArray[np.bool_]:
    measured = np.isfinite(frame.measured)
    rng = _generator(frame.name, pattern, seed)
    return _random(measured, rng) if pattern == "random" else _areas(measured, rng)


@once_per_frame
def _frame_without(frame: RGBDFrame, pattern: str, seed: int) -> RGBDFrame:
    """Once, so that its edges are found once for all that is run on it."""
    depth = np.where(hidden_pixels(frame, pattern, seed), np.float32(np.nan), frame.depth)
    if not np.isfinite(depth).any():
        raise InputError("Too little depth is known: all of it would be hidden.")
    return RGBDFrame(frame.rgb, depth, frame.intrinsics, frame.name, guide=frame.guide, outside_view=frame.outside_view)


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
