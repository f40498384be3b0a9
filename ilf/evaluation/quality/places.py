"""What the quality checks start from, the surfaces of each block, and what they find, places to check."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from ..._runtime.long_work import check_cancelled
from ...data.blocks import Box, nearest_of_block
from ...data.frame import RGBDFrame
from ...data.pixel_grids import connected_regions, different_labels, mark
from ...segmentation.edges.frame_edges import Relief, find_relief

JUMP, JUMP_SHARE = 0.04, 0.04
"""Difference of neighbours above which there is a jump: the larger of the two [m, share of the nearer depth]."""

_APART, _APART_SHARE = 0.06, 0.04
"""Difference above which two surfaces are distinct: the larger of the two [m, share of the nearer depth]."""

_PIECE = 12
"""Minimum number of known pixels of a piece of a surface; fewer are noise."""

RIM = 3.5
"""Tolerance [px] of a border's position: depth ramps from one surface to the next, so pixels this close to a border are
ignored."""

_PLANE = 60
"""Minimum number of known pixels for the plane of a piece; with fewer, its depth is constant."""


@dataclass(frozen=True, eq=False)
class CheckInput:
    """A frame and its blocks, prepared for the quality checks. Arrays have the shape (H, W).

    Attributes
    ----------
    labels : ndarray of int32
        The label map.
    strength : ndarray of float32
        Edge strength in [0, 1].
    missing : ndarray of bool
        Pixels of blocks that are to be filled.
    depth : ndarray of float32
        Known depth [m] without noise; elsewhere that of the nearest known pixel of any block.
    relief : Relief
        Jumps and bends of the known depth.
    inner : ndarray of bool
        Pixels of blocks farther than `RIM` from any border.
    source : ndarray of intp
        Flat index of the nearest known pixel of the same block; -1 for a block without any, and outside of blocks.
    pieces : ndarray of int32
        Connected pieces of a block's known depth without a jump; 0 elsewhere.
    planes : ndarray of float64, shape (pieces + 1, 3)
        For every piece, the inverse depth [1/m] as a linear function of 1, column and row.
    """

    labels: NDArray[np.int32]
    strength: NDArray[np.float32]
    missing: NDArray[np.bool_]
    depth: NDArray[np.float32]
    relief: Relief
    inner: NDArray[np.bool_]
    source: NDArray[np.intp]
    pieces: NDArray[np.int32]
    planes: NDArray[np.float64]

    def separation(self, one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.float64]:
        """Distance [m] between the surfaces at two known pixels: 0 if one continues the other.

        Parameters
        ----------
        one, other : ndarray of int64, shape (n,)
            Flat indices of known pixels; -1 for none, with distance 0.

        Returns
        -------
        ndarray of float64, shape (n,)
            The smallest of their difference and of the distance of each from the plane of the other.
        """
        depth, pieces = self.depth.ravel().astype(np.float64), self.pieces.ravel()
        near, far = depth[one], depth[other]
        least = np.minimum(near, far)
        difference = np.abs(near - far)
        for here, there in ((one, other), (other, one)):
            rows, columns = np.divmod(there, self.labels.shape[1])
            plane = self.planes[pieces[here]]
            inverse = plane[:, 0] + plane[:, 1] * columns + plane[:, 2] * rows
            ahead = 1 / np.maximum(inverse, 1e-3)
            difference = np.minimum(difference, np.abs(ahead - depth[there]))
        counts = (one >= 0) & (other >= 0) & (difference > np.maximum(_APART, _APART_SHARE * least))
        return np.where(counts, difference, 0.0)


def make_check_input(frame: RGBDFrame, labels: NDArray[np.int32], strength: NDArray[np.float32]) -> CheckInput:
    """Prepare a frame, its blocks, int32 (H, W), and its edge strength for the quality checks."""
    relief = find_relief(frame.depth, JUMP, JUMP_SHARE)
    depth = relief.filled
    check_cancelled()
    border = mark(different_labels(labels)).astype(np.uint8)
    inner = (labels > 0) & (cv2.distanceTransform(1 - border, cv2.DIST_L2, 5) > RIM)
    whole = relief.near & (labels > 0) & ~mark(relief.all_jumps)
    pieces = connected_regions(np.where(whole, labels, 0))
    check_cancelled()
    sure = _sure(frame.known & whole, inner, labels, pieces)
    return CheckInput(
        labels,
        strength,
        ~frame.known & (labels > 0),
        depth,
        relief,
        inner,
        nearest_of_block(labels, sure, 3),
        np.where(sure, pieces, 0),
        _planes(depth, pieces, sure, int(pieces.max()) + 1),
    )


def _sure(
    known: NDArray[np.bool_], inner: NDArray[np.bool_], labels: NDArray[np.int32], pieces: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Known pixels that represent their block: those of pieces that extend into its interior; all without such."""
    deep = np.bincount(pieces[known & inner], minlength=int(pieces.max()) + 1) >= _PIECE
    has_deep = np.zeros(int(labels.max()) + 1, bool)
    has_deep[labels[known & deep[pieces]]] = True
    return known & (deep[pieces] | ~has_deep[labels])


def _planes(
    depth: NDArray[np.float32], pieces: NDArray[np.int32], sure: NDArray[np.bool_], count: int
) -> NDArray[np.float64]:
    rows, columns = np.nonzero(sure)
    check_cancelled()
    owner, inverse = pieces[rows, columns], 1 / depth[rows, columns].astype(np.float64)
    terms = np.stack([np.ones(rows.size), columns, rows])

    def totals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        check_cancelled()
        return np.asarray(np.bincount(owner, values, minlength=count), np.float64)

    squares = np.array([[totals(one * other) for other in terms] for one in terms]).transpose(2, 0, 1)
    sums = np.array([totals(one * inverse) for one in terms]).T
    pixels = np.maximum(squares[:, 0, 0], 1.0)
    # centred at the pieces' means for precision; a small ridge, since all pixels may be collinear
    middle = squares[:, 0, 1:] / pixels[:, None]
    spread = squares[:, 1:, 1:] - pixels[:, None, None] * middle[:, :, None] * middle[:, None, :]
    mean = sums[:, 0] / pixels
    slopes = np.linalg.solve(
        spread + pixels[:, None, None] * np.eye(2), (sums[:, 1:] - mean[:, None] * pixels[:, None] * middle)[..., None]
    )[..., 0]
    slopes[pixels < _PLANE] = 0.0
    return np.column_stack([mean - (slopes * middle).sum(axis=1), slopes])


# A place in a frame where its blocks or its depth look wrong.

KINDS = ("jump", "surfaces", "border", "error", "island", "sliver", "propagated")
"""Depth jump inside a block; two surfaces in a block; weak edge at a border between different depths; high expected
error; a part apart from its block or inside another; a thin part; a propagated block to check."""


@dataclass(frozen=True)
class Place:
    """A place to check, and the reason.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    box : tuple of slice
        Rows and columns of the place.
    labels : tuple of int
        Its blocks, the one to select first; 0 for no block.
    point : tuple of float
        (x, y) in image coordinates: the central pixel's centre.
    score : float
        Number of affected filled pixels times the error [m] in their depth, comparable between all kinds.
    reason : str
        A sentence with the reason; blocks are named by their numbers, as "Block 5".
    """

    kind: str
    box: Box
    labels: tuple[int, ...]
    point: tuple[float, float]
    score: float
    reason: str


def point_in(box: Box, inside: NDArray[np.bool_]) -> tuple[float, float]:
    """The centre (x, y) of the pixel that is nearest to the median of those that a mask marks in a box."""
    rows, columns = np.nonzero(inside)
    away = np.abs(rows - np.median(rows)) + np.abs(columns - np.median(columns))
    nearest = int(np.argmin(away))
    return float(columns[nearest] + box[1].start) + 0.5, float(rows[nearest] + box[0].start) + 0.5


# Places that the user ignores, as long as blocks and known depth around them stay as they are.

_SAME = 30.0
"""Maximum distance [px] at which an ignored place equals another one of the same kind and block."""

_AROUND = 24
"""Distance [px] from the centre of a place, along rows and columns, in which a change makes it another place."""


@dataclass(frozen=True)
class IgnoredPlace:
    """A flagged place that is not to be shown again; stored in projects.

    Attributes
    ----------
    kind : str
    labels : tuple of int
        Its blocks.
    point : tuple of float
        Its centre (x, y) in image coordinates.
    checksum : int
        CRC-32 of the blocks and of the known pixels around it.
    """

    kind: str
    labels: tuple[int, ...]
    point: tuple[float, float]
    checksum: int

    def is_at(self, place: Place) -> bool:
        """Whether a place is of the same kind, block and position."""
        alike = place.kind == self.kind and not set(place.labels).isdisjoint(self.labels)
        return alike and math.dist(place.point, self.point) < _SAME


def ignore(place: Place, frame: RGBDFrame, labels: NDArray[np.int32]) -> IgnoredPlace:
    """Note that a place of a frame with these blocks, int32 (H, W), is ignored."""
    return IgnoredPlace(place.kind, place.labels, place.point, _checksum(place.point, frame, labels))


def without_ignored(
    places: Sequence[Place], ignored: Sequence[IgnoredPlace], frame: RGBDFrame, labels: NDArray[np.int32]
) -> list[Place]:
    """The places that are not ignored, in their order.

    Parameters
    ----------
    places : sequence of Place
    ignored : sequence of IgnoredPlace
        Those around which blocks or known depth have changed since do not count.
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 60, 3), np.uint8), np.full((40, 60), 1.0))
    >>> labels = np.ones((40, 60), np.int32)
    >>> place = Place("jump", (slice(10, 20), slice(10, 20)), (1,), (15.5, 15.5), 3.0, "")
    >>> ignored = ignore(place, frame, labels)
    >>> without_ignored([place], [ignored], frame, labels)
    []
    >>> labels[12, 14] = 2
    >>> without_ignored([place], [ignored], frame, labels) == [place]
    True
    """
    valid = [one for one in ignored if one.checksum == _checksum(one.point, frame, labels)]
    return [place for place in places if not any(one.is_at(place) for one in valid)]


def _checksum(point: tuple[float, float], frame: RGBDFrame, labels: NDArray[np.int32]) -> int:
    column, row = (int(at) for at in point)
    around = tuple(slice(max(at - _AROUND, 0), max(at + _AROUND + 1, 0)) for at in (row, column))
    return zlib.crc32(np.packbits(frame.known[around]).tobytes(), zlib.crc32(labels[around].tobytes()))


# Groups of pixels that form a place.

_GAP = 3
"""Half of the maximum distance [px] between pixels of one group."""

_LARGEST = 60
"""Maximum number of places of one kind."""


def number_groups(pixels: NDArray[np.bool_], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """Number groups 1, 2, ... of nearby mask pixels in one block; 0 elsewhere, int32 (H, W)."""
    square = np.ones((2 * _GAP + 1,) * 2, np.uint8)
    wide = cv2.dilate(pixels.astype(np.uint8), square) > 0
    found = connected_regions(np.where(wide, labels, 0), diagonal=True)
    return np.where(pixels, found, 0).astype(np.int32)


def largest_groups(numbers: NDArray[np.int32], harm: NDArray[Any]) -> Iterator[tuple[Box, NDArray[np.bool_], float]]:
    """The boxes of the groups with the highest harm, their pixels in these, and their harm.

    Parameters
    ----------
    numbers : ndarray of int32, shape (H, W)
        Groups 1, 2, ..., 0 elsewhere.
    harm : ndarray of float, shape (groups + 1,)
        Harm of each, see `Place.score`.
    """
    boxes = find_objects(numbers)
    for number in np.argsort(-harm[1:], kind="stable")[:_LARGEST].tolist():
        box = boxes[number]
        if box is None or harm[number + 1] <= 0:
            continue
        yield box, numbers[box] == number + 1, float(harm[number + 1])
