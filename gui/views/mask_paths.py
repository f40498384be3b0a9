"""Masks as paths: their outlines along pixel edges, and their areas."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

from ilf.data.blocks import bounds


def boundary_path(mask: NDArray[np.bool_], x: int = 0, y: int = 0) -> QPainterPath:
    """Outline of a mask, bool (h, w), with its corner at (x, y); empty if no pixel is marked.

    The path follows pixel edges, not centres, so it never covers half a pixel of a neighbouring block.
    """
    box = bounds(mask)
    if box is None:
        return QPainterPath()
    x, y, padded = x + box[1].start, y + box[0].start, np.pad(mask[box], 1)
    rows, left, right = _runs(padded[1:, 1:-1] != padded[:-1, 1:-1])
    columns, top, bottom = _runs((padded[1:-1, 1:] != padded[1:-1, :-1]).T)
    ends_x = np.concatenate((np.column_stack((left, right)).ravel(), np.repeat(columns, 2)))
    ends_y = np.concatenate((np.repeat(rows, 2), np.column_stack((top, bottom)).ravel()))
    return pg.arrayToQPath(
        (ends_x + x).astype(np.float64), (ends_y + y).astype(np.float64), connect="pairs", finiteCheck=False
    )


def filled_path(mask: NDArray[np.bool_]) -> QPainterPath:
    """The pixels of a mask, bool (H, W), as an area to fill."""
    path = QPainterPath()
    for row, left, right in zip(*_runs(mask), strict=True):
        path.addRect(int(left), int(row), int(right - left), 1)
    return path


def _runs(edges: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Row, start and stop of every run of True along the rows."""
    padded = np.pad(edges, ((0, 0), (1, 1)))
    # in a row, starts and stops alternate
    rows, columns = np.divmod(np.flatnonzero(padded[:, 1:] != padded[:, :-1]), edges.shape[1] + 1)
    return rows[::2], columns[::2], columns[1::2]
