"""The label map as a picture: the blocks' fills, and how blocks are to be shown."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

from ilf.blocks import Box

from .pixel_item import PixelItem, Pixels, packed


class BlockOverlay:
    """Fills of the blocks of a label map, in items of as many scenes as want them. Edits only touch the pixels of their
    box."""

    def __init__(self, z: float) -> None:
        self._z = z
        self._items: list[PixelItem] = []
        self.pixels: Pixels | None = None
        """Colours of all fills, uint32 (H, W), as `packed`; None where nothing is filled."""
        self.labels: NDArray[np.int32] | None = None
        self.colours = np.zeros((1, 4), np.uint8)
        """RGBA by label, uint8 (N + 1, 4): alpha 0 is a hidden block."""
        self._fills = np.zeros(1, np.uint32)
        self._opacity = 0.45
        self._is_filled = True

    def new_item(self) -> PixelItem:
        """An item that shows the fills, for another scene."""
        item = PixelItem(self._z)
        self._items.append(item)
        self._show(item)
        return item

    def drop_item(self, item: PixelItem) -> None:
        """Show nothing in an item any more."""
        self._items.remove(item)

    def fills_of(self, labels: NDArray[np.int32], colour_table: NDArray[np.uint8]) -> Pixels:
        """What other blocks would look like, with the same opacity: uint32 (H, W)."""
        return self._find_fills(colour_table)[labels]

    def set_blocks(self, labels: NDArray[np.int32], colour_table: NDArray[np.uint8]) -> None:
        """Draw a label map, int32 (H, W), with colours uint8 (N + 1, 4) RGBA by label; alpha 0 hides a block.

        Raises
        ------
        ValueError
            If shapes do not fit or a label has no colour.
        """
        if labels.ndim != 2 or colour_table.ndim != 2 or colour_table.shape[1] != 4:
            raise ValueError(f"need labels (H, W) and colours (N + 1, 4), not {labels.shape}, {colour_table.shape}")
        self._check_range(labels, len(colour_table))
        self.labels = np.array(labels, np.int32)
        self.colours = np.array(colour_table, np.uint8)
        self._rebuild()

    def add_colours(self, colour_table: NDArray[np.uint8]) -> None:
        """Take a table that begins as the present one and has colours for further labels, which no block has yet."""
        self.colours = np.array(colour_table, np.uint8)
        self._fills = self._find_fills(self.colours)
        if self.pixels is None:
            self._rebuild()

    def set_opacity(self, opacity: float) -> None:
        """Opacity of the fills, 0-1."""
        self._opacity = min(max(opacity, 0.0), 1.0)
        self._rebuild()

    def set_filled(self, on: bool) -> None:
        """Whether blocks are filled at all."""
        self._is_filled = on
        self._rebuild()

    def update_region(self, box: Box, labels: NDArray[np.int32]) -> None:
        """Replace the labels of a box (rows, columns) with non-negative bounds by an array of its shape."""
        if self.labels is None:
            raise ValueError("there are no blocks to update: call set_blocks first")
        self._check_range(labels, len(self.colours))
        self.labels[box] = labels
        if self.pixels is not None:
            self.pixels[box] = self._fills[labels]
            for item in self._items:
                item.note_change(box)

    def clear(self) -> None:
        """Draw nothing."""
        self.labels = None
        self._take(None)

    def _rebuild(self) -> None:
        if self.labels is None:
            return
        self._fills = self._find_fills(self.colours)
        self._take(self._fills[self.labels] if self._fills.any() else None)

    def _take(self, pixels: Pixels | None) -> None:
        self.pixels = pixels
        for item in self._items:
            self._show(item)

    def _show(self, item: PixelItem) -> None:
        if self.pixels is None:
            item.clear()
        else:
            item.set_pixels(self.pixels)

    def _find_fills(self, colours: NDArray[np.uint8]) -> Pixels:
        fills = colours.astype(np.float32)
        fills[0] = 0
        fills[:, 3] *= self._opacity if self._is_filled else 0.0
        return packed(fills.round().astype(np.uint8))

    @staticmethod
    def _check_range(labels: NDArray[np.int32], colours: int) -> None:
        if labels.size and (labels.min() < 0 or labels.max() >= colours):
            raise ValueError(f"labels span {labels.min()} to {labels.max()}, but there are {colours} colours")


def boundary_path(mask: NDArray[np.bool_], x: int = 0, y: int = 0) -> QPainterPath:
    """Path along the pixel edges between inside and outside of a mask, bool (h, w), whose corner is at (x, y).

    It follows pixel edges rather than centres, so it never covers half a pixel of a neighbouring block.
    """
    padded = np.pad(mask, 1)
    rows, left, right = _runs(padded[1:, 1:-1] != padded[:-1, 1:-1])
    columns, top, bottom = _runs((padded[1:-1, 1:] != padded[1:-1, :-1]).T)
    ends_x = np.concatenate((np.column_stack((left, right)).ravel(), np.repeat(columns, 2)))
    ends_y = np.concatenate((np.repeat(rows, 2), np.column_stack((top, bottom)).ravel()))
    return pg.arrayToQPath(
        (ends_x + x).astype(np.float64), (ends_y + y).astype(np.float64), connect="pairs", finiteCheck=False
    )


def _runs(edges: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Row, start and stop of every run of True along the rows."""
    padded = np.pad(edges, ((0, 0), (1, 1)))
    # in a row, runs begin and end in turn
    rows, columns = np.divmod(np.flatnonzero(padded[:, 1:] != padded[:, :-1]), edges.shape[1] + 1)
    return rows[::2], columns[::2], columns[1::2]
