"""A layer as drawn in a view: what has changed since is drawn again, and only that."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QColor

from ilf.data.label_map import Box, union, whole
from ilf.drawing.colours import sample

from .colour_bar import ColourBar
from .image_view import ImageView
from .layers import STRIPE, Layer
from .pixel_items import PixelItem, changed_box
from .scene_items import hatch_brush

EVERYWHERE: Box = slice(None), slice(None)


class LayerPicture:
    """Picture of a layer, marks or extrapolated depth below it, and the ends of the colour bar."""

    def __init__(self, view: ImageView, bar: ColourBar) -> None:
        self._view, self._bar = view, bar
        self._layer = Layer()
        self.drawn: list[NDArray[Any]] = []
        """Copies of the drawn arrays, the layer's parts first, since the originals may be changed in place."""
        # from below: the hatch of missing depth, marks or extrapolated depth, stripes over it, and the picture
        self.below = view.add_picture(PixelItem(-0.8))
        self.stripes = view.add_hatch(-0.6)
        self.stripes.set_brush(hatch_brush(QColor(0, 0, 0, 0), STRIPE))
        self.stripes.setVisible(False)

    def draw(self, layer: Layer) -> None:
        """Draw a layer, as far as it is not drawn already."""
        former, self._layer = self._layer, layer
        if layer.message or not layer.parts:
            self._forget()
            self._view.set_message(layer.message)
            self._view.set_picture(None)
            self._bar.set_levels(None)
        elif layer.picture is not None:
            if former.picture is None or [*map(id, former.parts)] != [*map(id, layer.parts)]:
                self._forget()
                self._view.set_picture(layer.picture())
                self._bar.set_levels(None)
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

    def _forget(self) -> None:
        self.drawn = []
        self.below.clear()
        self.stripes.setVisible(False)
        self._view.points.set_extent(None)

    def _draw_changes(self, layer: Layer) -> None:
        arrays = _arrays(layer)
        changed = [changed_box(drawn, now) for drawn, now in zip(self.drawn, arrays, strict=True)]
        boxes = [box for box in changed if box is not None]
        if not boxes:
            return
        box = reduce(union, boxes)
        for drawn, now in zip(self.drawn, arrays, strict=True):
            drawn[box] = now[box]
        indices, below = _indices(layer, box)
        if below is not None:
            self.below.update_indices(box, below)
        image = self._view.image
        image.update_indices(box, indices, None if layer.stale is None else layer.stale[box])
        if layer.has_dots and image.image is not None:
            self._view.points.set_indices(image.image.astype(np.uint8, copy=False), layer.table)

    def _draw_all(self, layer: Layer) -> None:
        self.drawn = [array.copy() for array in _arrays(layer)]
        self._bar.set_table(layer.table)
        self._bar.set_levels(layer.levels, logarithmic=layer.logarithmic)
        indices, below = _indices(layer, whole(layer.parts[0].shape))
        self.below.clear()
        if below is not None:
            self.below.set_indices(below, layer.table if layer.mark_table is None else layer.mark_table)
        self.stripes.setVisible(layer.extrapolated is not None)
        self._view.set_picture(indices, layer.table, layer.stale)
        if layer.has_dots:
            self._view.points.set_indices(indices, layer.table)


def _indices(layer: Layer, box: Box) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
    """Indices of the picture in a box, and of what lies below it, None for nothing."""
    parts = [part[box] for part in layer.parts]
    indices = layer.indices(*parts)
    if layer.extrapolated is None:
        return indices, None if layer.marks is None else layer.marks(*parts)
    below = np.where(layer.extrapolated[box], indices, np.uint8(0))
    return np.where(layer.extrapolated[box], np.uint8(0), indices), below


def _arrays(layer: Layer) -> list[NDArray[Any]]:
    return [*layer.parts, *(mask for mask in (layer.stale, layer.extrapolated) if mask is not None)]


def _look(layer: Layer) -> list[Any]:
    """All but the pixels: which arrays are there, their size, and their colours."""
    shapes = [part.shape for part in layer.parts]
    return [*layer.look, layer.stale is None, layer.extrapolated is None, shapes]
