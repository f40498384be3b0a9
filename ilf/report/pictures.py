"""The pictures of a frame: colour with its blocks, depth before and after, errors, origin of the depth."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from .._runtime.cancellation import cancellable_items
from .._runtime.formatting import counted
from ..data.frame import RGBDFrame
from ..drawing.blocks import inner_points
from ..drawing.colours import (
    MISSING,
    Colour,
    depth_colours,
    difference_colours,
    error_colours,
    log_indices,
    robust_depth_levels,
    robust_difference_level,
    robust_error_levels,
    to_indices,
)
from .content import ColourBar, Image, Legend, Mark, Picture, ScaleBar, Subject
from .frame_statistics import FrameStatistics

# Encoding arrays as images of limited size.

_QUALITY = 85
_BAR_PIXELS = 255


def jpeg_image(rgb: NDArray[np.uint8], quality: int = _QUALITY) -> Image:
    """Encode a colour image, uint8 (H, W, 3), as JPEG."""
    buffer = io.BytesIO()
    Pillow.fromarray(rgb).save(buffer, "JPEG", quality=quality, optimize=True)
    return Image(buffer.getvalue(), "jpeg", rgb.shape[1], rgb.shape[0])


def indexed_png(indices: NDArray[np.uint8], table: NDArray[np.uint8]) -> Image:
    """Encode indices, uint8 (H, W), into a lookup table, uint8 (256, 3), as lossless PNG."""
    picture = Pillow.fromarray(indices)
    picture.putpalette(table.tobytes())
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True)
    return Image(buffer.getvalue(), "png", indices.shape[1], indices.shape[0])


def colour_bar(table: NDArray[np.uint8], ticks: tuple[str, str, str]) -> ColourBar:
    """Make the colour bar of a lookup table, without the colour of missing values."""
    row = np.arange(1, _BAR_PIXELS + 1, dtype=np.uint8)[None]
    return ColourBar(indexed_png(row, table), ticks)


def reduced_shape(shape: tuple[int, int], most: int) -> tuple[int, int]:
    """Return height and width of a picture reduced to at most `most` pixels on its longer side."""
    factor = min(1.0, most / max(shape))
    return max(round(shape[0] * factor), 1), max(round(shape[1] * factor), 1)


def resized(values: NDArray[Any], shape: tuple[int, int], smooth: bool = False) -> NDArray[Any]:
    """Resample an array of pixels: by nearest neighbour, or averaged (`smooth`)."""
    if values.shape[:2] == shape:
        return values
    how = cv2.INTER_AREA if smooth else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(values, shape[::-1], interpolation=how))


# The scale bar of a frame's pictures: a round length, and the depth that it applies to.

_MAX_SHARE = 0.3


def scale_bar(frame: RGBDFrame, depth: NDArray[np.floating]) -> ScaleBar:
    """Make a scale bar of at most 30 % of the picture's width: in metres if the camera is known, else in pixels.

    Parameters
    ----------
    frame : RGBDFrame
    depth : ndarray of float, shape (H, W)
        Depth [m], NaN = missing; the bar applies at its median.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((30, 640, 3), np.uint8), np.full((30, 640), 2.0))
    >>> scale_bar(frame, frame.depth)
    ScaleBar(share=0.15625, text='100 px')
    """
    width = frame.shape[1]
    if frame.intrinsics is None:
        pixels = _round_down(_MAX_SHARE * width)
        return ScaleBar(pixels / width, f"{pixels:g} px")
    median = float(np.nanmedian(depth))
    across = width * median / frame.intrinsics.fx
    metres = _round_down(_MAX_SHARE * across)
    length = f"{metres:g} m" if metres >= 1 else f"{1000 * metres:g} mm" if metres < 0.01 else f"{100 * metres:g} cm"
    return ScaleBar(metres / across, f"{length} at {median:.2f} m depth")


def _round_down(value: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9))


_NO_DEPTH = Legend(MISSING, "no depth")
_MIN_LABEL_RADIUS = 0.011
"""Minimum radius of a block's inner circle, as a share of the picture's width, to print the block's number."""
_MM = np.float32(1000)

_ORIGINS: tuple[tuple[str, Colour], ...] = (
    ("still missing", MISSING),
    ("measured", (86, 96, 110)),
    ("filled by blocks", (38, 150, 120)),
    ("depth by hand", (158, 110, 206)),
    ("extrapolated", (222, 168, 40)),
    ("marked invalid", (196, 64, 80)),
    ("outside the view", (60, 100, 160)),
    ("filled outside the view", (120, 170, 225)),
    ("measured by neighbours", (140, 170, 60)),
)
(
    _MISSING,
    _MEASURED,
    _FILLED,
    _BY_HAND,
    _EXTRAPOLATED,
    _INVALID_DEPTH,
    _OUTSIDE,
    _FILLED_OUTSIDE,
    _NEIGHBOURS,
) = range(len(_ORIGINS))


def frame_pictures(figures: FrameStatistics, most: int) -> tuple[Picture, ...]:
    """Make all pictures of a frame.

    Parameters
    ----------
    figures : FrameStatistics
    most : int
        Maximum width and height of a picture [px].
    """
    return tuple(cancellable_items(_pictures(figures, most)))


def thumbnail(subject: Subject, most: int) -> NDArray[np.uint8]:
    """Draw a small colour image with the outlines of its blocks, uint8 (H, W, 3)."""
    return _outlined(subject, reduced_shape(subject.run.frame.shape, most))


def _pictures(figures: FrameStatistics, most: int) -> Iterator[Picture]:
    subject = figures.subject
    frame, completion = subject.run.frame, subject.completion
    shape = reduced_shape(frame.shape, most)
    levels = robust_depth_levels(np.stack([frame.depth, completion.depth]))
    scale = scale_bar(frame, completion.depth)
    blocks = int(np.count_nonzero(np.bincount(subject.run.blocks.ravel())[1:]))
    yield Picture(
        "Colour and blocks",
        jpeg_image(_outlined(subject, shape)),
        f"{counted(blocks, 'block')}, numbered as in the table." if blocks else "There are no blocks.",
        scale=scale,
        marks=_marks(subject),
    )
    table, bar = depth_colours(), (f"{levels[0]:.2f} m", f"{sum(levels) / 2:.2f} m", f"{levels[1]:.2f} m")
    for title, depth in (("Depth in", frame.own_depth), ("Depth out", completion.depth)):
        indices = to_indices(resized(depth, shape), *levels)
        yield Picture(
            title, indexed_png(indices, table), bar=colour_bar(table, bar), scale=scale, legend=_no_depth(indices)
        )
    yield _origin(subject, shape)
    if np.isfinite(figures.expected).any():
        yield _expected(figures, shape)
    yield from _differences(figures, shape)


def _differences(figures: FrameStatistics, shape: tuple[int, int]) -> Iterator[Picture]:
    frame, completion = figures.subject.run.frame, figures.subject.completion
    if frame.ground_truth is not None and completion.filled.any():
        error = np.where(completion.filled, completion.depth - frame.ground_truth, np.float32(np.nan))
        yield _difference("Error against ground truth", error, shape, "Of filled pixels: depth out minus ground truth.")
    if figures.hidden is not None:
        error = np.full(frame.shape, np.nan, np.float32)
        for part in figures.hidden.errors:
            there = part.places[part.filled]
            error.ravel()[there] = part.error[part.filled]
        yield _difference("Error on hold-out", error, shape, "Of held-out pixels: completed minus measured depth.")
    change = completion.depth - frame.depth
    if np.nanmax(np.abs(change), initial=0.0) > 0:
        yield _difference("Change of measured depth", change, shape, "Depth out minus depth in.")


def _difference(title: str, metres: NDArray[np.float32], shape: tuple[int, int], caption: str) -> Picture:
    level = robust_difference_level(metres * _MM)
    indices = to_indices(resized(metres, shape) * _MM, -level, level)
    table = difference_colours()
    bar = colour_bar(table, (f"\N{MINUS SIGN}{level:g} mm", "0", f"+{level:g} mm"))
    return Picture(title, indexed_png(indices, table), caption, bar, legend=(Legend(MISSING, "not compared"),))


def _expected(figures: FrameStatistics, shape: tuple[int, int]) -> Picture:
    low, high = robust_error_levels(figures.expected * _MM)
    table = error_colours()
    bar: ColourBar = colour_bar(table, (f"{low:g} mm", f"{np.sqrt(low * high):.3g} mm", f"{high:g} mm"))
    picture = indexed_png(log_indices(resized(figures.expected, shape), (low, high)), table)
    caption = "About 68 % of the true errors of filled pixels are expected to lie within it."
    return Picture("Expected error", picture, caption, bar, legend=(Legend(MISSING, "not filled"),))


def _origin(subject: Subject, shape: tuple[int, int]) -> Picture:
    frame, completion = subject.run.frame, subject.completion
    origin = np.full(frame.shape, _MISSING, np.uint8)
    if frame.invalid_mask is not None:
        origin[frame.invalid_mask & np.isfinite(frame.measured)] = _INVALID_DEPTH
    origin[frame.known] = _MEASURED
    origin[completion.filled] = _FILLED
    origin[completion.by_hand] = _BY_HAND
    origin[completion.extrapolated] = _EXTRAPOLATED
    origin[completion.from_neighbours] = _NEIGHBOURS
    if frame.outside_view is not None:
        origin[frame.outside_view] = np.where(completion.filled, _FILLED_OUTSIDE, _OUTSIDE)[frame.outside_view]
    table = np.zeros((256, 3), np.uint8)
    table[: len(_ORIGINS)] = [colour for _, colour in _ORIGINS]
    counts = np.bincount(origin.ravel(), minlength=len(_ORIGINS)) / origin.size
    legend = tuple(
        Legend(colour, f"{text} {counts[number]:.1%}")
        for number, (text, colour) in enumerate(_ORIGINS)
        if counts[number]
    )
    picture = indexed_png(resized(origin, shape), table)
    return Picture("Origin of the depth", picture, legend=legend)


def _no_depth(indices: NDArray[np.uint8]) -> tuple[Legend, ...]:
    return (_NO_DEPTH,) if not indices.all() else ()


def _outlined(subject: Subject, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Draw the colour image at a shape, with the blocks' borders in their colours on both sides."""
    blocks = subject.run.blocks
    picture = np.array(resized(subject.run.frame.rgb, shape, smooth=True))
    labels = resized(blocks, shape)
    there = np.flatnonzero(np.bincount(blocks.ravel()))
    numbers = np.searchsorted(there, labels).astype(np.float32)  # small enough to be exact
    side = 3 if max(shape) < 900 else 5
    kernel = np.ones((side, side), np.uint8)
    border = (cv2.dilate(numbers, kernel) != cv2.erode(numbers, kernel)) & (labels > 0)
    table = np.array([subject.colour_of(int(label)) for label in there], np.uint8)
    picture[border] = table[np.searchsorted(there, labels[border])]
    return picture


def _marks(subject: Subject) -> tuple[Mark, ...]:
    height, width = subject.run.frame.shape
    return tuple(
        Mark(x / width, y / height, str(label))
        for label, (x, y, radius) in inner_points(subject.run.blocks).items()
        if radius >= _MIN_LABEL_RADIUS * width
    )
