"""Colourings of a point cloud: by layers of the images, by blocks, by what was filled."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QColor

from ilf.data.camera import Camera
from ilf.data.points import back_project
from ilf.drawing.clouds import spacing_of

from ...base.theme import Colours
from ..colours import difference_table
from ..contents import RUNS, difference_of
from ..layers import Layer
from .scene import Colouring, Scene

_DIMMED = 0.8


class ColourBy(Enum):
    """What colours the points: its text and tooltip in the window, and the content of the images whose layer it is, ""
    for none."""

    COLOUR = "Colour", "The colours of the image"
    DEPTH = "Depth", "Depth along the camera's axis, as in the depth views", "result"
    BLOCK = "Block", "The colours of the blocks"
    EXPECTED = "Expected error", "Expected error of the filled depth, estimated without ground truth", "expected-error"
    ERROR = "Error", "Depth minus ground truth: red is too far, blue too near", "error"
    DIFFERENCE = (
        "Difference to a run",
        "Depth minus the first run ticked for comparison: red is farther, blue nearer",
        difference_of("result", RUNS[0]),
    )
    FILLED = "Measured or filled", "Which depth was measured, filled or extrapolated"

    def __init__(self, text: str, hint: str, content: str = "") -> None:
        self.text, self.hint, self.content = text, hint, content


@dataclass(frozen=True, eq=False)
class Subject:
    """Data that a cloud is coloured by.

    Parameters
    ----------
    rgb : ndarray
        uint8 (H, W, 3).
    depth : ndarray
        float32 (H, W) [m], of the points.
    shades : Colours
        Colours of the theme.
    layer : Layer
        The layer of the images that colours the points; the image does if it has no parts.
    unit : str
        Of its values.
    lacking : str
        What pixels without value are.
    labels, block_colours : ndarray, optional
        int32 (H, W), and uint8 (labels, 4) by label.
    marks : tuple
        Masks, bool (H, W), with the colour of their points and what they are.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    shades: Colours
    layer: Layer = field(default_factory=Layer)
    unit: str = ""
    lacking: str = ""
    labels: NDArray[np.int32] | None = None
    block_colours: NDArray[np.uint8] | None = None
    marks: tuple[tuple[NDArray[np.bool_], QColor, str], ...] = ()


def colours_of(subject: Subject, by: ColourBy, pixels: NDArray[np.int32]) -> Colouring:
    """Colours of the points of these pixels; those of the image if the subject lacks the data for `by`."""
    if by is ColourBy.BLOCK and subject.labels is not None and subject.block_colours is not None:
        table = subject.block_colours[:, :3].copy()
        table[0] = none = _no_value_colour(subject.shades)
        labels = subject.labels.reshape(-1)[pixels]
        return Colouring(table[labels], legend=() if labels.all() else ((none, "no block"),))
    if subject.layer.parts:
        colouring = _by_layer(subject, pixels)
    else:
        notes = {ColourBy.COLOUR: "", ColourBy.FILLED: "image colours where measured"}
        note = notes.get(by, "image colours until it is computed")
        colouring = Colouring(subject.rgb.reshape(-1, 3)[pixels], note=note)
    legend = [*colouring.legend]
    for mask, colour, name in subject.marks:
        marked = mask.reshape(-1)[pixels]
        if marked.any():
            colouring.colours[marked] = _rgb(colour)
            legend.append((_rgb(colour), f"{np.count_nonzero(marked):,} {name}"))
    return replace(colouring, legend=tuple(legend))


def _by_layer(subject: Subject, pixels: NDArray[np.int32]) -> Colouring:
    """Colours of a layer, with a plain colour for points without value."""
    layer = subject.layer
    indices = layer.indices(*(part.reshape(-1)[pixels] for part in layer.parts))
    plain, table = _no_value_colour(subject.shades), layer.table[:, :3].copy()
    table[0] = plain
    legend = ((plain, subject.lacking),) if not indices.all() else ()
    return Colouring(table[indices], layer, subject.unit, legend)


def signed_table() -> NDArray[np.uint8]:
    """Table of differences, uint8 (256, 4), with grey zero.

    In the images zero is close to the background, where a surface without error would be invisible.
    """
    table = difference_table(dark=False)
    table[:, :3] = np.round(table[:, :3] * _DIMMED)
    return table


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
        Key of the document.
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
        return other is not None and self.has_same_points(other) and self._look() == other._look()

    def has_same_points(self, other: CloudRequest) -> bool:
        """Whether the scene of another request has the same points."""
        return (
            self.key == other.key
            and self.intrinsics == other.intrinsics
            and self.subject.depth is other.subject.depth
            and self.chosen == other.chosen
            and (self.chosen is None or self.subject.labels is other.subject.labels)
        )

    def _look(self) -> list[Any]:
        """What the colours follow from: identities of arrays, and values."""
        subject, layer = self.subject, self.subject.layer
        masks = [mask for mask, _, _ in subject.marks]
        arrays = subject.rgb, subject.labels, subject.block_colours, *layer.parts, *masks
        marks = [(colour, name) for _, colour, name in subject.marks]
        scale = layer.levels, layer.logarithmic, layer.table.tobytes(), subject.unit, subject.lacking
        return [self.by, self.title, subject.shades, [id(array) for array in arrays], marks, *scale]


def compose(request: CloudRequest, before: Scene | None = None) -> Scene:
    """Compute the requested scene; `before` is a scene with the same points to reuse."""
    subject = request.subject
    if before is not None:
        return replace(before, colouring=colours_of(subject, request.by, before.pixels), title=request.title)
    only = None if request.chosen is None or subject.labels is None else np.isin(subject.labels, list(request.chosen))
    points, pixels = back_project(subject.depth, request.intrinsics, only)
    depths = (float(points[:, 2].min()), float(points[:, 2].max())) if len(points) else (0.0, 1.0)
    colouring = colours_of(subject, request.by, pixels)
    return Scene(points, pixels, subject.depth.shape[1], colouring, spacing_of(points), depths, request.title)
