"""Polygons -> pixels. A pixel (row, column) spans column to column + 1 and row to row + 1; its centre decides."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .stacking import Part, cropped

Points = NDArray[np.float64]
"""(n, 2): x, y."""

_AT_A_TIME = 2**22
"""Crossings of edges and lines of pixels that are worked out together."""

_WAY_OUT = "Is this the file of this frame? If so, correct the shape or export it again."


def points_of(values: Any, where: str, shape: tuple[int, int]) -> Points:
    """Checked corners of a polygon, float64 (n, 2), from pairs or from x, y, x, y, ...

    Parameters
    ----------
    values : anything
        As it stands in the file.
    where : str
        What messages begin with.
    shape : (int, int)
        (H, W) of the image.

    Raises
    ------
    InputError
        If these are no numbers, some are not finite or far off the image, or all lie outside of it, or if there are
        more of them than pixel edges.
    """
    height, width = shape
    most = max(100_000, 4 * (height + 1) * (width + 1))
    if not isinstance(values, list):
        raise InputError(f"{where} has no list of points. {_WAY_OUT}")
    if len(values) > 2 * most:
        raise InputError(f"{where} has more points than the image has pixel edges. {_WAY_OUT}")
    try:
        points = np.asarray(values, np.float64)
        points = points.reshape(-1, 2) if points.ndim < 2 else points
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"{where} has points that are no pairs of numbers. {_WAY_OUT}")
    if len(points) > most:
        raise InputError(f"{where} has more points than the image has pixel edges. {_WAY_OUT}")
    if not np.isfinite(points).all():
        raise InputError(f"{where} has a point that is no number (NaN or infinite). {_WAY_OUT}")
    outside = (points.max(axis=0, initial=-np.inf) < 0) | (points.min(axis=0, initial=np.inf) > (width, height))
    if len(points) and (outside.any() or np.abs(points).max() > 10 * (height + width)):
        raise InputError(f"{where} lies off the image, which is {width} x {height}. {_WAY_OUT}")
    return points


def filled_polygon(points: Points, where: str, shape: tuple[int, int]) -> Part | None:
    """The pixels whose centre lies inside a polygon, by the even-odd rule; None if there are none.

    A line that the polygon follows there and back again changes nothing, so that one polygon can have holes.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        x, y of the corners, as `points_of` gives them; the last is joined to the first.
    where : str
        What messages begin with.
    shape : (int, int)
        (H, W) of the image; what lies outside is cut off.

    Raises
    ------
    InputError
        If it goes to and fro so often that it can only be damaged.

    Examples
    --------
    >>> part = filled_polygon(np.array([[1.0, 0], [3, 0], [3, 2], [1, 2]]), "", (4, 4))
    >>> part.box, part.mask.tolist()
    ((slice(0, 2, None), slice(1, 3, None)), [[True, True], [True, True]])
    """
    height, width = shape
    if len(points) < 3:
        return None
    (x1, y1), (x2, y2) = points.T, np.roll(points, -1, axis=0).T
    # the same edge gives the same crossings whichever way it is gone
    turned = (y2 < y1) | ((y2 == y1) & (x2 < x1))
    x1, x2, y1, y2 = (np.where(turned, *pair) for pair in ((x2, x1), (x1, x2), (y2, y1), (y1, y2)))
    first, stop = (np.clip(np.ceil(y - 0.5), 0, height).astype(np.int64) for y in (y1, y2))
    crossed = stop > first
    if not crossed.any():
        return None
    x1, x2, y1, y2, first, stop = (values[crossed] for values in (x1, x2, y1, y2, first, stop))
    counts = stop - first
    ends = np.cumsum(counts)
    if ends[-1] > 4 * height * width + 1_000_000:
        raise InputError(f"{where} goes to and fro across the image too often to be an outline. {_WAY_OUT}")
    slope = (x2 - x1) / (y2 - y1)
    top = int(first.min())
    toggles = np.zeros((int(stop.max()) - top, width + 1), bool)
    cuts = np.searchsorted(ends, np.arange(_AT_A_TIME, int(ends[-1]), _AT_A_TIME))
    for edges in np.split(np.arange(len(counts)), cuts):
        number = counts[edges]
        of = np.repeat(edges, number)
        rows = first[of] + np.arange(len(of)) - np.repeat(np.cumsum(number) - number, number)
        columns = np.ceil(x1[of] + (rows + 0.5 - y1[of]) * slope[of] - 0.5)
        places = (rows - top) * (width + 1) + np.clip(columns, 0, width).astype(np.int64)
        np.logical_xor.at(toggles.reshape(-1), places, True)
    return cropped(np.logical_xor.accumulate(toggles[:, :width], axis=1), top)
