"""Which image pixel is painted on which pixel of the screen, for lines and stripes that are as wide at every zoom."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

Argb = NDArray[np.uint32]
"""Device pixels as Qt's premultiplied ARGB: 0xAARRGGBB, each colour at most as large as alpha."""

Rims = tuple[tuple[bool, bool], tuple[bool, bool]]


@dataclass(frozen=True)
class Sampling:
    """How a frame lies on the device pixels of a view.

    Parameters
    ----------
    scale : float
        Device pixels per image pixel.
    x, y : int
        Device pixel that the frame's corner is at; may lie outside the view.
    size : (int, int)
        Width and height of the view in device pixels.
    frame : (int, int)
        Width and height of the frame.
    """

    scale: float
    x: int
    y: int
    size: tuple[int, int]
    frame: tuple[int, int]

    @property
    def left(self) -> int:
        """First device pixel, from the left, that shows the frame."""
        return max(self.x, 0)

    @property
    def top(self) -> int:
        """First device pixel, from the top, that shows the frame."""
        return max(self.y, 0)

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """Image column of each device column that shows the frame."""
        return self._pixels(self.x, self.size[0], self.frame[0])

    @cached_property
    def rows(self) -> NDArray[np.intp]:
        """Image row of each device row that shows the frame."""
        return self._pixels(self.y, self.size[1], self.frame[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of device pixels that show the frame."""
        return len(self.rows), len(self.columns)

    @property
    def rims(self) -> Rims:
        """Whether the frame's rim is to be seen: above and below, at the left and right."""
        width, height = self.frame
        if 0 in self.shape:
            return (False, False), (False, False)
        above, below = int(self.rows[0]) == 0, int(self.rows[-1]) == height - 1
        return (above, below), (int(self.columns[0]) == 0, int(self.columns[-1]) == width - 1)

    def sample(self, values: NDArray[Any], box: Box) -> NDArray[Any]:
        """Values (H, W) of the image on a box of the device pixels that show the frame."""
        rows, columns = self.rows[box[0]], self.columns[box[1]]
        return np.take(np.take(values, rows, axis=0), columns, axis=1)

    def box_of(self, box: Box) -> Box:
        """Device pixels that show a box of the image; empty where it is out of sight."""
        rows, columns = (
            slice(int(np.searchsorted(shown, span.start)), int(np.searchsorted(shown, span.stop)))
            for shown, span in zip((self.rows, self.columns), box, strict=True)
        )
        return rows, columns

    def _pixels(self, start: int, view: int, frame: int) -> NDArray[np.intp]:
        first, last = max(start, 0), min(start + math.ceil(frame * self.scale), view)
        pixels = np.floor((np.arange(first, max(last, first)) + 0.5 - start) / self.scale).astype(np.intp)
        return pixels[pixels < frame]
