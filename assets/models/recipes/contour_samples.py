"""Samples to train the contour network on: generated pictures, and real frames whose measured depth shows jumps."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.edges.frame_edges import find_relief

from .pictures import Picture, random_colour, read_picture

Array = NDArray[np.float32]

SIDES = (256, 320)
"""Height and width of the samples."""

DETAILS, UPSIDE_DOWN = 0.4, 0.1
"""Shares of the generated pictures that show a quarter at twice its size, and that are upside down."""

JPEG_SHARE, JPEG_QUALITY = 0.3, (25, 90)
"""Share of the samples that are compressed, and range of the quality."""

SCALES = (0.55, 1.0)
"""Range of the scale of real frames."""

SMOOTH_RADIUS = 6
"""Radius [px] around a pixel without jump, bend or missing depth, in which there is no contour in real frames."""

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
    return sample_of(picture, compressed(random_colour(picture.rgb, rng), rng))


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


def real_sample(frame: RGBDFrame, rng: np.random.Generator) -> tuple[Array, ...]:
    """Make a sample of a real frame: a detail at random scale, mirrored, with changed colour; jumps of its measured
    depth are its lines, and smooth surfaces have none.

    Returns
    -------
    See `sample_of`.
    """
    least = max(side / whole for side, whole in zip(SIDES, frame.depth.shape, strict=True))
    scale = max(rng.uniform(*SCALES), least + 0.01)
    size = tuple(round(side * scale) for side in reversed(frame.depth.shape))
    rgb = np.asarray(cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    depth = np.asarray(cv2.resize(frame.depth, size, interpolation=cv2.INTER_NEAREST), np.float32)
    top, left = (int(rng.integers(whole - side + 1)) for whole, side in zip(depth.shape, SIDES, strict=True))
    window = slice(top, top + SIDES[0]), slice(left, left + SIDES[1])
    rgb, depth = rgb[window], depth[window]
    if rng.random() < 0.5:
        rgb, depth = np.ascontiguousarray(rgb[:, ::-1]), np.ascontiguousarray(depth[:, ::-1])
    defaults = BlockParameters()
    relief = find_relief(depth, defaults.depth_jump, defaults.depth_jump_share)
    lines = np.zeros((*SIDES, 3), np.float32)
    lines[..., 0] = lines[..., 2] = relief.edges
    uneven = ~relief.evaluated | (relief.bend > 0.5)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * SMOOTH_RADIUS + 1,) * 2)
    none = cv2.dilate(uneven.view(np.uint8), around) == 0
    image = compressed(random_colour(rgb, rng), rng)
    return image, lines, none[..., None].astype(np.float32), np.full((*SIDES, 1), REAL, np.float32)


def compressed(image: Array, rng: np.random.Generator) -> Array:
    """At random, an image as a JPEG file keeps it."""
    if rng.random() >= JPEG_SHARE:
        return image
    stored = np.round(255 * image[..., ::-1]).astype(np.uint8)
    encoded = cv2.imencode(".jpg", stored, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(*JPEG_QUALITY))])[1]
    decoded = cv2.imdecode(encoded, cv2.IMREAD_COLOR)
    assert decoded is not None
    return np.ascontiguousarray(decoded[..., ::-1], np.float32) / np.float32(255)
