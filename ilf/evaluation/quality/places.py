"""What all kinds of suspicion go by: where depth is known, what it says of each block, and where it would be filled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects
from skimage.measure import label as connected_regions

from ..._runtime.cancellation import check_stopped
from ...data.blocks import Box, find_blocks
from ...data.frame import RGBDFrame
from ...data.pixel_grids import apart, mark
from ...segmentation.edges.relief import Relief, filled_depth, find_relief

JUMP, JUMP_SHARE = 0.04, 0.04
"""Neighbours that differ by more than the larger of the two [m, share of the nearer depth] are parted by a jump."""

_APART, _APART_SHARE = 0.06, 0.04
"""Surfaces that differ by more than the larger of the two [m, share of the nearer depth] are two."""

_PIECE = 12
"""Known pixels that a piece of a surface has at least; fewer are noise."""

RIM = 3.5
"""How far [px] a border may be off its place without harm: depth ramps from one surface to the next, and what lies so
close to a border says nothing of it."""

_PLANE = 60
"""Known pixels from which on a piece has a plane; with fewer, its depth goes on as it is."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A frame and its blocks, seen with the eyes of somebody who looks for mistakes. Arrays have the shape (H, W).

    Attributes
    ----------
    labels : ndarray of int32
        The label map.
    missing : ndarray of bool
        Pixels of blocks that are to be filled.
    depth : ndarray of float32
        Known depth [m] without its noise; elsewhere that of the nearest known pixel, of whichever block.
    relief : Relief
        Its jumps and bends.
    inner : ndarray of bool
        Pixels of blocks farther than `RIM` from any border.
    source : ndarray of int64
        Flat index of the nearest known pixel of the same block; -1 for a block without any, and outside of blocks.
    pieces : ndarray of int32
        What of a block's known depth hangs together without a jump; 0 elsewhere.
    planes : ndarray of float64, shape (pieces + 1, 3)
        Of every piece the inverse depth [1/m] as a linear function of 1, column and row.
    """

    labels: NDArray[np.int32]
    missing: NDArray[np.bool_]
    depth: NDArray[np.float32]
    relief: Relief
    inner: NDArray[np.bool_]
    source: NDArray[np.int64]
    pieces: NDArray[np.int32]
    planes: NDArray[np.float64]

    def apart(self, one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.float64]:
        """How far [m] the surfaces at two known pixels are apart: 0 if one goes on as the other.

        Parameters
        ----------
        one, other : ndarray of int64, shape (n,)
            Flat indices of known pixels; -1 where there is none, which is apart from nothing.

        Returns
        -------
        ndarray of float64, shape (n,)
            The least of their difference and of what each of them differs from where the plane of the other is there.
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


def survey(frame: RGBDFrame, labels: NDArray[np.int32]) -> Ground:
    """The ground of a frame with its blocks, int32 (H, W)."""
    relief = find_relief(frame.depth, JUMP, JUMP_SHARE)
    depth, _ = filled_depth(frame.depth)
    check_stopped()
    border = mark(apart(labels)).astype(np.uint8)
    inner = (labels > 0) & (cv2.distanceTransform(1 - border, cv2.DIST_L2, 5) > RIM)
    whole = relief.near & (labels > 0) & ~mark(relief.all_jumps)
    pieces = np.asarray(connected_regions(np.where(whole, labels, 0), background=0, connectivity=1), np.int32)
    check_stopped()
    sure = _sure(frame.known & whole, inner, labels, pieces)
    return Ground(
        labels,
        ~frame.known & (labels > 0),
        depth,
        relief,
        inner,
        _sources(labels, sure),
        np.where(sure, pieces, 0),
        _planes(depth, pieces, sure, int(pieces.max()) + 1),
    )


def _sure(
    known: NDArray[np.bool_], inner: NDArray[np.bool_], labels: NDArray[np.int32], pieces: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Known pixels that speak for their block: those of pieces that reach into it; all, if there is no such piece."""
    deep = np.bincount(pieces[known & inner], minlength=int(pieces.max()) + 1) >= _PIECE
    has_deep = np.zeros(int(labels.max()) + 1, bool)
    has_deep[labels[known & deep[pieces]]] = True
    return known & (deep[pieces] | ~has_deep[labels])


def _sources(labels: NDArray[np.int32], sure: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Flat index of every pixel's nearest known one of the same block; -1 where there is none."""
    source = np.full(labels.shape, -1, np.int64)
    index = np.arange(labels.size).reshape(labels.shape)
    for block in find_blocks(labels).values():
        known = sure[block.box] & block.mask
        if not known.any():
            continue
        _, nearest = cv2.distanceTransformWithLabels(
            (~known).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
        )
        of_number = np.zeros(int(nearest.max()) + 1, np.int64)
        of_number[nearest[known]] = index[block.box][known]
        source[block.box][block.mask] = of_number[nearest[block.mask]]
    return source


def _planes(
    depth: NDArray[np.float32], pieces: NDArray[np.int32], sure: NDArray[np.bool_], count: int
) -> NDArray[np.float64]:
    rows, columns = np.nonzero(sure)
    check_stopped()
    owner, inverse = pieces[rows, columns], 1 / depth[rows, columns].astype(np.float64)
    terms = np.stack([np.ones(rows.size), columns, rows])

    def totals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        check_stopped()
        return np.asarray(np.bincount(owner, values, minlength=count), np.float64)

    squares = np.array([[totals(one * other) for other in terms] for one in terms]).transpose(2, 0, 1)
    sums = np.array([totals(one * inverse) for one in terms]).T
    pixels = np.maximum(squares[:, 0, 0], 1.0)
    # around the pieces' middles, or the solution loses its digits; a trace of ridge, as all pixels may lie on one line
    middle = squares[:, 0, 1:] / pixels[:, None]
    spread = squares[:, 1:, 1:] - pixels[:, None, None] * middle[:, :, None] * middle[:, None, :]
    mean = sums[:, 0] / pixels
    slopes = np.linalg.solve(
        spread + pixels[:, None, None] * np.eye(2), (sums[:, 1:] - mean[:, None] * pixels[:, None] * middle)[..., None]
    )[..., 0]
    slopes[pixels < _PLANE] = 0.0
    return np.column_stack([mean - (slopes * middle).sum(axis=1), slopes])


# A place in a frame where its blocks, or its depth, look wrong.

KINDS = ("jump", "surfaces", "border", "error", "island", "sliver", "carried")
"""Depth jumps inside a block; a block holds two surfaces; an edge is weak under a border, and a stronger one runs
beside it; high expected error; a part that is parted from its block or lies inside another; a thin part; a block
that came from another frame and needs a look."""


@dataclass(frozen=True)
class Place:
    """Where to look, and why.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    box : tuple of slice
        Rows and columns that it takes up.
    labels : tuple of int
        Blocks that it is about, the one to choose first; 0 stands for no block.
    point : tuple of float
        (x, y) in image coordinates: the pixel centre in the middle of it.
    score : float
        Harm that it may do: filled pixels times the error [m] in their depth. Places of all kinds compare by it.
    reason : str
        A sentence that says what is wrong; blocks are called by their numbers, as "Block 5".
    """

    kind: str
    box: Box
    labels: tuple[int, ...]
    point: tuple[float, float]
    score: float
    reason: str


# Pixels that belong together make a place.

_GAP = 3
"""Pixels of one block not farther apart than twice this [px] belong together."""

_LARGEST = 60
"""Of one kind, no more than so many places are of interest."""


@dataclass(frozen=True, eq=False)
class Group:
    """Pixels of one block that belong together.

    Attributes
    ----------
    label : int
        The block.
    box : tuple of slice
        Rows and columns that they take up.
    rows, columns : ndarray of int64, shape (n,)
        The pixels.
    harm : float
        What they may do, as in `Place.score`.
    """

    label: int
    box: Box
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    harm: float

    @property
    def point(self) -> tuple[float, float]:
        """The pixel that lies nearest to the middle of all, (x, y) of its centre."""
        away = np.abs(self.rows - np.median(self.rows)) + np.abs(self.columns - np.median(self.columns))
        nearest = int(np.argmin(away))
        return float(self.columns[nearest]) + 0.5, float(self.rows[nearest]) + 0.5


def number_groups(pixels: NDArray[np.bool_], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """Groups 1, 2, ... of pixels of a mask that lie close to each other in one block; 0 elsewhere, int32 (H, W)."""
    square = np.ones((2 * _GAP + 1,) * 2, np.uint8)
    wide = cv2.dilate(pixels.astype(np.uint8), square) > 0
    found = connected_regions(np.where(wide, labels, 0), background=0, connectivity=2)
    return np.where(pixels, found, 0).astype(np.int32)


def largest_groups(numbers: NDArray[np.int32], harm: NDArray[Any], labels: NDArray[np.integer]) -> Iterator[Group]:
    """The groups that may do most harm.

    Parameters
    ----------
    numbers : ndarray of int32, shape (H, W)
        Groups 1, 2, ..., 0 elsewhere.
    harm : ndarray of float, shape (groups + 1,)
        Harm of each.
    labels : ndarray of int, shape (H, W)
        The block of every pixel of a group.
    """
    boxes = find_objects(numbers)
    for number in np.argsort(-harm[1:], kind="stable")[:_LARGEST].tolist():
        box = boxes[number]
        if box is None or harm[number + 1] <= 0:
            continue
        rows, columns = np.nonzero(numbers[box] == number + 1)
        rows, columns = rows + box[0].start, columns + box[1].start
        yield Group(int(labels[rows[0], columns[0]]), box, rows, columns, float(harm[number + 1]))
