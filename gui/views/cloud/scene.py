"""A point cloud to draw: what it is of and what colours it, and its points with their pixels and colours."""

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

from ..colours import difference_table
from ..layers import Layer
from ..view_data import RUNS, difference_of

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


Mark = tuple[NDArray[np.bool_], QColor, str]
"""A mask, bool (H, W), the colour of its points, and what they are, with a place {} for their number."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Point cloud of one frame: what is asked for, and the points that `compose` finds.

    Parameters
    ----------
    key : str
        Key of the document.
    intrinsics : Camera, optional
    depth : ndarray
        float32 (H, W) [m], of the points.
    layer : Layer
        What colours the points.
    unit : str
        Of its values.
    title, note : str
        Meaning of the colours, and a text beside the number of points.
    plain : QColor
        Colour of points without value, and what these are, "" if there are none.
    lacking : str
    marks : tuple of Mark
    chosen : frozenset of int or None
        The only blocks shown; None for all pixels.
    labels : ndarray, optional
        int32 (H, W), with `chosen`.
    points : ndarray
        float32 (N, 3) [m], x right, y down, z forward, in camera coordinates.
    pixels : ndarray
        int32 (N,), rising: index of each point's pixel, its row times the frame's width plus its column.
    colours : ndarray
        uint8 (N, 3), red first.
    spacing : float
        Distance of neighbouring points over their depth, see `ilf.drawing.clouds.spacing_of`.
    depths : tuple of float
        Smallest and largest z [m].
    legend : tuple
        Colours and their meaning.
    """

    key: str = ""
    intrinsics: Camera | None = None
    depth: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    layer: Layer = field(default_factory=Layer)
    unit: str = ""
    title: str = ""
    note: str = ""
    plain: QColor = field(default_factory=QColor)
    lacking: str = ""
    marks: tuple[Mark, ...] = ()
    chosen: frozenset[int] | None = None
    labels: NDArray[np.int32] | None = None
    points: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 3), np.float32))
    pixels: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    colours: NDArray[np.uint8] = field(default_factory=lambda: np.empty((0, 3), np.uint8))
    spacing: float = 0.0
    depths: tuple[float, float] = (0.0, 1.0)
    legend: tuple[tuple[QColor, str], ...] = ()

    @property
    def geometry(self) -> list[Any]:
        """What the points follow from: values, and identities of arrays."""
        return [self.key, self.intrinsics, id(self.depth), self.chosen, id(self.labels)]

    @property
    def look(self) -> list[Any]:
        """The same for the colours."""
        marks = [(id(mask), colour, text) for mask, colour, text in self.marks]
        texts = self.unit, self.title, self.note, self.lacking
        return [*map(id, self.layer.arrays), *self.layer.look, *texts, self.plain, marks]

    def __len__(self) -> int:
        return len(self.points)

    def pixel_of(self, index: int) -> tuple[int, int]:
        """Pixel (x, y) of a point."""
        row, column = divmod(int(self.pixels[index]), self.depth.shape[1])
        return column, row

    def index_of(self, pixel: tuple[int, int]) -> int | None:
        """Index of the point of a pixel (x, y); None if it has none."""
        x, y = pixel
        if not 0 <= x < self.depth.shape[1]:
            return None
        wanted = y * self.depth.shape[1] + x
        index = int(np.searchsorted(self.pixels, wanted))
        return index if index < len(self.pixels) and self.pixels[index] == wanted else None


def signed_table() -> NDArray[np.uint8]:
    """Table of differences, uint8 (256, 4), with grey zero.

    In the images zero is close to the background, where a surface without error would be invisible.
    """
    table = difference_table(dark=False)
    table[:, :3] = np.round(table[:, :3] * _DIMMED)
    return table


def compose(asked: Scene, before: Scene | None = None) -> Scene:
    """Find points and colours of a scene, in a worker; `before` is a scene with the same points to reuse."""
    if before is not None:
        points, pixels, spacing, depths = before.points, before.pixels, before.spacing, before.depths
    else:
        only = None if asked.chosen is None or asked.labels is None else np.isin(asked.labels, list(asked.chosen))
        assert asked.intrinsics is not None
        points, pixels = back_project(asked.depth, asked.intrinsics, only)
        depths = (float(points[:, 2].min()), float(points[:, 2].max())) if len(points) else (0.0, 1.0)
        spacing = spacing_of(points)
    layer, legend = asked.layer, []
    if layer.picture is not None:
        colours = layer.picture().reshape(-1, 3)[pixels]
    else:
        indices, table = layer.indices(*(one.reshape(-1)[pixels] for one in layer.arrays)), layer.table[:, :3].copy()
        table[0] = _rgb(asked.plain)
        colours = table[indices]
        if not indices.all():
            legend.append((asked.plain, asked.lacking))
    for mask, colour, text in asked.marks:
        marked = mask.reshape(-1)[pixels]
        if marked.any():
            colours[marked] = _rgb(colour)
            legend.append((colour, text.format(f"{np.count_nonzero(marked):,}")))
    return replace(
        asked, points=points, pixels=pixels, colours=colours, spacing=spacing, depths=depths, legend=tuple(legend)
    )


def _rgb(colour: QColor) -> tuple[int, int, int]:
    return colour.red(), colour.green(), colour.blue()
