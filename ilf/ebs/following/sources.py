"""Where the pixels of a frame come from in the one before it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Whole = NDArray[np.intp]
Field = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Sources:
    """For every pixel of the frame after, the pixel before that shows the same point, and how sure that is.

    Attributes
    ----------
    rows, columns : ndarray of intp, shape (H, W)
        The pixel in the frame before; the nearest one of the picture where `seen` is False.
    seen : ndarray of bool, shape (H, W)
        False where the frame before cannot show the point: beyond its rim, or behind something else.
    sure : ndarray of bool, shape (H, W)
        Part of `seen`: pixels that can be relied on.
    still : ndarray of bool, shape (H, W)
        Part of `sure`: pixels that have not changed at all, whose blocks are copied as they are.
    """

    rows: Whole
    columns: Whole
    seen: Mask
    sure: Mask
    still: Mask


def at_their_place(shape: tuple[int, int], still: Mask) -> Sources:
    """Every pixel comes from its own place; those that are not still are not sure."""
    rows, columns = np.indices(shape)
    return Sources(rows, columns, np.ones(shape, bool), still, still)


def nearest(columns: Field, rows: Field) -> tuple[Whole, Whole, Mask]:
    """Rows and columns of the nearest pixels, held inside the picture, and which of them were inside."""
    height, width = rows.shape
    with np.errstate(invalid="ignore"):
        inside = (columns > -0.5) & (columns < width - 0.5) & (rows > -0.5) & (rows < height - 0.5)
    row = np.where(inside, np.rint(np.where(inside, rows, 0)), np.clip(np.nan_to_num(rows), 0, height - 1))
    column = np.where(inside, np.rint(np.where(inside, columns, 0)), np.clip(np.nan_to_num(columns), 0, width - 1))
    return row.astype(np.intp), column.astype(np.intp), inside
