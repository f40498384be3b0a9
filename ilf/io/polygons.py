"""Conversion between polygons, run lengths and pixels. A pixel (row, column) spans column to column + 1 and row to
row + 1; it is inside if its centre is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from ..data.pixel_grids import connected_regions
from ..errors import InputError
from .labels import Region, cropped

Points = NDArray[np.float64]
"""(n, 2): x, y."""

_CHUNK = 2**22
"""Crossings of edges and pixel rows computed at a time."""

_REMEDY = "Is this the file of this frame? If so, correct the shape or export it again."


def points_of(values: Any, where: str, shape: tuple[int, int]) -> Points:
    """Return the checked vertices of a polygon, float64 (n, 2), from pairs or from x, y, x, y, ...

    Parameters
    ----------
    values : anything
        Value from the file.
    where : str
        Beginning of messages.
    shape : (int, int)
        (H, W) of the image.

    Raises
    ------
    InputError
        If these are not numbers, some are not finite or far outside the image, or all lie outside of it, or if there
        are more of them than pixel edges.
    """
    height, width = shape
    most = max(100_000, 4 * (height + 1) * (width + 1))
    if not isinstance(values, list):
        raise InputError(f"{where} has no list of points. {_REMEDY}")
    try:
        points = np.asarray(values[: 2 * most + 2], np.float64)
        points = points.reshape(-1, 2) if points.ndim < 2 else points
    except (TypeError, ValueError, OverflowError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(f"{where} has points that are not pairs of numbers. {_REMEDY}")
    if len(points) > most:
        raise InputError(f"{where} has more points than the image has pixel edges. {_REMEDY}")
    if not np.isfinite(points).all():
        raise InputError(f"{where} has a point that is not finite. {_REMEDY}")
    outside = (points.max(axis=0, initial=-np.inf) < 0) | (points.min(axis=0, initial=np.inf) > (width, height))
    if len(points) and (outside.any() or np.abs(points).max() > 10 * (height + width)):
        raise InputError(f"{where} lies outside the image, which is {width} x {height}. {_REMEDY}")
    return points


def filled_polygon(points: Points, where: str, shape: tuple[int, int]) -> Region | None:
    """Return the pixels whose centre lies inside a polygon, by the even-odd rule; None if there are none.

    A line that the polygon follows in both directions has no effect, so that one polygon can have holes.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 2)
        x, y of the vertices, from `points_of`; the last is connected to the first.
    where : str
        Beginning of messages.
    shape : (int, int)
        (H, W) of the image, to which the polygon is clipped.

    Raises
    ------
    InputError
        If it crosses the image so often that it must be damaged.

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
    # an edge has the same crossings in either direction
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
        raise InputError(f"{where} crosses the image too often to be an outline. {_REMEDY}")
    slope = (x2 - x1) / (y2 - y1)
    top = int(first.min())
    toggles = np.zeros((int(stop.max()) - top, width + 1), bool)
    cuts = np.searchsorted(ends, np.arange(_CHUNK, int(ends[-1]), _CHUNK))
    for edges in np.split(np.arange(len(counts)), cuts):
        number = counts[edges]
        of = np.repeat(edges, number)
        rows = first[of] + np.arange(len(of)) - np.repeat(np.cumsum(number) - number, number)
        columns = np.ceil(x1[of] + (rows + 0.5 - y1[of]) * slope[of] - 0.5)
        places = (rows - top) * (width + 1) + np.clip(columns, 0, width).astype(np.int64)
        np.logical_xor.at(toggles.reshape(-1), places, True)
    return cropped(np.logical_xor.accumulate(toggles[:, :width], axis=1), top)


# Label map to polygons that follow the edges of its pixels, so that filling them gives the same map again.

_EAST, _SOUTH, _WEST, _NORTH = range(4)


def outline_polygons(labels: NDArray[np.int32]) -> dict[int, list[NDArray[np.int64]]]:
    """Trace the outlines of all blocks: one closed polygon for every 4-connected part.

    A part with holes is also one polygon: a cut along a row of pixels leads to each hole and back.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block.

    Returns
    -------
    dict
        Label -> polygons of its parts, each an array (n, 2) of x, y of pixel corners; the last is connected to the
        first.

    Examples
    --------
    >>> outline_polygons(np.array([[0, 5, 5], [0, 0, 5]], np.int32))[5][0].tolist()
    [[1, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1]]
    """
    parts = connected_regions(labels)
    found: dict[int, list[NDArray[np.int64]]] = {label: [] for label in np.unique(labels[labels > 0]).tolist()}
    for (row, column), points in _traced(parts):
        found[int(labels[row, column])].append(points)
    return found


def _traced(parts: NDArray[np.integer]) -> Iterator[tuple[tuple[int, int], NDArray[np.int64]]]:
    """Yield a pixel of each part, and the part's polygon.

    Each edge between a pixel and another part is directed with the pixel on its right. The next edge belongs to the
    same pixel if it has one there, so the outline of a part is traced edge by edge.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    height, width = parts.shape
    line, corners = width + 1, (height + 1) * (width + 1)
    edges, following = _linked(parts)
    count = len(edges)
    if count == 0:
        return
    direction, start = np.divmod(edges, corners)
    y, x = np.divmod(start, line)
    links = csr_array((np.ones(count, bool), (np.arange(count), following)), shape=(count, count))
    loops, loop = connected_components(links, directed=False)
    # signed area: the part lies on the right of outer borders and of holes, which therefore have opposite directions
    turn = np.bincount(loop, np.where(direction == _SOUTH, x, 0) - np.where(direction == _NORTH, x, 0), loops)
    first_edge = np.full(loops, count)
    np.minimum.at(first_edge, loop, np.arange(count))
    ways = _Loops(following, start)
    southward = np.flatnonzero((direction == _SOUTH) & (turn[loop] < 0))
    southward = southward[np.lexsort((x[southward], loop[southward]))]
    _, leftmost = np.unique(loop[southward], return_index=True)
    for edge in southward[leftmost].tolist():
        # to the left of a hole's leftmost edge, the row of pixels ends at another border of the same part
        row, column = int(y[edge]), int(x[edge]) - 1
        others = np.flatnonzero(parts[row, :column] != parts[row, column])
        opposite = _NORTH * corners + (row + 1) * line + (int(others[-1]) + 1 if others.size else 0)
        ways.join(int(np.searchsorted(edges, opposite)), edge, opposite - line - _NORTH * corners)
    for edge in first_edge[turn > 0].tolist():
        points = np.column_stack(np.divmod(ways.round(edge), line)[::-1])
        # the first edge of each loop leads east, along the top of a pixel
        yield (int(y[edge]), int(x[edge])), _corners_of(points)


def _linked(parts: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return all edges, numbered by direction and start corner, and the index of the next edge of each."""
    height, width = parts.shape
    padded = np.pad(parts, 1)
    above_left, above = padded[:-1, :-1], padded[:-1, 1:]
    below_left, below = padded[1:, :-1], padded[1:, 1:]
    is_edge = np.stack([
        (below > 0) & (below != above),
        (below_left > 0) & (below_left != below),
        (above_left > 0) & (above_left != below_left),
        (above > 0) & (above != above_left),
    ]).ravel()  # fmt: skip
    edges = np.flatnonzero(is_edge)
    corners = (height + 1) * (width + 1)
    direction, start = np.divmod(edges, corners)
    end = start + np.array([1, width + 1, -1, -(width + 1)])[direction]
    right, ahead, left = ((direction + turn) % 4 * corners + end for turn in (1, 0, 3))
    chosen = np.where(is_edge[right], right, np.where(is_edge[ahead], ahead, left))
    return edges, np.searchsorted(edges, chosen)


class _Loops:
    """Closed loops of edges between corners, which can be joined into one."""

    def __init__(self, following: NDArray[np.int64], corner: NDArray[np.int64]) -> None:
        self._next = following.tolist()
        self._corner = corner.tolist()
        self._previous = np.argsort(following).tolist()

    def join(self, edge: int, hole: int, corner: int) -> None:
        """Insert a detour after an edge that ends at a corner: to the start of a hole's edge, round the hole and
        back."""
        there, back, after, last = len(self._next), len(self._next) + 1, self._next[edge], self._previous[hole]
        self._next += [hole, after]
        self._previous += [edge, last]
        self._corner += [corner, self._corner[hole]]
        self._next[edge], self._previous[hole] = there, there
        self._next[last], self._previous[after] = back, back

    def round(self, first: int) -> NDArray[np.int64]:
        """Return the corners of the loop that contains an edge."""
        found, place = [self._corner[first]], self._next[first]
        while place != first:
            found.append(self._corner[place])
            place = self._next[place]
        return np.array(found)


def _corners_of(points: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the points of a closed loop without those on straight lines."""
    into, out = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    straight = (into[:, 0] * out[:, 1] == into[:, 1] * out[:, 0]) & ((into * out).sum(axis=1) > 0)
    return points[~straight]


# Run lengths as in COCO: column by column, downwards, alternating between outside and inside, starting outside.

_RLE_REMEDY = "Export it again."
_LONGEST = 7
"""Maximum number of characters of a run: 35 bits, more than any image has pixels."""


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """Return the run lengths of a mask (H, W).

    Examples
    --------
    >>> run_lengths(np.array([[False, True], [True, True]]))
    [1, 3]
    """
    flat = mask.ravel(order="F")
    bounds = [0, *(np.flatnonzero(flat[1:] != flat[:-1]) + 1).tolist(), flat.size]
    counts = np.diff(bounds).tolist()
    return [0, *counts] if flat[0] else counts


def compressed(counts: list[int]) -> str:
    """Encode run lengths as text: from the fourth on minus the second to last, 5 bits per character, the lowest first.

    Examples
    --------
    >>> compressed([6, 1, 40, 4, 5])
    '61X13mN'
    """
    text = []
    for place, count in enumerate(counts):
        left = count - counts[place - 2] if place > 2 else count
        more = True
        while more:
            bits, left = left & 31, left >> 5
            more = left != (-1 if bits & 16 else 0)
            text.append(chr(48 + bits + 32 * more))
    return "".join(text)


def part_of_runs(segmentation: dict[str, Any], where: str, shape: tuple[int, int]) -> Region | None:
    """Return the pixels of {"size": [H, W], "counts": run lengths or their text}; None if there are none.

    Raises
    ------
    InputError
        If the size is not `shape` (H, W), or the run lengths are damaged or do not add up to it.
    """
    size, counts = segmentation.get("size"), segmentation.get("counts")
    height, width = shape
    if size != [height, width]:
        told = f"{where} is for an image of [height, width] = {size!s:.40}, but the frame is {width} x {height}"
        raise InputError(f"{told}. Use the masks of this frame.")
    if isinstance(counts, str):
        runs = _from_text(counts, where, height * width)
    elif isinstance(counts, list) and all(type(one) is int for one in counts):
        # values out of bounds are clipped to the range of the type and stay out of bounds
        runs = np.array([min(max(one, -1), height * width + 1) for one in counts[: height * width + 2]], np.int64)
    else:
        raise InputError(f"{where} has run lengths that are neither integers nor encoded text. {_RLE_REMEDY}")
    if len(runs) > height * width + 1 or (runs < 0).any() or runs.sum() != height * width:
        pixels = f"the image's {counted(height * width, 'pixel')}"
        raise InputError(f"{where} has run lengths that do not add up to {pixels}. {_RLE_REMEDY}")
    ends = np.cumsum(runs)
    inside = np.flatnonzero(runs[1::2]) * 2 + 1
    if inside.size == 0:
        return None
    # only the columns from the first pixel to the last
    left, right = int(ends[inside[0] - 1]) // height, (int(ends[inside[-1]]) - 1) // height + 1
    ends = np.clip(ends, left * height, right * height)
    clipped = ends - np.concatenate(([left * height], ends[:-1]))
    mask = np.repeat(np.arange(len(runs)) % 2 == 1, clipped).reshape(right - left, height).T
    return cropped(mask, left=left)


def _from_text(text: str, where: str, pixels: int) -> NDArray[np.int64]:
    """Decode run lengths from text."""
    damaged = InputError(f"{where} has damaged run lengths. {_RLE_REMEDY}")
    if not text or not text.isascii() or len(text) > _LONGEST * (pixels + 1):
        raise damaged
    codes = np.frombuffer(text.encode("ascii"), np.uint8).astype(np.int64) - 48
    last = np.flatnonzero((codes & 32) == 0)
    if codes.min() < 0 or codes.max() > 63 or last.size == 0 or last[-1] != codes.size - 1:
        raise damaged
    first = np.concatenate(([0], last[:-1] + 1))
    lengths = last - first + 1
    if lengths.max() > _LONGEST:
        raise damaged
    place = np.arange(codes.size) - np.repeat(first, lengths)
    runs = np.add.reduceat((codes & 31) << (5 * place), first)
    runs -= ((codes[last] & 16) > 0).astype(np.int64) << (5 * lengths)
    if np.abs(runs).max() > pixels:
        raise damaged
    runs[1::2], runs[2::2] = np.cumsum(runs[1::2]), np.cumsum(runs[2::2])
    return runs
