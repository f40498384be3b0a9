"""The label map as a picture: coloured blocks with darker outlines, and the outline of one block as a path."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

_OUTLINE_SHADE = 0.55
_OUTLINE_OPACITY_GAIN = 2.2


class BlockOverlay:
    """Label map drawn through a lookup table into one image item.

    The table has two halves: fills, then outlines (darker, less transparent). Edits only touch the pixels of
    their region and the ring around it, where outlines may change.
    """

    def __init__(self) -> None:
        self.item = pg.ImageItem(axisOrder="row-major")
        self.labels: NDArray[np.int32] | None = None
        self._colours = np.zeros((1, 4), np.uint8)
        self._table = np.zeros(2, np.uint32)
        self._pixels = np.zeros((0, 0), np.uint32)
        self._opacity = 0.45

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
        self._colours = np.array(colour_table, np.uint8)
        self._pixels = np.zeros(labels.shape, np.uint32)
        self._rebuild(self.labels)

    def set_opacity(self, opacity: float) -> None:
        """Opacity of the fills, 0-1; outlines stay clearer than fills."""
        self._opacity = min(max(opacity, 0.0), 1.0)
        if self.labels is not None:
            self._rebuild(self.labels)

    def update_region(self, rows: slice, columns: slice, labels: NDArray[np.int32]) -> None:
        """Replace the labels of a box, given as slices with non-negative bounds, by an array of its shape."""
        if self.labels is None:
            raise ValueError("there are no blocks to update: call set_blocks first")
        self._check_range(labels, len(self._colours))
        self.labels[rows, columns] = labels
        self._draw(self.labels, _grown(rows, self.labels.shape[0]), _grown(columns, self.labels.shape[1]))

    def clear(self) -> None:
        """Draw nothing."""
        self.labels = None
        self.item.clear()

    def _rebuild(self, labels: NDArray[np.int32]) -> None:
        fills = self._colours.astype(np.float32)
        fills[0] = 0
        outlines = fills.copy()
        outlines[:, :3] *= _OUTLINE_SHADE
        fills[:, 3] *= self._opacity
        outlines[:, 3] *= min(self._opacity * _OUTLINE_OPACITY_GAIN, 1.0)
        table = np.concatenate((fills, outlines)).round().astype(np.uint8)
        self._table = table.view(np.uint32).ravel()
        self._draw(labels, slice(0, labels.shape[0]), slice(0, labels.shape[1]))

    def _draw(self, labels: NDArray[np.int32], rows: slice, columns: slice) -> None:
        height, width = labels.shape
        around_rows, around_columns = _grown(rows, height), _grown(columns, width)
        edges = _edges(labels[around_rows, around_columns])
        inner = edges[
            rows.start - around_rows.start : rows.stop - around_rows.start,
            columns.start - around_columns.start : columns.stop - around_columns.start,
        ]
        entries = labels[rows, columns] + inner * np.int32(len(self._colours))
        self._pixels[rows, columns] = self._table[entries]
        self.item.setImage(self._pixels.view(np.uint8).reshape(height, width, 4), autoLevels=False)

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


def block_outline(labels: NDArray[np.int32], label: int) -> QPainterPath:
    """Outline of one block of a label map; empty where the label is 0 or absent."""
    mask = labels == label
    rows = np.flatnonzero(mask.any(axis=1))
    if label == 0 or rows.size == 0:
        return QPainterPath()
    columns = np.flatnonzero(mask[rows[0] : rows[-1] + 1].any(axis=0))
    box = mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    return boundary_path(box, int(columns[0]), int(rows[0]))


def _runs(edges: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Row, start and stop of every run of True along the rows."""
    steps = np.diff(edges.astype(np.int8), axis=1, prepend=0, append=0)
    rows, starts = np.nonzero(steps == 1)
    return rows, starts, np.nonzero(steps == -1)[1]


def _edges(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Pixels of a block with another label to the right or below, or with no block to the left or above."""
    edges = np.zeros(labels.shape, bool)
    across, down = labels[:, 1:] != labels[:, :-1], labels[1:] != labels[:-1]
    edges[:, :-1] |= across
    edges[:-1] |= down
    edges[:, 1:] |= across & (labels[:, :-1] == 0)
    edges[1:] |= down & (labels[:-1] == 0)
    return edges


def _grown(span: slice, size: int) -> slice:
    start, stop, _ = span.indices(size)
    return slice(max(start - 1, 0), min(stop + 1, size))
