"""A layer as drawn in a view: what has changed since is drawn again, and only that."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box, union, whole
from ilf.drawing.colours import sample

from .colour_bar import ColourBar
from .image_view import ImageView
from .layers import Layer
from .pixel_items import Pixels, changed_box, greyed, packed, rgb_pixels

EVERYWHERE: Box = slice(None), slice(None)


class LayerPicture:
    """Picture of a layer in a view, and the ends of the colour bar."""

    def __init__(self, view: ImageView, bar: ColourBar) -> None:
        self._view, self._bar = view, bar
        self._layer = Layer()
        self.drawn: list[NDArray[Any]] = []
        """Copies of the drawn arrays, the layer's parts first, since the originals may be changed in place."""
        self.image: NDArray[np.uint8] | None = None
        """Colour (H, W, 3), or indices into the layer's table (H, W); None for no picture."""

    def draw(self, layer: Layer) -> None:
        """Draw a layer, as far as it is not drawn already."""
        former, self._layer = self._layer, layer
        if layer.message or not layer.parts:
            self._view.set_message(layer.message)
            self._draw_colour(None)
        elif layer.picture is not None:
            if former.picture is None or [*map(id, former.parts)] != [*map(id, layer.parts)]:
                self._draw_colour(layer.picture())
        elif self.drawn and _look(former) == _look(layer):
            self._draw_changes(layer)
        else:
            self._draw_all(layer)

    def value_at(self, x: int, y: int) -> float | None:
        """Value at a pixel, in the unit of the colour bar; None if there is none."""
        return self._layer.value_at(x, y, self._parts)

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        """Values shown in a box or a mask (H, W), or a sample of them, in the unit of the colour bar, NaN = missing.

        None if there are none.
        """
        return self._layer.measure(*(sample(part[where]) for part in self._parts)) if self.drawn else None

    @property
    def _parts(self) -> list[NDArray[Any]]:
        return self.drawn[: len(self._layer.parts)]

    def _draw_colour(self, rgb: NDArray[np.uint8] | None) -> None:
        self.drawn, self.image = [], rgb
        self._view.set_picture(None if rgb is None else rgb_pixels(rgb))
        self._view.points.set_extent(None)
        self._bar.set_levels(None)

    def _draw_changes(self, layer: Layer) -> None:
        changed = [changed_box(drawn, now) for drawn, now in zip(self.drawn, _arrays(layer), strict=True)]
        boxes = [box for box in changed if box is not None]
        image, pixels = self.image, self._view.image.pixels
        if not boxes or image is None or pixels is None:
            return
        box = reduce(union, boxes)
        for drawn, now in zip(self.drawn, _arrays(layer), strict=True):
            drawn[box] = now[box]
        image[box], pixels[box] = _coloured(layer, box)
        self._view.image.notify_change(box)
        if layer.has_dots:
            self._view.points.set_indices(image, layer.table)

    def _draw_all(self, layer: Layer) -> None:
        self.drawn = [array.copy() for array in _arrays(layer)]
        self._bar.set_table(layer.table)
        self._bar.set_levels(layer.levels, logarithmic=layer.logarithmic)
        self.image, pixels = _coloured(layer, whole(layer.parts[0].shape))
        self._view.set_picture(pixels, is_hatched=True)
        if layer.has_dots:
            self._view.points.set_indices(self.image, layer.table)


def _coloured(layer: Layer, box: Box) -> tuple[NDArray[np.uint8], Pixels]:
    """Indices and colours of a layer in a box: stale values in grey, and marks where there are none."""
    parts = [part[box] for part in layer.parts]
    indices, table = layer.indices(*parts), packed(layer.table)
    colours = table[indices]
    stale = None if layer.stale is None else layer.stale[box]
    if stale is not None and stale.any():
        colours[stale] = greyed(table)[indices[stale]]
    if layer.marks is not None and layer.mark_table is not None:
        missing = indices == 0
        colours[missing] = packed(layer.mark_table)[layer.marks(*parts)[missing]]
    return indices, colours


def _arrays(layer: Layer) -> list[NDArray[Any]]:
    return [*layer.parts, *([] if layer.stale is None else [layer.stale])]


def _look(layer: Layer) -> list[Any]:
    """All but the pixels: which arrays are there, their size, and their colours."""
    return [*layer.look, layer.stale is None, [part.shape for part in layer.parts]]
