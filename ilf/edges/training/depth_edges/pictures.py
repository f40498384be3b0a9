"""Generated pictures as they are learnt from: a folder that may grow while it is read, and samples of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ...depth_features import depth_features, filled_log_depth
from ...pairs import Pairs, mark, sides
from .hiding import hide

Array = NDArray[np.float32]

HELD_OUT = 40
"""Pictures of lower numbers are held out."""

_APART = 0.015
"""Difference of log depth from which on neighbours of a marked pair are apart, though of the same part."""


@dataclass(frozen=True, eq=False)
class Picture:
    """One generated picture.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    exact, measured : ndarray of float32, shape (H, W)
        Depth [m]; NaN = nothing there, or missing.
    part : ndarray of int32, shape (H, W)
        Which smooth surface is seen.
    lines : ndarray of uint8, shape (H, W, 2)
        1 on jumps and on creases.
    mirrored_lines : ndarray of uint8, shape (H, W, 2)
        Those of the mirrored picture, which are not the mirrored lines: a line marks the left or upper pixels.
    """

    rgb: NDArray[np.uint8]
    exact: Array
    measured: Array
    part: NDArray[np.int32]
    lines: NDArray[np.uint8]
    mirrored_lines: NDArray[np.uint8]

    @property
    def mirrored(self) -> Picture:
        """The picture as a mirror shows it."""
        return Picture(
            np.ascontiguousarray(self.rgb[:, ::-1]),
            np.ascontiguousarray(self.exact[:, ::-1]),
            np.ascontiguousarray(self.measured[:, ::-1]),
            np.ascontiguousarray(self.part[:, ::-1]),
            self.mirrored_lines,
            self.lines,
        )


class PictureFolder:
    """Pictures `<number>.npz` in a folder; those that appear later are found by `look_again`.

    Attributes
    ----------
    learnt, held_out : list of Picture
        In order of their numbers, those found later at the end.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.learnt: list[Picture] = []
        self.held_out: list[Picture] = []
        self._read: set[str] = set()
        self.look_again()
        if not self.learnt or not self.held_out:
            raise InputError(
                f"{folder} has no pictures to learn from: it needs files <number>.npz, some of numbers below "
                f"{HELD_OUT}, which are held out, and some above."
            )

    def look_again(self) -> None:
        """Read the pictures that are new in the folder."""
        new = [path for path in self.folder.glob("*.npz") if path.name not in self._read and path.stem.isdigit()]
        for path in sorted(new, key=lambda path: int(path.stem)):
            (self.held_out if int(path.stem) < HELD_OUT else self.learnt).append(read_picture(path))
            self._read.add(path.name)


def read_picture(path: Path) -> Picture:
    """The picture in a file; an InputError where it is none."""
    try:
        with np.load(path) as file:
            lines = np.stack([file["jump"], file["crease"]], axis=2)
            exact, measured = (np.asarray(file[name], np.float32) for name in ("exact", "measured"))
            part = file["part"]
            apart = _apart(part, exact)
            mirrored = np.stack([_mirrored(lines[..., k] > 0, apart) for k in range(2)], axis=2)
            return Picture(file["rgb"], exact, measured, part, lines, mirrored.astype(np.uint8))
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} is no generated picture. Make it again.") from error


def _apart(part: NDArray[np.int32], exact: Array) -> Pairs:
    """Neighbours of different surfaces, or of depths far apart."""
    log_depth = np.nan_to_num(np.log(exact), nan=10)
    right, below = (
        (one != other) | (np.abs(near - far) > _APART)
        for (one, other), (near, far) in zip(sides(part), sides(log_depth), strict=True)
    )
    return right, below


def _mirrored(line: NDArray[np.bool_], apart: Pairs) -> NDArray[np.bool_]:
    right, below = line[:, :-1] & apart[0], line[:-1] & apart[1]
    return mark((right[:, ::-1], below[:, ::-1]))


def random_sample(picture: Picture, rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """A picture, perhaps mirrored, changed in colour, and with more of its depth missing.

    The features know no scale of depth, so that none is changed.

    Returns
    -------
    image : ndarray of float32, shape (H, W, 3)
        In [0, 1].
    features : ndarray of float32, shape (H, W, 6)
    lines : ndarray of float32, shape (H, W, 2)
    log_depth : ndarray of float32, shape (H, W, 1)
        Exact, in the unit of the features, NaN where there is none.
    """
    if rng.random() < 0.5:
        picture = picture.mirrored
    return sample_of(picture, _random_colour(picture.rgb, rng), less_known(picture, rng))


def less_known(picture: Picture, rng: np.random.Generator) -> Array:
    """Its measured depth, of which some is hidden."""
    return np.where(hide(picture.measured, picture.part, rng), np.float32(np.nan), picture.measured)


def sample_of(picture: Picture, image: Array, depth: Array) -> tuple[Array, Array, Array, Array]:
    """A sample, as `random_sample` gives it, of a picture seen so and of which this depth is known."""
    median = filled_log_depth(depth)[1] if np.isfinite(depth).any() else 0
    log_depth = np.log(picture.exact) - np.float32(median)
    features = np.ascontiguousarray(np.moveaxis(depth_features(depth), 0, 2))
    return image, features, picture.lines.astype(np.float32), log_depth[..., None]


def _random_colour(rgb: NDArray[np.uint8], rng: np.random.Generator) -> Array:
    if rng.random() < 0.1:
        rgb = np.broadcast_to(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)[..., None], rgb.shape)
    levels = np.linspace(0, 1, 256, dtype=np.float32)[:, None]
    gains = rng.uniform(0.6, 1.4) * rng.uniform(0.85, 1.15, 3)
    curve = np.clip((levels - 0.5) * gains + 0.5 + rng.uniform(-0.12, 0.12), 0, 1) ** np.exp(rng.uniform(-0.4, 0.4))
    image = np.stack([curve[:, k].astype(np.float32)[rgb[..., k]] for k in range(3)], axis=2)
    if rng.random() < 0.2:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 1.2)), np.float32)
    if rng.random() < 0.4:
        image += np.float32(rng.uniform(0, 0.04)) * rng.standard_normal(image.shape, np.float32)
    return np.clip(image, 0, 1)
