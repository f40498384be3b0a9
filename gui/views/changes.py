"""Where two arrays of one shape differ, so that no more than that is drawn anew."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box


def changed_box(before: NDArray[Any], after: NDArray[Any]) -> Box | None:
    """Smallest box (rows, columns) outside of which two arrays (H, W) are equal, NaN being equal to NaN; None for none.

    Both have the same shape and type: bool, or a number of 4 bytes.
    """
    plain = np.bool_ if before.dtype == np.bool_ else np.int32
    return box_of(before.view(plain) != after.view(plain))


def box_of(mask: NDArray[np.bool_]) -> Box | None:
    """Smallest box (rows, columns) that holds all True values of a mask (H, W); None for none."""
    rows = np.flatnonzero(mask.any(axis=1))
    if not rows.size:
        return None
    top, bottom = int(rows[0]), int(rows[-1]) + 1
    columns = np.flatnonzero(mask[top:bottom].any(axis=0))
    return slice(top, bottom), slice(int(columns[0]), int(columns[-1]) + 1)


def union(*boxes: Box | None) -> Box | None:
    """Smallest box that holds all of some boxes; None where all are None."""
    given = [box for box in boxes if box is not None]
    if not given:
        return None
    rows, columns = (
        slice(min(box[axis].start for box in given), max(box[axis].stop for box in given)) for axis in (0, 1)
    )
    return rows, columns


def grown(box: Box, shape: tuple[int, ...], margin: int) -> Box:
    """A box with a margin on each side, as far as an array of this shape has room."""
    rows, columns = (
        slice(max(span.start - margin, 0), min(span.stop + margin, size))
        for span, size in zip(box, shape, strict=False)
    )
    return rows, columns


def whole(shape: tuple[int, ...]) -> Box:
    """The box of all of an array."""
    return slice(0, shape[0]), slice(0, shape[1])
