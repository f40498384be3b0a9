"""Colourings of a point cloud, with the same tables and colour ranges as in the images."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QColor

from ilf.data.camera import Camera
from ilf.data.points import back_project
from ilf.drawing.clouds import spacing_of
from ilf.drawing.colours import (
    log_indices,
    robust_depth_levels,
    robust_difference_level,
    robust_error_levels,
    sample,
    to_indices,
)

from ...base.theme import Colours
from ..colours import Levels, Range, difference_table, error_table, full_levels
from .scene import Colouring, Points, Rgb, Scale, Scene

Depth = NDArray[np.float32]
_MM = np.float32(1000)
_DIMMED = 0.8
_MIN_MM = 0.01
"""Lower limit of a logarithmic scale."""


class ColourBy(StrEnum):
    """Quantity that colours the points."""

    COLOUR = "colour"
    DEPTH = "depth"
    BLOCK = "block"
    EXPECTED = "expected error"
    ERROR = "error"
    DIFFERENCE = "difference"
    FILLED = "filled"

    @property
    def text(self) -> str:
        """Text in the window."""
        return _TEXTS.get(self, self.value).capitalize()

    @property
    def hint(self) -> str:
        """Tooltip."""
        return _HINTS[self]


_TEXTS = {ColourBy.DIFFERENCE: "difference to a run", ColourBy.FILLED: "measured or filled"}
_HINTS = {
    ColourBy.COLOUR: "The colours of the image",
    ColourBy.DEPTH: "Depth along the camera's axis, as in the depth views",
    ColourBy.BLOCK: "The colours of the blocks",
    ColourBy.EXPECTED: "Expected error of the filled depth, estimated without ground truth",
    ColourBy.ERROR: "Depth minus ground truth: red is too far, blue too near",
    ColourBy.DIFFERENCE: "Depth minus the first run ticked for comparison: red is farther, blue nearer",
    ColourBy.FILLED: "Which depth was measured, filled or extrapolated",
}


@dataclass(frozen=True, eq=False)
class Subject:
    """Data that a cloud can be coloured by.

    Parameters
    ----------
    rgb : ndarray
        uint8 (H, W, 3).
    depth : ndarray
        float32 (H, W) [m], of the points.
    shades : Colours
        Colours of the theme.
    depth_table : ndarray
        uint8 (256, 4).
    ranges : mapping
        Kind of `KINDS` -> Range: colour ranges, as in the images.
    labels, block_colours : ndarray, optional
        int32 (H, W), and uint8 (labels, 4) by label.
    unsupported : ndarray, optional
        bool (H, W): unsupported by measurements.
    expected, ground_truth, other : ndarray, optional
        float32 (H, W) [m], NaN where unknown: expected error, ground truth, depth of another run.
    other_name : str
        Name of that run.
    filled, extrapolated : ndarray, optional
        bool (H, W).
    """

    rgb: NDArray[np.uint8]
    depth: Depth
    shades: Colours
    depth_table: NDArray[np.uint8]
    ranges: Mapping[str, Range]
    labels: NDArray[np.int32] | None = None
    block_colours: NDArray[np.uint8] | None = None
    expected: Depth | None = None
    unsupported: NDArray[np.bool_] | None = None
    ground_truth: Depth | None = None
    other: Depth | None = None
    other_name: str = ""
    filled: NDArray[np.bool_] | None = None
    extrapolated: NDArray[np.bool_] | None = None


def colours_of(subject: Subject, by: ColourBy, points: Points, pixels: NDArray[np.int32]) -> Colouring:
    """Colours of the points of these pixels; those of the image if the subject lacks the data for `by`."""
    match by:
        case ColourBy.DEPTH:
            levels = _levels(subject, "depth", robust_depth_levels(subject.depth), subject.depth)
            indices = to_indices(points[:, 2], *levels)
            scale = Scale("m", subject.depth_table, levels)
            return Colouring(subject.depth_table[indices, :3], scale)
        case ColourBy.BLOCK if subject.labels is not None and subject.block_colours is not None:
            table = subject.block_colours[:, :3].copy()
            table[0] = none = _no_value_colour(subject.shades)
            labels = subject.labels.reshape(-1)[pixels]
            return Colouring(table[labels], legend=() if labels.all() else ((none, "no block"),))
        case ColourBy.EXPECTED if subject.expected is not None:
            return _expected(subject, subject.expected, pixels)
        case ColourBy.ERROR if subject.ground_truth is not None:
            return _signed(subject, subject.ground_truth, pixels, "no ground truth")
        case ColourBy.DIFFERENCE if subject.other is not None:
            return _signed(subject, subject.other, pixels, f"not in {subject.other_name}")
        case ColourBy.FILLED if subject.filled is not None:
            return _filled(subject, subject.filled, pixels)
    lacking = "" if by is ColourBy.COLOUR else "image colours until it is computed"
    return Colouring(subject.rgb.reshape(-1, 3)[pixels], note=lacking)


def signed_table() -> NDArray[np.uint8]:
    """Table of differences, uint8 (256, 4), with grey zero.

    In the images zero is close to the background, where a surface without error would be invisible.
    """
    table = difference_table(dark=False)
    table[:, :3] = np.round(table[:, :3] * _DIMMED)
    return table


def value_of(subject: Subject, by: ColourBy, pixel: tuple[int, int]) -> float | None:
    """Value of a pixel (x, y), in the unit of the scale; None where it is not a number."""
    place = pixel[1], pixel[0]
    match by:
        case ColourBy.DEPTH:
            value = float(subject.depth[place])
        case ColourBy.EXPECTED if subject.expected is not None:
            value = 1000 * float(subject.expected[place])
        case ColourBy.ERROR if subject.ground_truth is not None:
            value = 1000 * float(subject.depth[place] - subject.ground_truth[place])
        case ColourBy.DIFFERENCE if subject.other is not None:
            value = 1000 * float(subject.depth[place] - subject.other[place])
        case _:
            return None
    return value if math.isfinite(value) else None


def _expected(subject: Subject, expected: Depth, pixels: NDArray[np.int32]) -> Colouring:
    sampled = sample(expected) * _MM
    low, high = _levels(subject, "expected", robust_error_levels(sampled), sampled)
    levels = max(low, _MIN_MM), max(high, 2 * max(low, _MIN_MM))
    indices = log_indices(expected.reshape(-1)[pixels], levels)
    scale = Scale("mm", error_table(), levels, logarithmic=True)
    colouring = _by_table(subject, indices, scale, "measured")
    doubtful = None if subject.unsupported is None else subject.unsupported.reshape(-1)[pixels]
    if doubtful is None or not doubtful.any():
        return colouring
    colour = _rgb(subject.shades.warning)
    colours = np.where(doubtful[:, None], np.array(colour, np.uint8), colouring.colours)
    return replace(colouring, colours=colours, legend=(*colouring.legend, (colour, "unsupported")))


def _signed(subject: Subject, other: Depth, pixels: NDArray[np.int32], lacking: str) -> Colouring:
    difference = (subject.depth - other) * _MM
    sampled = sample(difference)
    level = robust_difference_level(sampled[sampled != 0])  # ignores equal pixels
    level = max(abs(end) for end in _levels(subject, "signed", (-level, level), sampled))
    levels = -level, level
    indices = to_indices(difference.reshape(-1)[pixels], *levels)
    scale = Scale("mm", signed_table(), levels)
    return _by_table(subject, indices, scale, lacking)


def _levels(subject: Subject, kind: str, robust: Levels, values: Depth) -> Levels:
    return replace(subject.ranges[kind]).find(lambda: robust, lambda: full_levels(values))


def _by_table(subject: Subject, indices: NDArray[np.uint8], scale: Scale, lacking: str) -> Colouring:
    """Colours of a scale, with a plain colour for points without value."""
    plain = _no_value_colour(subject.shades)
    table = scale.table[:, :3].copy()
    table[0] = plain
    return Colouring(table[indices], scale, ((plain, lacking),) if not indices.all() else ())


def _filled(subject: Subject, filled: NDArray[np.bool_], pixels: NDArray[np.int32]) -> Colouring:
    shades = subject.shades
    colours: Rgb = subject.rgb.reshape(-1, 3)[pixels]
    kinds = [(filled, shades.accent, "filled")]
    if subject.extrapolated is not None and subject.extrapolated.any():
        kinds.append((subject.extrapolated, shades.warning, "extrapolated"))
    legend = []
    for mask, colour, name in kinds:
        chosen = mask.reshape(-1)[pixels]
        colours[chosen] = _rgb(colour)
        legend.append((_rgb(colour), f"{np.count_nonzero(chosen):,} {name}"))
    return Colouring(colours, legend=tuple(legend), note="image colours where measured")


def _no_value_colour(shades: Colours) -> tuple[int, int, int]:
    """Colour of points without value: visible on the background, and unlike any value."""
    return _rgb(shades.grid if shades.is_dark else shades.muted)


def _rgb(colour: QColor) -> tuple[int, int, int]:
    return colour.red(), colour.green(), colour.blue()


# The request for a scene, and its computation. No widgets; for a worker thread.


@dataclass(frozen=True, eq=False)
class CloudRequest:
    """Request for a scene.

    Parameters
    ----------
    key : str
        Key of the session.
    intrinsics : Camera
    subject : Subject
        Depth, and data to colour it by.
    by : ColourBy
    chosen : frozenset of int or None
        The only blocks shown; None for all pixels.
    title : str
        Meaning of the colours.
    """

    key: str
    intrinsics: Camera
    subject: Subject
    by: ColourBy
    chosen: frozenset[int] | None
    title: str

    def is_same(self, other: CloudRequest | None) -> bool:
        """Whether another request would give the same scene."""
        if other is None or (self.by, self.title) != (other.by, other.title):
            return False
        return self.has_same_points(other) and _same(self.subject, other.subject)

    def has_same_points(self, other: CloudRequest) -> bool:
        """Whether the scene of another request has the same points."""
        return (
            self.key == other.key
            and self.intrinsics == other.intrinsics
            and self.subject.depth is other.subject.depth
            and self.chosen == other.chosen
            and (self.chosen is None or self.subject.labels is other.subject.labels)
        )


def compose(request: CloudRequest, before: Scene | None = None) -> Scene:
    """Compute the requested scene; `before` is a scene with the same points to reuse."""
    subject = request.subject
    if before is None:
        only = (
            None if request.chosen is None or subject.labels is None else np.isin(subject.labels, list(request.chosen))
        )
        points, pixels = back_project(subject.depth, request.intrinsics, only)
        spacing = spacing_of(points)
        depths = (float(points[:, 2].min()), float(points[:, 2].max())) if len(points) else (0.0, 1.0)
    else:
        points, pixels, spacing, depths = before.points, before.pixels, before.spacing, before.depths
    colouring = colours_of(subject, request.by, points, pixels)
    return Scene(points, pixels, subject.depth.shape[1], colouring, spacing, depths, request.title)


def _same(one: Subject, other: Subject) -> bool:
    """Whether two subjects have identical arrays and equal values."""
    pairs = ((getattr(one, field.name), getattr(other, field.name)) for field in fields(Subject))
    return all(a is b or (not isinstance(a, np.ndarray) and a == b) for a, b in pairs)
