"""Samples to train the contour network on: generated pictures, and real frames whose measured depth shows jumps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ....data.parameters import BlockParameters
from ....data.pixel_grids import long_lines, mark
from ....segmentation.edges.relief import (
    JUMP_LENGTH,
    bend_of,
    filled_depth,
    find_relief,
    surrounded_by,
)
from ..depth_edges.pictures import Picture, random_colour, read_picture
from ..real_frames import RealFrame

Array = NDArray[np.float32]

SIDES = (224, 288)
"""Height and width of the samples."""

DETAILS, UPSIDE_DOWN = 0.1, 0.1
"""Shares of the generated pictures that show a quarter at twice its size, and that are upside down."""

JPEG_SHARE, JPEG_QUALITY = 0.3, (25, 90)
"""Share of the samples that are compressed, and range of the quality."""

SCALES = (0.4, 0.75)
"""Range of the scale of real frames: the network looks at images at half their size."""

SMOOTH_RADIUS = 6
"""Radius [px] around a pixel without jump, bend or missing depth, in which there is no contour in real frames."""

_ACROSS, _AROUND, _AT_JUMP = 1, 6, 0.7
"""At least the last share of the change of depth over twice the second distance [px] is at a jump, to the first one
from either side of it."""

_LEAST_BEND = 0.5
"""Bend (`Relief.bend`) from which there may be a line."""

_PART_OF_LINE, _ALL = 0.2, 0.99
"""Share of a line in a pixel of a smaller image from which the pixel is part of it, and share that means all of it."""

REAL = -1
"""Number of the object everywhere in samples of real frames, whose objects are not known."""


def generated_sample(path: Path, rng: np.random.Generator) -> tuple[Array, ...]:
    """Make a sample of a generated picture: at random a detail, mirrored, upside down, with changed colour.

    Returns
    -------
    See `sample_of`.
    """
    picture = read_picture(path)
    if rng.random() < DETAILS:
        picture = picture.detail(*(int(rng.integers(size // 2 + 1)) for size in picture.part.shape))
    if rng.random() < 0.5:
        picture = picture.mirrored
    if rng.random() < UPSIDE_DOWN:
        picture = picture.upside_down
    whole = sample_of(picture, compressed(random_colour(picture.rgb, rng), rng))
    window = _window(picture.part.shape, rng)
    return tuple(np.ascontiguousarray(one[window]) for one in whole)


def sample_of(picture: Picture, image: Array) -> tuple[Array, ...]:
    """Make a sample of a generated picture with given colours.

    Returns
    -------
    image : ndarray of float32, shape (H, W, 3)
        In [0, 1].
    lines : ndarray of float32, shape (H, W, 3)
        1 on jumps, creases and borders.
    none : ndarray of float32, shape (H, W, 1)
        1 where there is certainly no line.
    thing : ndarray of float32, shape (H, W, 1)
        Number of the object; `REAL` in real frames.
    """
    lines = np.dstack([picture.lines, picture.borders]).astype(np.float32)
    return image, lines, (1 - lines.max(2))[..., None], picture.thing[..., None].astype(np.float32)


def real_sample(frame: MeasuredLines, rng: np.random.Generator) -> tuple[Array, ...]:
    """Make a sample of a real frame: a detail at random scale, mirrored, with changed colour; jumps of its measured
    depth are its lines, and smooth surfaces have none.

    Returns
    -------
    See `sample_of`.
    """
    least = max(side / whole for side, whole in zip(SIDES, frame.lines.shape, strict=True))
    scale = max(rng.uniform(*SCALES), least + 0.01)
    size = tuple(round(side * scale) for side in reversed(frame.lines.shape))
    scaled = (cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in (frame.rgb, frame.lines, frame.none))
    window = _window(size[::-1], rng)
    step = -1 if rng.random() < 0.5 else 1
    rgb, lines, none = (np.ascontiguousarray(one[window][:, ::step]) for one in scaled)
    of_sample = np.zeros((*SIDES, 3), np.float32)
    of_sample[..., 0] = of_sample[..., 2] = lines > _PART_OF_LINE
    image = compressed(random_colour(rgb.astype(np.uint8), rng), rng)
    return image, of_sample, (none > _ALL).astype(np.float32)[..., None], np.full((*SIDES, 1), REAL, np.float32)


@dataclass(frozen=True, eq=False)
class MeasuredLines:
    """What measured depth tells of a frame's lines: colour, jumps as lines 1 px wide, and where there is certainly no
    line; float32 (H, W) of 0 and 1 each.
    """

    rgb: NDArray[np.uint8]
    lines: Array
    none: Array


def measured_lines(frame: RealFrame) -> MeasuredLines:
    """Find the jumps of a frame's measured depth, and its smooth surfaces. Steps of a surface that recedes, which a
    sensor's depth has, too, are no jumps: there the depth changes all around."""
    defaults = BlockParameters()
    filled = filled_depth(frame.depth)
    relief = find_relief(frame.depth, defaults.depth_jump, defaults.depth_jump_share)
    right, below = (
        jump & (_change(filled, axis, _ACROSS) > _AT_JUMP * _change(filled, axis, _AROUND))
        for axis, jump in zip((1, 0), relief.all_jumps, strict=True)
    )
    lines = mark(long_lines((right, below), JUMP_LENGTH))
    smooth = surrounded_by(relief.near & ~lines) & (bend_of(filled) <= _LEAST_BEND)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * SMOOTH_RADIUS + 1,) * 2)
    none = cv2.dilate((~smooth).view(np.uint8), around) == 0
    return MeasuredLines(frame.rgb, lines.astype(np.float32), none.astype(np.float32))


def _change(depth: Array, axis: int, reach: int) -> Array:
    """Change of depth from `reach` px before a pair of neighbours to `reach` px behind it, for each pair."""
    padded = np.pad(depth, [(reach, reach) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
    count = padded.shape[axis] - 2 * reach - 1
    before, behind = (np.take(padded, np.arange(start, start + count), axis) for start in (0, 2 * reach + 1))
    return np.asarray(np.abs(behind - before), np.float32)


def _window(shape: tuple[int, ...], rng: np.random.Generator) -> tuple[slice, slice]:
    """A window of `SIDES` in an image, at random; all of a smaller one."""
    top, left = (int(rng.integers(max(whole - side, 0) + 1)) for whole, side in zip(shape, SIDES, strict=True))
    return slice(top, top + SIDES[0]), slice(left, left + SIDES[1])


def compressed(image: Array, rng: np.random.Generator) -> Array:
    """At random, an image as a JPEG file keeps it."""
    if rng.random() >= JPEG_SHARE:
        return image
    stored = np.round(255 * image[..., ::-1]).astype(np.uint8)
    encoded = cv2.imencode(".jpg", stored, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(*JPEG_QUALITY))])[1]
    decoded = cv2.imdecode(encoded, cv2.IMREAD_COLOR)
    assert decoded is not None
    return np.ascontiguousarray(decoded[..., ::-1], np.float32) / np.float32(255)
