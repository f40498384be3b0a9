"""Generated pictures for training: a folder that may grow during training, and samples from it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.pixel_grids import Pairs, different_labels, mark, sides
from ilf.errors import InputError
from ilf.segmentation.edges.detectors import depth_features, filled_log_depth

from .hiding import hide

Array = NDArray[np.float32]

HELD_OUT = 40
"""Pictures with lower numbers are held out."""

LISTING_LASTS_S = 60.0
"""Time after which a folder is listed again."""

DETAILS = 0.3
"""Share of the samples that show a quarter of a picture at twice its size."""

_SMOOTH = 0.01
"""Maximum difference of interpolated depth on one surface, as a share of depth."""

_APART = 0.015
"""Minimum difference of log depth that separates marked neighbours of the same part."""


@dataclass(frozen=True, eq=False)
class Picture:
    """One generated picture.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    exact, measured : ndarray of float32, shape (H, W)
        Depth [m]; NaN = no surface, or missing.
    part : ndarray of int32, shape (H, W)
        Number of the visible smooth surface.
    thing : ndarray of int32, shape (H, W)
        Number of the visible object, wall, floor or the like.
    lines : ndarray of uint8, shape (H, W, 2)
        1 on jumps and on creases.
    """

    rgb: NDArray[np.uint8]
    exact: Array
    measured: Array
    part: NDArray[np.int32]
    thing: NDArray[np.int32]
    lines: NDArray[np.uint8]

    @property
    def mirrored(self) -> Picture:
        """The picture mirrored left to right."""
        return self._changed(
            lambda values: np.ascontiguousarray(values[:, ::-1]),
            lambda depth: np.ascontiguousarray(depth[:, ::-1]),
            lambda right, below: (right[:, ::-1], below[:, ::-1]),
        )

    @property
    def upside_down(self) -> Picture:
        """The picture mirrored top to bottom."""
        return self._changed(
            lambda values: np.ascontiguousarray(values[::-1]),
            lambda depth: np.ascontiguousarray(depth[::-1]),
            lambda right, below: (right[::-1], below[::-1]),
        )

    def detail(self, top: int, left: int) -> Picture:
        """A quarter of the picture from a corner, at twice its size and as soft as a frame of a larger sensor."""
        rows, columns = (
            slice(start, start + size // 2) for start, size in zip((top, left), self.part.shape, strict=True)
        )
        return self.window(rows, columns).enlarged

    def window(self, rows: slice, columns: slice) -> Picture:
        """A part of the picture."""
        return self._changed(
            lambda values: values[rows, columns],
            lambda depth: depth[rows, columns],
            lambda right, below: (
                right[rows, columns.start : columns.stop - 1],
                below[rows.start : rows.stop - 1, columns],
            ),
        )

    @property
    def enlarged(self) -> Picture:
        """The picture at twice its size."""
        soft = np.asarray(cv2.resize(self.rgb, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR), np.uint8)
        return replace(self._changed(_twice, _twice_the_depth, _twice_the_pairs), rgb=soft)

    @property
    def borders(self) -> NDArray[np.uint8]:
        """1 on jumps and between things, uint8 (H, W)."""
        return (mark(different_labels(self.thing)) | (self.lines[..., 0] > 0)).view(np.uint8)

    def _changed(
        self,
        change: Callable[[NDArray[Any]], NDArray[Any]],
        of_depth: Callable[[Array], Array],
        of_pairs: Callable[[NDArray[np.bool_], NDArray[np.bool_]], Pairs],
    ) -> Picture:
        """The picture with all its arrays changed, depth and lines in their own ways; lines are marked anew, because
        they mark the left or upper pixel of a pair."""
        return Picture(
            change(self.rgb),
            of_depth(self.exact),
            of_depth(self.measured),
            change(self.part),
            change(self.thing),
            self._lines_of(of_pairs),
        )

    def _lines_of(self, change: Callable[[NDArray[np.bool_], NDArray[np.bool_]], Pairs]) -> NDArray[np.uint8]:
        """Lines of the changed pairs of neighbours, given a change of the pairs that are marked now."""
        apart = _apart(self.part, self.exact)
        changed = []
        for line in (self.lines[..., k] > 0 for k in range(2)):
            changed.append(mark(change(line[:, :-1] & apart[0], line[:-1] & apart[1])))
        return np.stack(changed, axis=2).view(np.uint8)


class PictureFolder:
    """Pictures `<number>.npz` in a folder, which may grow while they are used.

    Attributes
    ----------
    learnt, held_out : list of Path
        Sorted by number; numbers below `HELD_OUT` are held out, all others are for training.
    """

    KIND, NAMES = "pictures", "<number>.npz"
    """Kind and names of the files, for error messages."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.relist()
        if not self.learnt or not self.held_out:
            raise InputError(
                f"{folder} has not enough {self.KIND} for training. Add files {self.NAMES} with numbers below "
                f"{HELD_OUT}, which are held out, and others from {HELD_OUT} on."
            )

    def refresh(self) -> None:
        """List the folder again if the last time is long ago."""
        if time.monotonic() > self._listed + LISTING_LASTS_S:
            self.relist()

    def relist(self) -> None:
        """List the folder again."""
        self._listed = time.monotonic()
        named = ((self.number_in(path.stem), path) for path in self.folder.glob("*.npz"))
        numbered = sorted((int(number), path) for number, path in named if number.isdigit())
        self.held_out = [path for number, path in numbered if number < HELD_OUT]
        self.learnt = [path for number, path in numbered if number >= HELD_OUT]

    @staticmethod
    def number_in(name: str) -> str:
        """The number in a file's name; files without a number are ignored."""
        return name


def read_picture(path: Path) -> Picture:
    """Read a picture; raise InputError if the file is not one."""
    try:
        with np.load(path) as file:
            lines = np.stack([file["jump"], file["crease"]], axis=2)
            exact, measured = (np.asarray(file[name], np.float32) for name in ("exact", "measured"))
            return Picture(file["rgb"], exact, measured, file["part"], file["object"], lines)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} is not a generated picture. Make it again.") from error


def _apart(part: NDArray[np.int32], exact: Array) -> Pairs:
    """Neighbours on different surfaces, or with a large difference of depth."""
    log_depth = np.nan_to_num(np.log(exact), nan=10)
    right, below = (
        (one != other) | (np.abs(near - far) > _APART)
        for (one, other), (near, far) in zip(sides(part), sides(log_depth), strict=True)
    )
    return right, below


def _twice(values: NDArray[Any]) -> NDArray[Any]:
    return np.repeat(np.repeat(values, 2, axis=0), 2, axis=1)


def _twice_the_depth(depth: Array) -> Array:
    """Enlarge depth by interpolation on surfaces, but not across jumps or where depth is missing."""
    blocks = _twice(depth)
    smooth = cv2.resize(depth, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR)
    return np.where(np.abs(smooth - blocks) <= _SMOOTH * blocks, smooth, blocks)


def _twice_the_pairs(right: NDArray[np.bool_], below: NDArray[np.bool_]) -> Pairs:
    """Pairs in the enlarged picture, between its groups of 2 x 2 pixels."""
    height, width = below.shape[0] + 1, right.shape[1] + 1
    across, down = np.zeros((2 * height, 2 * width - 1), bool), np.zeros((2 * height - 1, 2 * width), bool)
    across[:, 1::2] = np.repeat(right, 2, axis=0)
    down[1::2] = np.repeat(below, 2, axis=1)
    return across, down


def random_sample(picture: Picture, rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """Make a sample: a picture, at random mirrored or reduced to a detail, changed in colour, with depth hidden.

    The features do not depend on the scale of depth, so it is not changed.

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
    if rng.random() < DETAILS:
        picture = picture.detail(*(int(rng.integers(size // 2 + 1)) for size in picture.part.shape))
    return sample_of(picture, random_colour(picture.rgb, rng), with_hidden_depth(picture, rng))


def with_hidden_depth(picture: Picture, rng: np.random.Generator) -> Array:
    """The picture's measured depth, partly hidden."""
    return np.where(hide(picture.measured, picture.part, rng), np.float32(np.nan), picture.measured)


def sample_of(picture: Picture, image: Array, depth: Array) -> tuple[Array, Array, Array, Array]:
    """Make a sample as in `random_sample`, from a picture with given colours and known depth."""
    median = filled_log_depth(depth)[1] if np.isfinite(depth).any() else 0
    log_depth = np.log(picture.exact) - np.float32(median)
    features = np.ascontiguousarray(np.moveaxis(depth_features(depth), 0, 2))
    return image, features, picture.lines.astype(np.float32), log_depth[..., None]


def random_colour(rgb: NDArray[np.uint8], rng: np.random.Generator) -> Array:
    """Change colours as by other light and another camera, in [0, 1]."""
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
