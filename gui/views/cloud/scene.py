"""A point cloud to draw: points, their pixels, and their colours with scale and legend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..layers import Layer

Points = NDArray[np.float32]
Rgb = NDArray[np.uint8]
Legend = tuple[tuple[tuple[int, int, int], str], ...]


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours of a cloud's points, with their meaning.

    Parameters
    ----------
    colours : ndarray
        uint8 (N, 3), red first.
    layer : Layer, optional
        The one whose colours these are, for the colour bar.
    unit : str
        Of its values.
    legend : tuple
        Colours, red first, and their meaning.
    note : str
        Text beside the number of points.
    """

    colours: Rgb
    layer: Layer | None = None
    unit: str = ""
    legend: Legend = ()
    note: str = ""


@dataclass(frozen=True, eq=False)
class Scene:
    """Point cloud of one frame.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m], x right, y down, z forward, in camera coordinates.
    pixels : ndarray
        int32 (N,), rising: index of each point's pixel, its row times the frame's width plus its column.
    width : int
        Width of the frame [px].
    colouring : Colouring
    spacing : float
        Distance of neighbouring points over their depth, see `ilf.drawing.clouds.spacing_of`.
    depths : tuple of float
        Smallest and largest z [m].
    title : str
        Meaning of the colours.
    """

    points: Points
    pixels: NDArray[np.int32]
    width: int
    colouring: Colouring
    spacing: float = 0.0
    depths: tuple[float, float] = (0.0, 0.0)
    title: str = ""

    def __len__(self) -> int:
        return len(self.points)

    def pixel_of(self, index: int) -> tuple[int, int]:
        """Pixel (x, y) of a point."""
        row, column = divmod(int(self.pixels[index]), self.width)
        return column, row

    def index_of(self, pixel: tuple[int, int]) -> int | None:
        """Index of the point of a pixel (x, y); None if it has none."""
        x, y = pixel
        if not 0 <= x < self.width:
            return None
        wanted = y * self.width + x
        index = int(np.searchsorted(self.pixels, wanted))
        return index if index < len(self.pixels) and self.pixels[index] == wanted else None


def empty_scene() -> Scene:
    """Scene without points."""
    nothing = np.empty((0, 3), np.float32)
    return Scene(nothing, np.empty(0, np.int32), 1, Colouring(np.empty((0, 3), np.uint8)))
